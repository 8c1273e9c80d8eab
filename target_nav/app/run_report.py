"""The end of a run: the picture, the numbers, one line for a person."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import click

from target_nav.app.run_folder import RunFolder
from target_nav.sim.arena import Arena
from target_nav.state.types import NavState


def finish_run(
    folder: RunFolder,
    arena: Arena,
    data: dict[str, Any],
    trace: Sequence[Sequence[float]],
    states: Sequence[tuple[float, NavState]],
) -> None:
    """Write `result.json` and `run.png`, append to `run.log`, and say how it went."""
    # matplotlib takes most of a second to import
    from target_nav.app.run_picture import draw_run

    line = outcome_line(data)
    folder.write_numbers(data)
    draw_run(folder.picture, arena, trace, states, f"{data['arena']}, seed {data['seed']}: {line}")
    with folder.log.open("a", encoding="utf-8") as log:
        for t_s, state in states:
            log.write(f"{t_s:8.2f} s  {state.name}\n")
        log.write(line + "\n")
    click.echo(line)
    click.echo(f"{folder.path}/: {', '.join(sorted(p.name for p in folder.path.iterdir()))}")


def outcome_line(data: dict[str, Any]) -> str:
    """As `ARRIVED after 31.4 s: stop error +4 mm, bearing +0.8 deg, least clearance 210 mm`."""
    word = {"succeeded": "ARRIVED", "failed": "FAILED", "timeout": "TIMED OUT"}.get(
        data["outcome"], data["outcome"]
    )
    parts = [f"{word} after {data['time_s']:.1f} s"]
    if data["outcome"] != "succeeded":
        parts.append(f": {data['reason'] or 'no reason given'}")
    elif data["stop_error_m"] is not None and data["bearing_error_rad"] is None:
        parts.append(f": {1e3 * data['stop_error_m']:.0f} mm from the goal")
        parts.append(f", least clearance {1e3 * data['min_clearance_m']:.0f} mm")
    elif data["stop_error_m"] is not None:
        stop_mm, bearing_deg = 1e3 * data["stop_error_m"], math.degrees(data["bearing_error_rad"] or 0.0)
        parts.append(f": stop error {stop_mm:+.0f} mm, bearing {bearing_deg:+.1f} deg")
        parts.append(f", least clearance {1e3 * data['min_clearance_m']:.0f} mm")
    if data["outcome"] == "succeeded" and not data["success"]:
        parts.append(" - but not where the target is")
    if data["collided"]:
        parts.append(" - COLLIDED")
    return "".join(parts)

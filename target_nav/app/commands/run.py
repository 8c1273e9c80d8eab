"""`target-nav run`: one mission, on the robot, against the simulator's full stack, or in virtual time."""

from __future__ import annotations

import json
from pathlib import Path

import click

from target_nav.app.extras import require_extra
from target_nav.app.paths import REFERENCE_MISSION, mission_path
from target_nav.app.run_folder import make_run_folder
from target_nav.config import Config
from target_nav.mission import load_mission


@click.command(name="run")
@click.option(
    "--mission", default=REFERENCE_MISSION, show_default=True, help="Mission file, or a name in trees/."
)
@click.option(
    "--sim", "arena_name", metavar="ARENA", help="Arena file or name: simulate. Without it: the robot."
)
@click.option("--virtual", is_flag=True, help="Virtual time, in one process, without ROS.")
@click.option("--pixels", is_flag=True, help="With --virtual: rendered pictures and the trained network.")
@click.option("--seed", default=1, show_default=True, type=click.IntRange(0), help="Of all that is random.")
@click.option(
    "--json", "json_path", type=click.Path(dir_okay=False, path_type=Path), help="Write the result there too."
)
@click.option("--headless", is_flag=True, help="No windows and no redrawing: lines of text only.")
@click.option(
    "--out",
    default="runs",
    show_default=True,
    type=click.Path(file_okay=False, path_type=Path),
    help="Parent of the run's folder.",
)
@click.option(
    "--prefix", default=Config().ipc.prefix, show_default=True, help="Of the shared-memory channels."
)
@click.option("--gui", is_flag=True, help="Open the operator's panel, where there is a display.")
@click.option(
    "--config",
    "config_path",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="YAML file of dotted keys for all processes: lidar.rate_hz: 10.0",
)
@click.option(
    "--settings",
    type=click.Path(dir_okay=False, path_type=Path),
    help="File of the operator's saved changes; without it the robot's own, and none in simulation.",
)
@click.option("--wait", is_flag=True, help="Wait for GO from an operator, and go on after the mission's end.")
@click.pass_context
def command(
    ctx: click.Context,
    mission: str,
    arena_name: str | None,
    virtual: bool,
    pixels: bool,
    seed: int,
    json_path: Path | None,
    headless: bool,
    out: Path,
    prefix: str,
    gui: bool,
    config_path: Path | None,
    settings: Path | None,
    wait: bool,
) -> None:
    """Run a mission. Exit 0: it succeeded; 1: it failed; 2: it could not be run."""
    if virtual and arena_name is None:
        raise click.UsageError("--virtual needs --sim ARENA")
    if pixels and not virtual:
        raise click.UsageError("--pixels goes with --virtual; the full stack always looks at pictures")
    path = mission_path(mission)
    # a mission or an arena that cannot be used is told before anything is started
    load_mission(path)
    if virtual:
        assert arena_name is not None
        data = _run_virtual(arena_name, path, seed, out, pixels)
    else:
        require_extra("mcap", "sim")
        require_extra("matplotlib", "sim")
        from target_nav.app.full_stack import StackOrder, run_stack

        data = run_stack(
            StackOrder(path, arena_name, seed, out, prefix, headless, wait, gui, config_path, settings)
        )
    if json_path is not None:
        json_path.write_text(json.dumps(data) + "\n", encoding="utf-8")
    ctx.exit(0 if data["outcome"] == "succeeded" else 1)


def _run_virtual(arena_name: str, mission: Path, seed: int, out: Path, pixels: bool) -> dict[str, object]:
    from target_nav.sim.arena import load_arena

    arena = load_arena(arena_name)
    require_extra("mcap", "sim")
    require_extra("matplotlib", "sim")
    from target_nav.app.recording import RunRecorder, header_of
    from target_nav.app.run_report import finish_run
    from target_nav.app.virtual import run_virtual

    folder = make_run_folder(out)
    with RunRecorder(folder.recording, header_of(arena.config, load_mission(mission))) as recorder:
        result = run_virtual(arena, mission, seed, recorder, pixels)
    data = result.as_json()
    finish_run(folder, arena, data, result.trace, result.state_changes)
    return data

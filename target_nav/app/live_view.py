"""What a person sees in the terminal while the robot runs: the tree as it ticks, and the numbers beside it.

The tree comes from the executor's snapshot stream over DDS, the numbers from shared memory: the view sees what any
other observer sees. Where there is no terminal, one line a change is printed instead.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Protocol

from rich.columns import Columns
from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from target_nav.state.snapshots import NavSnapshot

# py_trees_ros_interfaces/Behaviour: status
STATUS_MARK = {1: ("·", "dim"), 2: ("▶", "bold cyan"), 3: ("✔", "green"), 4: ("✘", "red")}


class ProcessLine(Protocol):
    """What the view shows of one process."""

    @property
    def name(self) -> str: ...
    @property
    def pid(self) -> int | None: ...
    @property
    def state(self) -> Any: ...
    @property
    def restarts(self) -> int: ...


class View(Protocol):
    def show(
        self, nav: NavSnapshot | None, tree: Sequence[Any], processes: Sequence[ProcessLine]
    ) -> None: ...

    def __enter__(self) -> View: ...

    def __exit__(self, *_: object) -> None: ...


def make_view(console: Console) -> View:
    return TerminalView(console) if console.is_terminal else LineView(console)


class TerminalView:
    """Redraws in place."""

    def __init__(self, console: Console) -> None:
        self._live = Live(console=console, refresh_per_second=8, transient=False)

    def __enter__(self) -> TerminalView:
        self._live.__enter__()
        return self

    def __exit__(self, *error: Any) -> None:
        self._live.__exit__(*error)

    def show(self, nav: NavSnapshot | None, tree: Sequence[Any], processes: Sequence[ProcessLine]) -> None:
        left = Panel(tree_text(tree), title="mission", border_style="dim", width=72)
        right = Group(Panel(_numbers(nav), title="robot"), Panel(_processes(processes), title="processes"))
        self._live.update(Columns([left, right], padding=(0, 1)))


class LineView:
    """One line whenever the state or the running leaf changes."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._last: tuple[str, str] | None = None
        self._begin_s: float | None = None

    def __enter__(self) -> LineView:
        return self

    def __exit__(self, *_: object) -> None:
        """Nothing was taken, nothing is given back."""

    def show(self, nav: NavSnapshot | None, tree: Sequence[Any], processes: Sequence[ProcessLine]) -> None:
        if nav is None:
            return
        self._begin_s = nav.stamp_s if self._begin_s is None else self._begin_s
        key = (nav.state.name, nav.running_leaf)
        if key != self._last:
            self._last = key
            target = f", target {nav.track.range_m:.2f} m" if nav.track is not None else ""
            self._console.print(
                f"{nav.stamp_s - self._begin_s:7.2f} s  {nav.state.name:<15} {nav.running_leaf:<18} "
                f"{nav.rate_hz:5.2f} Hz{target}  {nav.reason}",
                highlight=False,
                soft_wrap=True,
            )


def tree_text(behaviours: Sequence[Any]) -> RenderableType:
    """The tree of `py_trees_ros_interfaces/Behaviour` messages, indented, with a mark per status."""
    if not behaviours:
        return Text("waiting for the executor ...", style="dim")
    by_id = {bytes(b.own_id.uuid): b for b in behaviours}
    root = next(b for b in behaviours if not any(b.parent_id.uuid))
    text = Text(no_wrap=True, overflow="ellipsis")

    def add(behaviour: Any, depth: int) -> None:
        mark, style = STATUS_MARK.get(behaviour.status, ("?", "yellow"))
        text.append("  " * depth + f"{mark} ", style=style)
        text.append(behaviour.name, style=style)
        if behaviour.message and behaviour.status != 1:
            text.append(f"  {behaviour.message}", style="dim")
        text.append("\n")
        for child in behaviour.child_ids:
            add(by_id[bytes(child.uuid)], depth + 1)

    add(root, 0)
    text.rstrip()
    return text


def _numbers(nav: NavSnapshot | None) -> Table:
    table = Table.grid(padding=(0, 2))
    if nav is None:
        table.add_row(Text("no nav process yet", style="dim"))
        return table
    pose, twist, track = nav.pose_in_odom, nav.twist_sent, nav.track
    table.add_row("state", Text(nav.state.name, style="bold"))
    table.add_row("pose", f"{pose.x_m:+.2f} m  {pose.y_m:+.2f} m  {math.degrees(pose.yaw_rad):+.0f}°")
    table.add_row(
        "velocity", f"{twist.vx_mps:+.2f}  {twist.vy_mps:+.2f} m/s  {math.degrees(twist.wz_radps):+.0f} °/s"
    )
    table.add_row("limited by", nav.limited_by or "-")
    if track is not None:
        sure = "" if track.confirmed else " (not confirmed)"
        if track.facing_in_odom_rad is not None:
            sure += f", its face looks to {math.degrees(track.facing_in_odom_rad):+.0f}°"
        table.add_row(
            "target",
            f"{track.range_m:.2f} m  {math.degrees(track.bearing_rad):+.0f}°  ±{track.sigma_m:.2f} m{sure}",
        )
    else:
        table.add_row("target", "-")
    table.add_row(
        "ages", f"scan {nav.scan_age_s:.2f}  odom {nav.odom_age_s:.2f}  camera {nav.camera_age_s:.2f} s"
    )
    table.add_row(
        "loop", f"{nav.rate_hz:.2f} Hz  p99 {1e3 * nav.jitter_p99_s:.1f} ms  {nav.overruns} overruns"
    )
    return table


def _processes(processes: Sequence[ProcessLine]) -> Table:
    table = Table.grid(padding=(0, 2))
    for p in processes:
        state = getattr(p.state, "value", p.state)
        table.add_row(
            p.name,
            f"pid {p.pid}" if p.pid else "-",
            str(state),
            f"{p.restarts} restarts" if p.restarts else "",
        )
    return table

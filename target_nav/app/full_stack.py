"""The full stack in real time, from the terminal: start it, say GO, watch it, stop it, tell how it went."""

from __future__ import annotations

import contextlib
import json
import math
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from rich.console import Console

from behaviours.approach import stand_off_of
from target_nav.app import gui_launch
from target_nav.app.live_view import LineView, View, make_view
from target_nav.app.process_channel import ProcessChannel
from target_nav.app.process_table import StackOptions, robot_stack, simulation_stack
from target_nav.app.robot_ports import arduino_port, lidar_port
from target_nav.app.ros_support import RosNode
from target_nav.app.run_folder import RunFolder, make_run_folder
from target_nav.app.run_report import finish_run, outcome_line
from target_nav.app.settings import default_settings_file, load_config, write_config
from target_nav.app.supervisor import StackState, Supervisor
from target_nav.config import Config
from target_nav.errors import DeviceError
from target_nav.ipc import channels
from target_nav.mission import load_mission
from target_nav.sim.arena import Arena, load_arena
from target_nav.sim.judge import judge
from target_nav.state.snapshots import NavSnapshot
from target_nav.state.types import NavState, Outcome, OutcomeKind, Pose2D, Twist2D

if TYPE_CHECKING:
    from target_nav.app.tree_client import TreeClient

VIEW_PERIOD_S = 0.1
START_LIMIT_S = 60.0
SETTLE_S = 1.5
"""The stack goes on so long after the outcome, so that what is judged is where the robot stays."""

NAV_OLD_S = 2.0


@dataclass(frozen=True)
class StackOrder:
    """What was asked for. `arena_name` None: the robot. `wait`: an operator says GO, and the stack goes on after."""

    mission: Path
    arena_name: str | None
    seed: int
    out: Path
    prefix: str
    headless: bool
    wait: bool
    gui: bool = False
    config: Path | None = None
    """YAML file of dotted keys, over the arena's profile."""
    settings: Path | None = None
    """The operator's saved changes; None: the robot's own file, and none in simulation."""


def run_stack(order: StackOrder) -> dict[str, Any]:
    """Run until the mission's outcome, the arena's time limit or Ctrl-C; the result as JSON values.

    Raises:
        DeviceError, ConfigError, MissionError: it could not be run. Everything is stopped by then.
    """
    arena = load_arena(order.arena_name) if order.arena_name is not None else None
    config = (arena.config if arena is not None else Config()).override({"ipc.prefix": order.prefix})
    if order.config is not None:
        config = load_config(order.config, config)
    _refuse_second_instance(order.prefix)
    # a reader would first meet the last words of an earlier run
    channels.remove(order.prefix)
    folder = make_run_folder(order.out)
    config_file = folder.path / "config.yaml"
    write_config(config, config_file)
    settings_file = order.settings
    if settings_file is None:
        settings_file = default_settings_file() if arena is None else folder.path / "settings.yaml"
    no_panel = gui_launch.problem() if order.gui else ""
    options = StackOptions(
        folder.path,
        str(order.mission),
        order.prefix,
        config_file,
        folder.recording,
        go=not order.wait,
        gui=order.gui and not no_panel,
        settings_file=settings_file.absolute(),
    )
    if order.arena_name is not None:
        specs = simulation_stack(options, order.arena_name, order.seed)
    else:
        saved = load_config(settings_file, config) if settings_file.exists() else config
        specs = robot_stack(options, arduino_port(saved), lidar_port(saved))
    console = Console(soft_wrap=order.headless)
    view: View = LineView(console) if order.headless else make_view(console)
    watch = _Watch(arena.time_limit_s if arena is not None and not order.wait else math.inf, order.wait)
    console.print(
        f"{order.mission.stem} in {order.arena_name or 'the real world'}; everything goes to {folder.path}/"
    )
    if no_panel:
        console.print(no_panel)
    with (
        Supervisor(specs, folder.path) as supervisor,
        contextlib.closing(channels.open_reader(channels.NAV, prefix=order.prefix)) as reader,
        contextlib.closing(ProcessChannel(order.prefix)) as processes,
        _tree_feed(order.headless) as feed,
        view,
    ):
        try:
            while not (watch.over or feed.interrupted):
                state = supervisor.poll()
                watch.see(reader.take_new(), running=state is StackState.RUNNING)
                view.show(watch.nav, feed.behaviours(), supervisor.statuses())
                processes.tell(supervisor.statuses())
                time.sleep(VIEW_PERIOD_S)
        except KeyboardInterrupt:
            watch.interrupted = True
        watch.interrupted = watch.interrupted or feed.interrupted
    return _conclude(order, arena, folder, watch)


class _Watch:
    """Follows the nav process's snapshots until the mission is over."""

    def __init__(self, time_limit_s: float, forever: bool) -> None:
        self.nav: NavSnapshot | None = None
        self.outcome: Outcome | None = None
        self.states: list[tuple[float, NavState]] = []
        self.begin_s: float | None = None
        self.end_s: float | None = None
        self.timeout = False
        self.interrupted = False
        self._time_limit_s = time_limit_s
        self._forever = forever
        self._started_s = time.monotonic()

    def see(self, nav: NavSnapshot | None, running: bool) -> None:
        now_s = time.monotonic()
        if nav is None:
            last_s = self.nav.stamp_s if self.nav is not None else self._started_s
            limit_s = NAV_OLD_S * 5 if running and self.nav is not None else START_LIMIT_S
            if now_s - last_s > limit_s:
                raise DeviceError(
                    f"no word from the nav process for {now_s - last_s:.0f} s (limit {limit_s:.0f} s); see logs/nav.log"
                )
            return
        self.nav = nav
        if nav.requested and self.begin_s is None:
            self.begin_s = nav.stamp_s
        if not self.states or self.states[-1][1] is not nav.state:
            self.states.append((nav.stamp_s, nav.state))
        if nav.outcome is None:
            self.outcome = self.end_s = None
        elif self.outcome is None:
            self.outcome, self.end_s = nav.outcome, nav.stamp_s
        self.timeout = self.begin_s is not None and nav.stamp_s - self.begin_s > self._time_limit_s

    @property
    def over(self) -> bool:
        if self._forever:
            return False
        settled = self.end_s is not None and self.nav is not None and self.nav.stamp_s - self.end_s > SETTLE_S
        return settled or (self.timeout and self.end_s is None)

    @property
    def time_s(self) -> float:
        last_s = self.nav.stamp_s if self.nav is not None else 0.0
        return (self.end_s or last_s) - (self.begin_s or last_s)


def _refuse_second_instance(prefix: str) -> None:
    alive = [c for c in channels.describe(prefix) if c.exists and c.alive]
    if alive:
        raise DeviceError(
            f"another instance (pid {alive[0].writer_pid}) writes {prefix}_{alive[0].name}; stop it, or choose another "
            "--prefix (and another ROS_DOMAIN_ID)"
        )


class _NoTree:
    """For a run without a screen: nothing subscribes, Ctrl-C is a KeyboardInterrupt."""

    interrupted = False

    def behaviours(self) -> Sequence[Any]:
        return ()


class _TreeFeed:
    """The newest tree, as any watcher sees it over DDS. The node takes the signals and tells of them."""

    def __init__(self, ros: RosNode, client: TreeClient) -> None:
        self._ros, self._client = ros, client

    @property
    def interrupted(self) -> bool:
        return self._ros.stop.requested

    def behaviours(self) -> Sequence[Any]:
        return self._client.behaviours()


@contextlib.contextmanager
def _tree_feed(headless: bool) -> Iterator[_NoTree | _TreeFeed]:
    if headless:
        yield _NoTree()
        return
    from target_nav.app.tree_client import TreeClient

    with RosNode("live_view", needs=("py_trees_ros_interfaces.msg",)) as ros:
        client = TreeClient(ros.node)
        ros.every(0.5, client.poll)
        ros.start()
        yield _TreeFeed(ros, client)
        client.close()


def _conclude(order: StackOrder, arena: Arena | None, folder: RunFolder, watch: _Watch) -> dict[str, Any]:
    nav, outcome = watch.nav, watch.outcome
    word = outcome.kind.value if outcome is not None else "interrupted" if watch.interrupted else "timeout"
    data: dict[str, Any] = {
        "arena": arena.name if arena is not None else None,
        "seed": order.seed,
        "mission": order.mission.stem,
        "success": outcome is not None and outcome.kind is OutcomeKind.SUCCEEDED,
        "collided": False,
        "timeout": word == "timeout",
        "time_s": watch.time_s,
        "path_m": None,
        "stop_error_m": None,
        "bearing_error_rad": None,
        "min_clearance_m": None,
        "states": [state.name for _, state in watch.states],
        "outcome": word,
        "reason": outcome.reason if outcome is not None else nav.reason if nav is not None else "",
        "rate_hz": nav.rate_hz if nav is not None else None,
        "lateness_p99_s": nav.jitter_p99_s if nav is not None else None,
        "overruns": nav.overruns if nav is not None else None,
        "ticks": nav.tick if nav is not None else None,
    }
    if arena is None:
        folder.write_numbers(data)
        click.echo(outcome_line(data))
        return data
    truth = json.loads(folder.truth.read_text(encoding="utf-8"))
    data.update(_judged(order, arena, truth, arrived=bool(data["success"])))
    first_s = truth["path"][0][0] if truth["path"] else 0.0
    finish_run(folder, arena, data, truth["path"], [(max(t, first_s), state) for t, state in watch.states])
    if nav is not None:
        click.echo(
            f"{nav.rate_hz:.2f} Hz, lateness p99 {1e3 * nav.jitter_p99_s:.1f} ms, "
            f"{nav.overruns} overruns in {nav.tick} ticks"
        )
    return data


def _judged(order: StackOrder, arena: Arena, truth: dict[str, Any], arrived: bool) -> dict[str, Any]:
    """What the simulator's truth says about the run."""
    verdict = judge(
        arena,
        Pose2D(*_three(truth["pose"])),
        Twist2D(*_three(truth["twist"])),
        stand_off_m=stand_off_of(load_mission(order.mission).root, arena.config),
        reported_arrived=arrived,
        collided=truth["collided"],
        min_clearance_m=truth["min_clearance_m"],
        path_m=truth["path_m"],
    )
    return {
        "success": verdict.success,
        "collided": verdict.collided,
        "path_m": verdict.path_m,
        "stop_error_m": verdict.stop_error_m,
        "bearing_error_rad": verdict.bearing_error_rad,
        "min_clearance_m": verdict.min_clearance_m,
    }


def _three(values: Sequence[float] | dict[str, float]) -> tuple[float, float, float]:
    x, y, z = values.values() if isinstance(values, dict) else values
    return x, y, z

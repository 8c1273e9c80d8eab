"""Process `nav`: ticks a mission's tree at 20 Hz.

ros2 run target_nav tree_executor --mission trees/bowling_pin.xml
"""

from __future__ import annotations

import argparse
import contextlib
import logging
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from target_nav.app.executor_services import ExecutorServices
from target_nav.app.hot_reload import HotReload, ReloadMode
from target_nav.app.nav_core import LoopStatistics, NavCore, Recorder
from target_nav.app.nav_io import NavIo
from target_nav.app.paths import REFERENCE_MISSION, mission_path
from target_nav.app.process import report_ready, run_process
from target_nav.app.ros_parameters import config_from_parameters
from target_nav.app.ros_support import RosNode
from target_nav.app.settings import add_config_arguments, config_from, parse_arguments
from target_nav.app.tree_channel import TreeChannel
from target_nav.app.tree_streams import TreeStreams
from target_nav.config import Config
from target_nav.mission import LoadedMission, load_mission
from target_nav.state.types import Command, CommandKind
from target_nav.utils.rate import RateKeeper, RateStatistics, request_soft_realtime

NODE_NAME = "tree_executor"
REPORT_PERIOD_S = 60.0
STATISTICS_PERIOD_S = 1.0
PICTURE_PERIOD_S = 0.1 - 0.01
"""Of what only screens look at: every second tick."""

log = logging.getLogger(__name__)


def main() -> None:
    parser = argparse.ArgumentParser(prog=NODE_NAME, description="Ticks a mission's tree at 20 Hz.")
    parser.add_argument("--mission", default=REFERENCE_MISSION, help="mission file, or a name in trees/")
    parser.add_argument("--record", metavar="FILE", type=Path, help="record every tick into an MCAP file")
    parser.add_argument("--go", action="store_true", help="begin at once, without waiting for GO")
    parser.add_argument(
        "--reload",
        choices=[mode.value for mode in ReloadMode],
        default=ReloadMode.STILL.value,
        help="take a changed mission file when the robot holds still (default), or only when told to",
    )
    add_config_arguments(parser)
    arguments = parse_arguments(parser)
    sys.exit(run_process("nav", lambda: _run(arguments)))


@dataclass(frozen=True)
class _Loop:
    """What one turn of the loop calls."""

    ros: RosNode
    io: NavIo
    core: NavCore
    streams: TreeStreams
    reload: HotReload
    services: ExecutorServices


def _run(arguments: argparse.Namespace) -> None:
    # everything that can be wrong is found before the robot is touched
    config = config_from(arguments)
    mission = load_mission(mission_path(arguments.mission))
    with contextlib.ExitStack() as stack:
        ros = stack.enter_context(RosNode(NODE_NAME, needs=("tf2_msgs.msg", "py_trees_ros_interfaces.msg")))
        config = config_from_parameters(ros.node, config)
        io = NavIo(ros, config)
        stack.callback(io.close)
        stack.callback(io.stop_wheels)
        recorder = stack.enter_context(_recorder(arguments.record, config, mission))
        core = NavCore(config, mission.root, io, io, recorder)
        core.mission_name = mission.path.stem
        stack.callback(core.close)
        streams = TreeStreams(ros, mission.root)
        stack.callback(streams.close)
        tree_channel = TreeChannel(config.ipc.prefix)
        stack.callback(tree_channel.close)
        streams.add(tree_channel)
        reload = HotReload(mission, core, streams.replace_tree, ReloadMode(arguments.reload))
        stack.callback(reload.close)
        services = ExecutorServices(ros, lambda: reload.checker.problems())
        _start_groot_monitor(stack, ros, core, mission, streams, services)
        if arguments.go:
            io.inject(Command(ros.clock.now_s(), CommandKind.GO))
        ros.start()
        # The first message on a topic waits for DDS's discovery, 0.3 s at worst (measured): before the loop, not in it.
        io.stop_wheels()
        report_ready()
        log.info("mission %s (%s), %g Hz", mission.main_tree, mission.path, config.loop.rate_hz)
        _loop(_Loop(ros, io, core, streams, reload, services), config)


def _start_groot_monitor(
    stack: contextlib.ExitStack,
    ros: RosNode,
    core: NavCore,
    mission: LoadedMission,
    streams: TreeStreams,
    services: ExecutorServices,
) -> None:
    """Groot2's live monitor, if the parameter `groot_port` gives it a port."""
    port = ros.node.declare_parameter("groot_port", 0).value
    if not port:
        return
    # ZeroMQ is an extra: a robot that nobody looks at with Groot2 does without
    from target_nav.app.groot_monitor import GrootMonitor

    def hold(held: bool) -> None:
        core.held = held

    def pause() -> None:
        services.put(CommandKind.PAUSE)

    monitor = GrootMonitor(mission.root, mission.path, port, hold, pause)
    stack.callback(monitor.close)
    streams.add(monitor)


def _loop(parts: _Loop, config: Config) -> None:
    ros, core = parts.ros, parts.core
    for grant in request_soft_realtime(nice=-5):
        log.info("%s", grant)
    rate = RateKeeper(config.loop.rate_hz)
    loop = LoopStatistics()
    next_statistics_s = next_report_s = next_picture_s = 0.0
    while not ros.stop.requested:
        now_s = rate.wait()
        for command in parts.services.take():
            parts.io.inject(command)
        record = core.tick(now_s, loop)
        for line in core.operator.take_firmware_lines(now_s):
            parts.io.send_to_firmware(line)
        parts.streams.after_tick(now_s, ros.clock.now_s())
        parts.reload.after_tick(record)
        if now_s >= next_picture_s:
            parts.io.publish_avoidance(core.avoidance())
            next_picture_s = now_s + PICTURE_PERIOD_S
        ros.check()
        if now_s >= next_statistics_s:
            statistics = rate.statistics()
            loop = _as_loop_statistics(statistics)
            if next_statistics_s and now_s >= next_report_s:
                _report(statistics, core)
                next_report_s = now_s + REPORT_PERIOD_S
            next_report_s = next_report_s or now_s + REPORT_PERIOD_S
            next_statistics_s = now_s + STATISTICS_PERIOD_S
    _report(rate.statistics(), core)


def _as_loop_statistics(s: RateStatistics) -> LoopStatistics:
    return LoopStatistics(s.rate_hz, s.lateness_p50_s, s.lateness_p99_s, s.overruns)


def _report(s: RateStatistics, core: NavCore) -> None:
    slowest = core.probe.slowest
    log.info(
        "%.3f Hz, lateness p50 %.2f ms p99 %.2f ms max %.2f ms, %d overruns in %d ticks, slowest leaf %s %.2f ms",
        s.rate_hz, 1e3 * s.lateness_p50_s, 1e3 * s.lateness_p99_s, 1e3 * s.lateness_max_s, s.overruns, s.count,
        slowest.name or "none", 1e3 * slowest.duration_s,
    )  # fmt: skip


@contextlib.contextmanager
def _recorder(path: Path | None, config: Config, mission: LoadedMission) -> Iterator[Recorder | None]:
    if path is None:
        yield None
        return
    # the MCAP library is an extra: a robot that does not record does without
    from target_nav.app.recording import RunRecorder, header_of

    with RunRecorder(path, header_of(config, mission)) as recorder:
        yield recorder


if __name__ == "__main__":
    main()

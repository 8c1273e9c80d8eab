"""The robot's stack as a service: the supervisor until it is told to stop, with systemd's watchdog.

    python -m target_nav.app.stack_service --mission bowling_pin          what deploy/systemd/target-nav.service runs

The mission waits for an operator's GO. Exit codes: 0 told to stop, 1 a process kept dying (systemd starts all of it
again), 2 it cannot be run like this (systemd does not). The watchdog is fed while the nav process ticks, or while the
supervisor is busy starting something again; a stack that stands still in any other way is killed and begun anew.
"""

from __future__ import annotations

import argparse
import contextlib
import logging
import sys
import time
from pathlib import Path

from target_nav.app import gui_launch
from target_nav.app.paths import REFERENCE_MISSION, mission_path
from target_nav.app.process import EXIT_CANNOT_RUN, EXIT_FAILED, run_process
from target_nav.app.process_channel import ProcessChannel
from target_nav.app.process_spec import ProcessSpec
from target_nav.app.process_table import StackOptions, robot_stack, simulation_stack
from target_nav.app.robot_ports import arduino_port, lidar_port
from target_nav.app.run_folder import make_run_folder
from target_nav.app.settings import (
    add_config_arguments,
    base_config_from,
    default_settings_file,
    load_config,
    parse_arguments,
    write_config,
)
from target_nav.app.supervised import ProcessState
from target_nav.app.supervisor import StackState, Supervisor
from target_nav.app.systemd_notify import SystemdNotifier
from target_nav.config import Config
from target_nav.errors import DeviceError
from target_nav.ipc import channels
from target_nav.mission import load_mission
from target_nav.sim.arena import load_arena
from target_nav.state.snapshots import NavSnapshot

PERIOD_S = 0.1
STATUS_PERIOD_S = 2.0
NAV_QUIET_S = 2.0
"""Forty ticks of the nav process."""

log = logging.getLogger(__name__)


class Health:
    """Whether the stack does its work, from the nav process's snapshots and the supervisor's table."""

    def __init__(self, now_s: float) -> None:
        self._nav: NavSnapshot | None = None
        self._quiet_since_s = now_s

    def see(self, nav: NavSnapshot | None, settled: bool, now_s: float) -> bool:
        """True: fine. `nav` is a new snapshot or None; `settled`: the supervisor has nothing to start at the moment."""
        if nav is not None or not settled:
            self._quiet_since_s = now_s
        self._nav = nav or self._nav
        return now_s - self._quiet_since_s < NAV_QUIET_S

    def __str__(self) -> str:
        nav = self._nav
        return f"{nav.state.name}, {nav.rate_hz:.1f} Hz" if nav is not None else "starting"


def main() -> None:
    parser = argparse.ArgumentParser(prog="stack_service", description="The robot's stack as a service.")
    parser.add_argument("--mission", default=REFERENCE_MISSION, help="mission file, or a name in trees/")
    parser.add_argument(
        "--sim", metavar="ARENA", help="the simulator in place of the robot, to try the service"
    )
    parser.add_argument(
        "--record", action="store_true", help="record the topics into a bag in the run's folder"
    )
    parser.add_argument(
        "--gui", action="store_true", help="open the operator's panel, where there is a display"
    )
    parser.add_argument("--own-lidar-driver", action="store_true", help="even where rplidar_ros is installed")
    parser.add_argument("--out", type=Path, default=Path("runs"), help="parent of the run's folder")
    add_config_arguments(parser)
    arguments = parse_arguments(parser)
    sys.exit(run_process("service", lambda: _run(arguments)))


def _run(arguments: argparse.Namespace) -> int:
    notifier = SystemdNotifier()
    config = base_config_from(arguments)
    if arguments.sim:
        config = load_arena(arguments.sim, config).config
    settings_file = (arguments.settings or default_settings_file()).absolute()
    _refuse_second_instance(config.ipc.prefix)
    # A reader would first meet the last words of an earlier run.
    channels.remove(config.ipc.prefix)
    mission = mission_path(arguments.mission)
    load_mission(mission)
    folder = make_run_folder(arguments.out).path.resolve()
    write_config(config, folder / "config.yaml")
    no_panel = gui_launch.problem() if arguments.gui else ""
    if no_panel:
        log.warning("%s", no_panel)
    options = StackOptions(
        folder,
        str(mission.resolve()),
        config.ipc.prefix,
        folder / "config.yaml",
        bag=folder / "bag" if arguments.record else None,
        own_lidar_driver=arguments.own_lidar_driver,
        gui=arguments.gui and not no_panel,
        settings_file=settings_file,
    )
    if settings_file.exists():
        config = load_config(settings_file, config)
    log.info("%s; everything goes to %s/", mission.stem, folder)
    try:
        with Supervisor(_specs(arguments, options, config), folder) as supervisor:
            try:
                _watch(supervisor, notifier, config.ipc.prefix)
            finally:
                notifier.stopping()
    except DeviceError as error:
        cannot_run = any(status.exit_code == EXIT_CANNOT_RUN for status in supervisor.statuses())
        log.error("%s", error)
        return EXIT_CANNOT_RUN if cannot_run else EXIT_FAILED
    return 0


def _refuse_second_instance(prefix: str) -> None:
    alive = [channel for channel in channels.describe(prefix) if channel.exists and channel.alive]
    if alive:
        raise DeviceError(
            f"another instance (pid {alive[0].writer_pid}) writes {prefix}_{alive[0].name}; stop it first"
        )


def _specs(arguments: argparse.Namespace, options: StackOptions, config: Config) -> tuple[ProcessSpec, ...]:
    if arguments.sim:
        return simulation_stack(options, arguments.sim, seed=1)
    return robot_stack(options, arduino_port(config), lidar_port(config))


def _watch(supervisor: Supervisor, notifier: SystemdNotifier, prefix: str) -> None:
    health = Health(time.monotonic())
    ready, fine = False, True
    told_s = 0.0
    with (
        contextlib.closing(channels.open_reader(channels.NAV, prefix=prefix)) as reader,
        contextlib.closing(ProcessChannel(prefix)) as processes,
    ):
        while True:
            stack = supervisor.poll()
            processes.tell(supervisor.statuses())
            now_s = time.monotonic()
            settled = stack is StackState.RUNNING
            if settled and not ready:
                ready = True
                notifier.ready("the stack runs")
            was_fine, fine = fine, health.see(reader.take_new(), settled, now_s)
            if fine:
                notifier.alive()
            elif was_fine:
                log.error(
                    "the nav process runs and has not ticked for %g s; the watchdog is not fed", NAV_QUIET_S
                )
            if now_s - told_s > STATUS_PERIOD_S:
                told_s = now_s
                restarts = sum(status.restarts for status in supervisor.statuses())
                down = [s.name for s in supervisor.statuses() if s.state is not ProcessState.RUNNING]
                notifier.status(
                    f"{health}, {restarts} restarts" + (f", not running: {', '.join(down)}" if down else "")
                )
            time.sleep(PERIOD_S)


if __name__ == "__main__":
    main()

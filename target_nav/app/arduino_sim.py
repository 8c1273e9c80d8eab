"""An Arduino with its robot behind a pty, and nothing else: for trying the drivetrain without ROS, scans and pictures.

    python -m target_nav.app.arduino_sim --serial-link /tmp/arduino
    target-nav calibrate odometry --port /tmp/arduino

It is the simulator's robot and the firmware that is flashed, in real time. The cable can be pulled (`unplug`) while the
robot goes on: what its firmware does then is what tests look at.
"""

from __future__ import annotations

import argparse
import json
import logging
import select
import sys
import threading
import time
from pathlib import Path

from target_nav.app.process import StopSignal, report_ready, run_process
from target_nav.app.serial_pty import SerialPty
from target_nav.app.settings import add_config_arguments, config_from, parse_arguments
from target_nav.config import Config
from target_nav.sim.arena import Arena, Bounds
from target_nav.sim.simulation import STEP_S, Simulation
from target_nav.state.types import Pose2D

HALL_M = 50.0
"""Half the side of a hall without anything in it."""

log = logging.getLogger(__name__)


class ArduinoSim:
    """One simulated robot, driven by a thread of its own until `close`.

    Bytes are taken the moment they come, so that what a command takes on its way is not this simulator's doing.
    """

    def __init__(self, link: Path, config: Config | None = None, seed: int = 1) -> None:
        arena = Arena("hall", Bounds(-HALL_M, -HALL_M, HALL_M, HALL_M), Pose2D(), config=config or Config())
        self.simulation = Simulation(arena, seed, time.monotonic())
        self._link = link
        self._line: SerialPty | None = None
        self._lock = threading.Lock()
        self._closing = threading.Event()
        self.plug_in()
        self._thread = threading.Thread(target=self._run, name="arduino", daemon=True)
        self._thread.start()

    def plug_in(self) -> None:
        with self._lock:
            self._line = SerialPty(self._link)

    def unplug(self) -> None:
        """Pull the cable: the other side's port is gone, the robot is not."""
        with self._lock:
            line, self._line = self._line, None
        if line is not None:
            line.close()

    def close(self) -> None:
        self._closing.set()
        self._thread.join()
        self.unplug()

    def _run(self) -> None:
        due_s = time.monotonic()
        while not self._closing.is_set():
            due_s += STEP_S
            while (rest_s := due_s - time.monotonic()) > 0.0:
                self._wait_for_bytes(rest_s)
                self._exchange()
            with self._lock:
                self.simulation.step_to(time.monotonic())
            self._exchange()

    def _wait_for_bytes(self, limit_s: float) -> None:
        line = self._line
        if line is None:
            time.sleep(limit_s)
            return
        try:
            select.select([line.fileno()], [], [], limit_s)
        except (OSError, ValueError):
            return  # unplugged meanwhile

    def _exchange(self) -> None:
        with self._lock:
            if self._line is not None:
                self.simulation.serial_write(self._line.read())
                self._line.write(self.simulation.serial_read())


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="arduino_sim", description="A simulated Arduino and robot behind a pty."
    )
    parser.add_argument("--serial-link", type=Path, required=True, help="link to the pty")
    parser.add_argument("--seed", type=int, default=1, help="of everything random")
    add_config_arguments(parser)
    arguments = parse_arguments(parser)
    sys.exit(run_process("arduino_sim", lambda: _run(arguments)))


def _run(arguments: argparse.Namespace) -> None:
    arduino = ArduinoSim(arguments.serial_link, config_from(arguments), arguments.seed)
    with StopSignal() as stop:
        try:
            report_ready()
            log.info("serial line %s", arguments.serial_link)
            while not stop.wait(1.0):
                pass
        finally:
            arduino.close()
            pose = arduino.simulation.true_pose
            log.info("ended at %s", json.dumps([pose.x_m, pose.y_m, pose.yaw_rad]))


if __name__ == "__main__":
    main()

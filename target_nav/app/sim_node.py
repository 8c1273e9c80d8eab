"""Process `sim`: the simulator in real time, in place of the robot's hardware.

    serial line   a pty that answers as the Arduino's firmware does, found under --serial-link
    /scan         sensor_msgs/LaserScan, best effort, stamped with the begin of the turn
    sim_camera    rendered frames in shared memory, for the detector process
    --truth FILE  what really happened, as JSON, once a second and at the end

The loop runs at 100 Hz: bytes in, physics up to now, bytes and scans out. Frames are drawn in a thread beside it.
"""

from __future__ import annotations

import argparse
import json
import logging
import os
import sys
import threading
from contextlib import ExitStack
from dataclasses import asdict
from pathlib import Path
from typing import Any

from target_nav.app.process import report_ready, run_process
from target_nav.app.ros_convert import scan_to_msg
from target_nav.app.ros_support import RosNode, sensor_qos
from target_nav.app.serial_pty import SerialPty
from target_nav.app.settings import add_config_arguments, config_from, parse_arguments
from target_nav.app.sim_camera import SimCamera
from target_nav.errors import ConfigError
from target_nav.ipc import channels
from target_nav.sim.arena import Arena, load_arena
from target_nav.sim.render import Renderer
from target_nav.sim.simulation import Simulation
from target_nav.utils.rate import RateKeeper, request_soft_realtime

LOOP_HZ = 100.0
TRUTH_PERIOD_S = 1.0

PIPELINE_S = 0.03
"""What drawing and detecting take in this stack. The rest of `camera.latency_s` is waited before a frame is drawn."""

PATH_POINTS = 2000
"""Of the path in a truth file written meanwhile; the last one, at the end, has every point."""

SWITCH_INTERVAL_S = 0.001
"""The drawing thread gives the interpreter lock back after so long, five times sooner than by default."""

log = logging.getLogger(__name__)


class SimNode:
    """One simulation and the three doors it has to the outside."""

    def __init__(self, ros: RosNode, arena: Arena, seed: int, serial: SerialPty, write_frame: Any) -> None:
        from sensor_msgs.msg import LaserScan

        self._ros = ros
        self._serial = serial
        self._arena = arena
        self._seed = seed
        self._publish_scan = ros.publisher(LaserScan, "/scan", sensor_qos())
        self._start_s = ros.clock.now_s()
        self.simulation = Simulation(arena, seed, self._start_s)
        config = arena.config
        self._renderer = Renderer(arena, config, self.simulation.camera_mount_error_rad)
        self.camera = SimCamera(self._renderer.draw, write_frame, seed)
        self.rate = RateKeeper(LOOP_HZ)
        self._frame_delay_s = max(config.camera.latency_s - PIPELINE_S, 0.0)
        self._frame_period_s = 1.0 / config.camera.rate_hz
        self._next_frame_s = self._start_s

    def step(self, now_s: float) -> None:
        simulation = self.simulation
        simulation.serial_write(self._serial.read())
        simulation.step_to(now_s)
        self._serial.write(simulation.serial_read())
        for scan in simulation.take_scans():
            self._publish_scan(scan_to_msg(scan, self._ros.clock))
        if now_s >= self._next_frame_s + self._frame_delay_s:
            if simulation.target_moves and (target := simulation.arena_now.target) is not None:
                self._renderer.move_target(target)
            self.camera.expose(simulation.pose_at(self._next_frame_s), self._next_frame_s)
            self._next_frame_s += self._frame_period_s
            if now_s > self._next_frame_s + self._frame_delay_s:
                # The machine stood still: frames nobody took are not made up for.
                self._next_frame_s = now_s - self._frame_delay_s + self._frame_period_s

    def truth(self, whole_path: bool) -> dict[str, Any]:
        """What really happened so far; stamps are monotonic seconds, poses in the arena's frame."""
        simulation = self.simulation
        path = list(simulation.path)
        thinning = 1 if whole_path else max(1, len(path) // PATH_POINTS)
        return {
            "arena": self._arena.name,
            "seed": self._seed,
            "start_s": self._start_s,
            "now_s": simulation.now_s,
            "pose": asdict(simulation.true_pose),
            "twist": asdict(simulation.true_twist),
            "driven_s": simulation.driven_s,
            "collided": simulation.collided,
            "min_clearance_m": simulation.min_clearance_m,
            "target_distance_m": simulation.target_distance_m,
            "path_m": simulation.drive.path_m,
            "camera": asdict(self.camera.statistics),
            "loop": asdict(self.rate.statistics()),
            "serial_lost_bytes": self._serial.lost_bytes,
            "path": path[::thinning],
        }


class TruthWriter:
    """Writes the truth in a thread of its own, one file at a time, each in one step."""

    def __init__(self, path: Path | None, node: SimNode) -> None:
        self._path = path
        self._node = node
        self._thread: threading.Thread | None = None

    def write_soon(self) -> None:
        """Start writing, unless the last one is still being written."""
        if self._path is None or (self._thread is not None and self._thread.is_alive()):
            return
        truth = self._node.truth(whole_path=False)
        self._thread = threading.Thread(target=self._write, args=(truth,), name="truth", daemon=True)
        self._thread.start()

    def write_last(self) -> None:
        """Write everything and wait for it."""
        if self._path is None:
            return
        if self._thread is not None:
            self._thread.join()
        self._write(self._node.truth(whole_path=True))

    def _write(self, truth: dict[str, Any]) -> None:
        assert self._path is not None
        fresh = self._path.with_name(f".{self._path.name}.{os.getpid()}")
        fresh.write_text(json.dumps(truth) + "\n", encoding="utf-8")
        os.replace(fresh, self._path)


def main() -> None:
    parser = argparse.ArgumentParser(prog="sim", description="The simulator in real time.")
    parser.add_argument(
        "--arena", required=True, help="arena file, or the name of one that comes with the package"
    )
    parser.add_argument("--seed", type=int, default=1, help="of everything random")
    parser.add_argument("--serial-link", type=Path, help="link to the pty that stands for the Arduino")
    parser.add_argument("--truth", type=Path, help="JSON file for what really happened")
    add_config_arguments(parser)
    arguments = parse_arguments(parser)
    sys.exit(run_process("sim", lambda: _run(arguments)))


def _run(arguments: argparse.Namespace) -> None:
    config = config_from(arguments)
    arena = load_arena(arguments.arena, config)
    if arguments.seed < 0:
        raise ConfigError(f"--seed is {arguments.seed}; it must be 0 or more")
    if arguments.truth is not None and not arguments.truth.parent.is_dir():
        raise ConfigError(f"--truth {arguments.truth}: there is no folder {arguments.truth.parent}")
    with ExitStack() as stack:
        ros = stack.enter_context(RosNode("sim"))
        frames = channels.open_writer(channels.SIM_CAMERA, prefix=config.ipc.prefix)
        stack.callback(frames.close)
        serial = stack.enter_context(SerialPty(arguments.serial_link))
        node = SimNode(ros, arena, arguments.seed, serial, frames.write)
        stack.callback(node.camera.close)
        truth = TruthWriter(arguments.truth, node)
        stack.callback(truth.write_last)
        log.info("arena %s, seed %d, serial line %s", arena.name, arguments.seed, serial.port)
        sys.setswitchinterval(SWITCH_INTERVAL_S)
        request_soft_realtime()
        ros.start()
        report_ready()
        _loop(ros, node, truth)
        log.info("%s, %s", node.rate.statistics(), node.camera.statistics)


def _loop(ros: RosNode, node: SimNode, truth: TruthWriter) -> None:
    next_truth_s = 0.0
    while not ros.stop.requested:
        now_s = node.rate.wait()
        node.step(now_s)
        ros.check()
        if now_s >= next_truth_s:
            truth.write_soon()
            next_truth_s = now_s + TRUTH_PERIOD_S


if __name__ == "__main__":
    main()

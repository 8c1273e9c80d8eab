"""The drivetrain's path: what a command takes to the wheels, what the arduino node costs, how a square closes.

Everything in real time, through a pty; with ROS also through DDS and the real processes. Peers are the floor under each
figure: a bare write to the same pty, and a bare rclpy node that takes and publishes as many messages and does nothing.
"""

from __future__ import annotations

import json
import math
import multiprocessing
import os
import select
import signal
import statistics
import subprocess
import sys
import tempfile
import time
import tty
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from importlib.util import find_spec
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import serial

from benchmarks import OURS, Row, time_call
from target_nav.app.calibration_drive import Driver, Drivetrain, Odom
from target_nav.config import Config
from target_nav.hardware.arduino_bridge import ArduinoBridge
from target_nav.nav.odometry import OdometryScale
from target_nav.nav.odometry_calibration import square
from target_nav.sim.arena import load_arena
from target_nav.sim.host_firmware import HostFirmware
from target_nav.sim.simulation import Simulation
from target_nav.sim.wheels import Base
from target_nav.state.types import Twist2D

COMMANDS = 1000
PERIOD_S = 0.05
LOAD_S = 20.0
SIDE_M = 2.0
ARENA = "open_floor"
SEED = 1

BARE_NODE = """
import sys, time
import rclpy
from geometry_msgs.msg import Twist
from std_msgs.msg import String
rclpy.init()
node = rclpy.create_node("bare")
node.create_subscription(Twist, "/cmd_vel", lambda message: None, 1)
publisher = node.create_publisher(String, "/arduino/odom_raw", 10)
node.create_timer(0.05, lambda: publisher.publish(String(data="x" * 70)))
print("ready", flush=True)
try:
    rclpy.spin(node)
except BaseException:
    pass
"""


def run() -> list[Row]:
    rows = [*latency_over_the_pty(), *firmware_step()]
    if find_spec("rclpy") is None:
        print("without ROS: only what needs none")
        return rows
    os.environ.setdefault("ROS_DOMAIN_ID", str(os.getpid() % 100 + 1))
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    with tempfile.TemporaryDirectory() as folder:
        return [
            *rows,
            *latency_through_ros(Path(folder)),
            *load_of_the_node(Path(folder)),
            *a_square(Path(folder)),
        ]


# --- a command from one end of the pty to the other ---


def _far_end(pipe: Connection) -> None:
    """The device's end in a process of its own: sends back when each line was there."""
    master, slave = os.openpty()
    tty.setraw(slave)
    pipe.send(os.ttyname(slave))
    data = b""
    while True:
        ready, _, _ = select.select([master, pipe], [], [])
        if pipe in ready:
            return
        data += os.read(master, 4096)
        stamp_s = time.monotonic()
        while b"\n" in data:
            line, _, data = data.partition(b"\n")
            pipe.send((line, stamp_s))


@contextmanager
def far_end() -> Iterator[tuple[str, Connection]]:
    ours, theirs = multiprocessing.get_context("spawn").Pipe()
    process = multiprocessing.get_context("spawn").Process(target=_far_end, args=(theirs,), daemon=True)
    process.start()
    try:
        yield ours.recv(), ours
    finally:
        ours.send("end")
        process.join(5.0)


def one_way(send: Callable[[int], None], pipe: Connection, commands: int = COMMANDS) -> list[float]:
    """Seconds from each call of `send` to the arrival of its line, which has its number in it."""
    taken = []
    for number in range(commands):
        begin_s = time.monotonic()
        send(number)
        while True:
            line, stamp_s = pipe.recv()
            if line.split(b",")[-1] == b"%d" % number:
                break
        taken.append(stamp_s - begin_s)
        time.sleep(0.002)
    return taken


def latency_over_the_pty() -> list[Row]:
    with far_end() as (port, pipe):
        bridge = ArduinoBridge(port, 115200, lambda line, stamp_s: None)
        bridge.open()
        ours = one_way(lambda n: bridge.send_velocity(Twist2D(0.2, 0.0, n / 1000.0)) or _refused(), pipe)
        bridge.close()
    with far_end() as (port, pipe), serial.Serial(port, 115200) as line:

        def write(number: int) -> None:
            line.write(b"VEL,200,0,%d\n" % number)
            line.flush()

        theirs = one_way(write, pipe)
    task = "command to the other end of a pty"
    rows = zip(_percentiles(task, OURS, ours), _percentiles(task, "pyserial: write and flush", theirs))
    return [row for pair in rows for row in pair]


def _refused() -> None:
    raise RuntimeError("the bridge refused a command")


def _percentiles(task: str, name: str, taken: Sequence[float], note: str = "") -> list[Row]:
    cuts = statistics.quantiles(taken, n=100)
    return [
        Row(f"{task}, p50", name, 1e3 * cuts[49], "ms", note),
        Row(
            f"{task}, p99",
            name,
            1e3 * cuts[98],
            "ms",
            note or f"max {1e3 * max(taken):.2f} ms of {len(taken)}",
        ),
    ]


def firmware_step() -> list[Row]:
    firmware = HostFirmware(Config())
    firmware.feed(b"VEL,200,0,300\n", 0.0)
    clock = iter(range(10**9))

    def step() -> None:
        firmware.step(0.01 * next(clock), (1, 2, 3, 4))

    return [Row("one step of the firmware in the simulator", OURS, 1e6 * time_call(step), "us")]


# --- with ROS ---


@contextmanager
def process(module: str, *arguments: str, folder: Path) -> Iterator[subprocess.Popen[bytes]]:
    ready = folder / f"{module}.ready"
    ready.unlink(missing_ok=True)
    with (folder / f"{module}.log").open("wb") as log:
        child = subprocess.Popen(
            [sys.executable, "-m", f"target_nav.app.{module}", *arguments],
            env={**os.environ, "TARGET_NAV_READY_FILE": str(ready)},
            stdout=log,
            stderr=log,
        )
    try:
        deadline_s = time.monotonic() + 60.0
        while not ready.exists():
            if child.poll() is not None or time.monotonic() > deadline_s:
                raise RuntimeError((folder / f"{module}.log").read_text())
            time.sleep(0.05)
        yield child
    finally:
        child.send_signal(signal.SIGINT)
        child.wait(30.0)


class Host:
    """A node that drives, as the nav process does."""

    def __init__(self, ros: Any) -> None:
        from geometry_msgs.msg import Twist

        from target_nav.app.ros_convert import twist_to_msg
        from target_nav.app.ros_support import command_qos

        self.ros = ros
        self._publish = ros.publisher(Twist, "/cmd_vel", command_qos())
        self._message = twist_to_msg

    def drive(self, twist: Twist2D) -> None:
        self._publish(self._message(twist))

    def wait_for(self, topic: str) -> None:
        while not self.ros.node.count_subscribers(topic):
            time.sleep(0.05)
        time.sleep(0.5)


def latency_through_ros(folder: Path) -> list[Row]:
    from target_nav.app.ros_support import RosNode

    with (
        far_end() as (port, pipe),
        process("arduino_node", "--port", port, folder=folder),
        RosNode("bench") as ros,
    ):
        host = Host(ros)
        ros.start()
        host.wait_for("/cmd_vel")
        # Nobody answers VERSION here: it drives after it has asked in vain.
        deadline_s = time.monotonic() + 20.0
        while time.monotonic() < deadline_s:
            host.drive(Twist2D(0.2, 0.0, 0.999))
            time.sleep(PERIOD_S)
            if any(line == b"VEL,200,0,999" for line in _waiting(pipe)):
                break
        taken = one_way(lambda n: host.drive(Twist2D(0.2, 0.0, n / 1000.0)), pipe, 500)
        return _percentiles("/cmd_vel published to VEL at the other end of the pty", OURS, taken)


def _waiting(pipe: Connection) -> list[bytes]:
    lines = []
    while pipe.poll():
        lines.append(pipe.recv()[0])
    return lines


def cpu_s(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def load_of_the_node(folder: Path) -> list[Row]:
    """Share of a core while /cmd_vel comes, and ODOM goes, 20 times a second."""
    from target_nav.app.ros_support import RosNode

    link = str(folder / "arduino")
    task, rows = "CPU at 20 Hz", []
    with process("arduino_sim", "--serial-link", link, folder=folder), RosNode("bench") as ros:
        host = Host(ros)
        ros.start()

        def share_of(pid: int) -> float:
            host.wait_for("/cmd_vel")
            for _ in range(40):
                host.drive(Twist2D(0.1, 0.0, 0.5))
                time.sleep(PERIOD_S)
            begin_s, used_s = time.monotonic(), cpu_s(pid)
            while time.monotonic() - begin_s < LOAD_S:
                host.drive(Twist2D(0.1, 0.0, 0.5))
                time.sleep(PERIOD_S)
            return 100.0 * (cpu_s(pid) - used_s) / (time.monotonic() - begin_s)

        with process("arduino_node", "--port", link, folder=folder) as node:
            rows.append(Row(task, OURS, share_of(node.pid), "% of a core", "arduino_node"))
        bare = subprocess.Popen([sys.executable, "-c", BARE_NODE], stdout=subprocess.PIPE, text=True)
        assert bare.stdout is not None
        bare.stdout.readline()
        rows.append(
            Row(task, "bare rclpy node", share_of(bare.pid), "% of a core", "no serial port, no logic")
        )
        bare.send_signal(signal.SIGINT)
        bare.wait(30.0)
        bare.stdout.close()
    return rows


class RosDrivetrain(Drivetrain):
    """/cmd_vel and /odom as a drivetrain: the calibration's own driver goes through all processes."""

    def __init__(self, host: Host) -> None:
        from nav_msgs.msg import Odometry

        from target_nav.app.ros_convert import odometry_from_msg
        from target_nav.app.ros_support import stream_qos

        self._host, self._heard = host, []
        self.newest: Any = None

        def take(message: Any) -> None:
            self.newest = odometry_from_msg(message, host.ros.clock)
            self._heard.append((self.newest.stamp_s, self.newest.twist_in_base, None))

        host.ros.subscribe(Odometry, "/odom", take, stream_qos())

    @property
    def now_s(self) -> float:
        return time.monotonic()

    def keep(self, twist: Twist2D) -> list[Odom]:
        self._host.drive(twist)
        time.sleep(PERIOD_S)
        taken = list(self._heard)
        del self._heard[: len(taken)]
        return taken

    def stop(self) -> None:
        self._host.drive(Twist2D())


def a_square(folder: Path) -> list[Row]:
    """Twist, DDS, serial line, firmware, motors, encoders, ODOM, odometry node: /odom after a square, and the truth."""
    from target_nav.app.ros_support import RosNode

    link, truth_path, prefix = str(folder / "robot"), folder / "truth.json", f"bench{os.getpid()}"
    no_slip = "drive_sim.slip_rate_per_m=0"
    config = Config().override({"drive_sim.slip_rate_per_m": 0.0})
    plant = Simulation(load_arena(ARENA, config), SEED).drive
    scales = (("forward", plant.forward_scale), ("lateral", plant.lateral_scale))
    set_scales = [word for name, value in scales for word in ("--set", f"odometry.{name}_scale={value}")]
    sim = ("--arena", ARENA, "--seed", str(SEED), "--prefix", prefix, "--serial-link", link, "--set", no_slip)
    try:
        with ExitStack() as stack:
            stack.enter_context(process("sim_node", *sim, "--truth", str(truth_path), folder=folder))
            stack.enter_context(process("arduino_node", "--port", link, folder=folder))
            stack.enter_context(process("odometry_node", *set_scales, folder=folder))
            host = Host(stack.enter_context(RosNode("bench")))
            drivetrain = RosDrivetrain(host)
            host.ros.start()
            host.wait_for("/cmd_vel")
            while drivetrain.newest is None:
                drivetrain.keep(Twist2D())
            begin = drivetrain.newest.pose_in_odom
            true_begin = _truth(truth_path)
            Driver(drivetrain, config, OdometryScale()).drive(square(SIDE_M, 0.25, 0.8))
            end = drivetrain.newest.pose_in_odom
            time.sleep(1.0)
            true_end = _truth(truth_path)
    finally:
        for path in Path("/dev/shm").glob(f"{prefix}_*"):
            path.unlink()
    # The arena's robot looks along x, as odom does at its begin.
    off_x = (true_end["x_m"] - true_begin["x_m"]) - (end.x_m - begin.x_m)
    off_y = (true_end["y_m"] - true_begin["y_m"]) - (end.y_m - begin.y_m)
    corner_m = Base.of(config.robot).lever_m * 0.5 * math.pi
    drift_m = abs(plant.drift_rad_per_m) * math.sqrt(2.0) * SIDE_M * 2.0 * (SIDE_M + corner_m)
    task = f"/odom off after a square of {SIDE_M:g} m"
    closed_m = math.hypot(end.x_m - begin.x_m, end.y_m - begin.y_m)
    return [
        Row(
            task,
            OURS,
            1e3 * math.hypot(off_x, off_y),
            "mm",
            f"/odom itself closes within {1e3 * closed_m:.0f} mm",
        ),
        Row(task, "the plant's drift alone", 1e3 * drift_m, "mm", "what no odometry of wheels can see"),
    ]


def _truth(path: Path) -> dict[str, float]:
    asked_s = time.monotonic()
    while True:
        if path.exists():
            truth = json.loads(path.read_text())
            if truth["now_s"] > asked_s:
                pose: dict[str, float] = truth["pose"]
                return pose
        time.sleep(0.1)

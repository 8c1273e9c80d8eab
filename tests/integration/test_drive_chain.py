"""/cmd_vel to /odom through real processes: simulator, pty, arduino node, odometry node, DDS between them."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from target_nav.app.ros_convert import odometry_from_msg, scan_from_msg, twist_to_msg
from target_nav.app.ros_support import RosNode, command_qos, sensor_qos, tf_qos
from target_nav.ipc import channels
from target_nav.state.types import Odometry, Pose2D, Scan, Twist2D
from tests.utils.processes import Managed, ros_environment, running, wait_until

pytestmark = [pytest.mark.ros, pytest.mark.linux, pytest.mark.slow]

PREFIX = "test_drive"
ARDUINO = "target_nav.app.arduino_node"
ARENA = "open_floor"


class Chain:
    """The three processes, and a node that drives them and listens."""

    def __init__(self, ros: RosNode, folder: Path, arduino: Managed) -> None:
        from geometry_msgs.msg import Twist
        from nav_msgs.msg import Odometry as OdometryMessage
        from sensor_msgs.msg import LaserScan
        from std_msgs.msg import Empty
        from tf2_msgs.msg import TFMessage

        self.arduino = arduino
        self.truth_path = folder / "truth.json"
        self.odometry: list[Odometry] = []
        self.scans: list[Scan] = []
        self.transforms: list[Any] = []
        self._ros = ros
        self._empty = Empty
        self._drive = ros.publisher(Twist, "/cmd_vel", command_qos())
        self._reset = ros.publisher(Empty, "/reset_odom", command_qos())
        clock = ros.clock
        ros.subscribe(
            OdometryMessage,
            "/odom",
            lambda m: self.odometry.append(odometry_from_msg(m, clock)),
            sensor_qos(),
        )
        ros.subscribe(LaserScan, "/scan", lambda m: self.scans.append(scan_from_msg(m, clock)), sensor_qos())
        ros.subscribe(TFMessage, "/tf", lambda m: self.transforms.extend(m.transforms), tf_qos())
        ros.start()
        wait_until(self._is_connected, "discovery")
        # That two nodes know of each other is not yet that messages flow through the whole chain.
        wait_until(lambda: self.drive(Twist2D(), 0.05) > 0.0 and len(self.odometry) > 2, "odometry")

    def drive(self, twist: Twist2D, seconds: float) -> float:
        """Publish at 20 Hz for so long, as the nav process does; the time of the last message."""
        begin_s = last_s = time.monotonic()
        while last_s < begin_s + seconds:
            self._drive(twist_to_msg(twist))
            time.sleep(0.05)
            last_s = time.monotonic()
        return last_s

    def reset(self) -> None:
        self._reset(self._empty())

    def truth(self) -> dict[str, Any]:
        """The next truth that is written."""
        asked_s = time.monotonic()
        found: list[dict[str, Any]] = []

        def read() -> bool:
            found[:] = [json.loads(self.truth_path.read_text())]
            return bool(found[0]["now_s"] > asked_s)

        wait_until(read, "the next truth")
        return found[0]

    def begin(self) -> None:
        """Stand at odom's origin, with nothing heard so far."""
        wait_until(self._stands_at_origin, "standing at the origin")
        for heard in (self.odometry, self.scans, self.transforms):
            heard.clear()

    def _stands_at_origin(self) -> bool:
        # Again and again: a wheel may creep on by a tick after it was still for a moment.
        self.reset()
        self.drive(Twist2D(), 0.2)
        return all(o.pose_in_odom == Pose2D() and o.twist_in_base == Twist2D() for o in self.odometry[-2:])

    def _is_connected(self) -> bool:
        node = self._ros.node
        published = all(node.count_publishers(topic) for topic in ("/odom", "/scan", "/tf"))
        return published and all(node.count_subscribers(topic) for topic in ("/cmd_vel", "/reset_odom"))


@contextmanager
def simulator(folder: Path, prefix: str) -> Iterator[Managed]:
    options = ("--arena", ARENA, "--seed", "1", "--prefix", prefix, "--serial-link", str(folder / "arduino"))
    try:
        with running(
            "target_nav.app.sim_node", *options, "--truth", str(folder / "truth.json"), folder=folder
        ) as sim:
            yield sim
    finally:
        for path in Path("/dev/shm").glob(f"{prefix}_*"):
            path.unlink()


@contextmanager
def started(folder: Path) -> Iterator[Chain]:
    ros_environment()
    with (
        simulator(folder, PREFIX),
        running(ARDUINO, "--port", str(folder / "arduino"), folder=folder) as arduino,
        running("target_nav.app.odometry_node", folder=folder),
        RosNode("test_driver") as ros,
    ):
        yield Chain(ros, folder, arduino)


@pytest.fixture(scope="module")
def started_once(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Chain]:
    with started(tmp_path_factory.mktemp("chain")) as chain:
        yield chain


@pytest.fixture
def chain(started_once: Chain) -> Chain:
    started_once.begin()
    return started_once


def test_two_seconds_of_driving_are_seen_in_odometry_and_end_when_nobody_drives(chain: Chain) -> None:
    before = chain.truth()["pose"]
    chain.begin()
    last_s = chain.drive(Twist2D(0.1, 0.0, 0.0), 2.0)
    way_m = chain.odometry[-1].pose_in_odom.x_m
    assert 0.14 < way_m < 0.24
    assert abs(chain.odometry[-1].pose_in_odom.y_m) < 0.03

    wait_until(lambda: "no /cmd_vel for 0.5 s: STOP" in chain.arduino.log(), "the arduino node's time-out")
    # The firmware reports odometry only while it is driven: its last line tells when STOP came.
    wait_until(lambda: time.monotonic() - chain.odometry[-1].stamp_s > 0.5, "the end of odometry")
    stopped = chain.odometry[-1]
    # On a machine that stalls for 0.2 s the firmware's own watchdog stops first, which is as it should be.
    earliest_s = 0.0 if "WATCHDOG" in chain.arduino.log() else 0.4
    assert earliest_s < stopped.stamp_s - last_s < 1.5
    assert stopped.pose_in_odom.x_m - way_m < 0.2

    truth = chain.truth()
    assert math.hypot(truth["twist"]["vx_mps"], truth["twist"]["vy_mps"]) == 0.0
    after = truth["pose"]
    driven_m = math.hypot(after["x_m"] - before["x_m"], after["y_m"] - before["y_m"])
    # Odometry is off by 2 % at most, and by what it measured of the last moment before STOP.
    assert stopped.pose_in_odom.x_m == pytest.approx(driven_m, rel=0.03, abs=0.02)
    assert not truth["collided"]


def test_a_mecanum_base_turns_and_strafes(chain: Chain) -> None:
    chain.drive(Twist2D(0.0, 0.1, 0.0), 1.5)
    assert chain.odometry[-1].pose_in_odom.y_m > 0.08
    assert abs(chain.odometry[-1].pose_in_odom.x_m) < 0.04
    yaw_rad = chain.odometry[-1].pose_in_odom.yaw_rad
    chain.drive(Twist2D(0.0, 0.0, -0.5), 1.5)
    assert chain.odometry[-1].pose_in_odom.yaw_rad < yaw_rad - 0.4


def test_the_transform_is_the_odometry(chain: Chain) -> None:
    chain.drive(Twist2D(0.1, 0.0, 0.3), 1.0)
    wait_until(lambda: len(chain.transforms) > 5, "transforms")
    transform = chain.transforms[5]
    assert (transform.header.frame_id, transform.child_frame_id) == ("odom", "base_link")
    x_m = transform.transform.translation.x
    assert any(message.pose_in_odom.x_m == x_m for message in chain.odometry)


def test_odometry_can_be_reset_while_driving(chain: Chain) -> None:
    chain.drive(Twist2D(0.2, 0.0, 0.0), 1.5)
    before_m = chain.odometry[-1].pose_in_odom.x_m
    assert before_m > 0.15
    chain.reset()
    chain.drive(Twist2D(0.2, 0.0, 0.0), 0.3)
    assert chain.odometry[-1].pose_in_odom.x_m < before_m


def test_odometry_comes_at_its_rate_and_without_delay(chain: Chain) -> None:
    chain.drive(Twist2D(0.1, 0.0, 0.0), 3.0)
    stamps = [message.stamp_s for message in chain.odometry if message.twist_in_base.vx_mps > 0.05]
    # 20 Hz; a busy machine may lose some.
    assert (len(stamps) - 1) / (stamps[-1] - stamps[0]) == pytest.approx(20.0, abs=4.0)
    assert stamps == sorted(stamps)


def test_scans_come_as_a_turn_each(chain: Chain) -> None:
    wait_until(lambda: len(chain.scans) >= 4, "scans")
    scan = chain.scans[-1]
    assert len(scan.ranges_m) == 360
    assert scan.time_increment_s * 360 == pytest.approx(0.18, abs=0.03)
    # Three metres to the walls of the open floor, with noise and drop-outs.
    near = scan.ranges_m[scan.ranges_m < 12.0]
    assert len(near) > 180
    assert near.min() > 0.15


def test_pictures_come_with_the_time_of_their_exposure(chain: Chain) -> None:
    reader = channels.open_reader(channels.SIM_CAMERA, prefix=PREFIX)
    frames = []

    def take() -> bool:
        frame = reader.take_new()
        if frame is not None:
            frames.append((frame, time.monotonic()))
        return len(frames) >= 5

    wait_until(take, "pictures")
    reader.close()
    for frame, now_s in frames[1:]:
        assert frame.image_bgr.shape == (480, 640, 3)
        assert frame.image_bgr.std() > 5.0
        assert 0.0 < now_s - frame.stamp_s < 2.0
    assert [frame.frame_id for frame, _ in frames] == sorted({frame.frame_id for frame, _ in frames})


def test_a_simulator_that_ends_takes_its_port_away_and_tells_the_truth(tmp_path: Path) -> None:
    with (
        simulator(tmp_path, "test_end") as sim,
        running(ARDUINO, "--port", str(tmp_path / "arduino"), folder=tmp_path) as arduino,
    ):
        assert sim.end() == 0
        assert not (tmp_path / "arduino").is_symlink()
        truth = json.loads((tmp_path / "truth.json").read_text())
        assert truth["arena"] == ARENA
        assert len(truth["path"]) > 1
        wait_until(lambda: "trying to open it again" in arduino.log(), "the loss of the port")
        assert arduino.process.poll() is None


def test_a_second_simulator_on_the_same_channels_is_refused(chain: Chain, tmp_path: Path) -> None:
    second = Managed("target_nav.app.sim_node", ["--arena", ARENA, "--prefix", PREFIX], tmp_path)
    assert second.wait() == 2
    assert "another instance" in second.log()
    assert "Traceback" not in second.log()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--arena", "nowhere"], "nowhere"),
        (["--arena", ARENA, "--seed", "-1"], "0 or more"),
        (["--arena", ARENA, "--truth", "/nowhere/truth.json"], "no folder"),
        (["--arena", ARENA, "--set", "lidar.rate_hz=0"], "must lie in"),
    ],
)
def test_a_simulator_that_cannot_be_run_says_why(tmp_path: Path, options: list[str], message: str) -> None:
    refused = Managed("target_nav.app.sim_node", ["--prefix", "test_refused", *options], tmp_path)
    assert refused.wait() == 2
    assert message in refused.log()
    assert "Traceback" not in refused.log()

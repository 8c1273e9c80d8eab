"""/cmd_vel to /odom through real processes: simulator, pty, arduino node, odometry node, DDS between them."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from target_nav.app.ros_convert import odometry_from_msg, scan_from_msg, twist_to_msg
from target_nav.app.ros_support import RosNode, command_qos, sensor_qos, tf_qos
from target_nav.ipc import channels
from target_nav.state.types import Odometry, Scan, Twist2D
from tests.utils.processes import Managed, ros_environment, running, wait_until

pytestmark = [pytest.mark.ros, pytest.mark.linux, pytest.mark.slow]

PREFIX = "test_drive"
ARENA = "open_floor"


class Chain:
    """The three processes, and a node that drives them and listens."""

    def __init__(self, ros: RosNode, folder: Path, arduino: Managed, sim: Managed) -> None:
        from geometry_msgs.msg import Twist
        from nav_msgs.msg import Odometry as OdometryMessage
        from sensor_msgs.msg import LaserScan
        from std_msgs.msg import Empty
        from tf2_msgs.msg import TFMessage

        self.arduino, self.sim = arduino, sim
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
        truth: dict[str, Any] = json.loads(self.truth_path.read_text())
        return truth

    def _is_connected(self) -> bool:
        node = self._ros.node
        published = all(node.count_publishers(topic) for topic in ("/odom", "/scan", "/tf"))
        return published and all(node.count_subscribers(topic) for topic in ("/cmd_vel", "/reset_odom"))


@pytest.fixture
def chain(tmp_path: Path) -> Iterator[Chain]:
    ros_environment()
    link = tmp_path / "arduino"
    sim_options = ("--arena", ARENA, "--seed", "1", "--prefix", PREFIX, "--serial-link", str(link))
    truth = ("--truth", str(tmp_path / "truth.json"))
    with (
        running("target_nav.app.sim_node", *sim_options, *truth, folder=tmp_path) as sim,
        running("target_nav.app.arduino_node", "--port", str(link), folder=tmp_path) as arduino,
        running("target_nav.app.odometry_node", folder=tmp_path),
        RosNode("test_driver") as ros,
    ):
        yield Chain(ros, tmp_path, arduino, sim)
    for path in Path("/dev/shm").glob(f"{PREFIX}_*"):
        path.unlink()


def test_two_seconds_of_driving_are_seen_in_odometry_and_end_when_nobody_drives(chain: Chain) -> None:
    last_s = chain.drive(Twist2D(0.1, 0.0, 0.0), 2.0)
    way_m = chain.odometry[-1].pose_in_odom.x_m
    assert 0.14 < way_m < 0.24
    assert abs(chain.odometry[-1].pose_in_odom.y_m) < 0.03

    wait_until(lambda: "no /cmd_vel for 0.5 s: STOP" in chain.arduino.log(), "the arduino node's time-out")
    # The firmware reports odometry only while it is driven: its last line tells when STOP came.
    wait_until(lambda: time.monotonic() - chain.odometry[-1].stamp_s > 0.5, "the end of odometry")
    stopped = chain.odometry[-1]
    assert 0.4 < stopped.stamp_s - last_s < 1.5
    assert stopped.pose_in_odom.x_m - way_m < 0.2

    stood_s = chain.truth()["now_s"]
    wait_until(lambda: chain.truth()["now_s"] > stood_s + 1.0, "the next truth")
    truth = chain.truth()
    assert math.hypot(truth["twist"]["vx_mps"], truth["twist"]["vy_mps"]) == 0.0
    driven_m = math.hypot(
        truth["pose"]["x_m"] - truth["path"][0][1], truth["pose"]["y_m"] - truth["path"][0][2]
    )
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


def test_a_simulator_that_ends_takes_its_port_away_and_tells_the_truth(chain: Chain, tmp_path: Path) -> None:
    chain.drive(Twist2D(0.1, 0.0, 0.0), 0.5)
    assert chain.sim.end() == 0
    assert not (tmp_path / "arduino").is_symlink()
    truth = chain.truth()
    assert truth["arena"] == ARENA
    assert truth["path_m"] > 0.0
    wait_until(lambda: "trying to open it again" in chain.arduino.log(), "the loss of the port")
    assert chain.arduino.process.poll() is None

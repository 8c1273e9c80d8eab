"""The odometry node as a real process: what it makes of /arduino/odom_raw, and what becomes of it when it is killed."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from target_nav.app.ros_convert import odometry_from_msg
from target_nav.app.ros_support import RosNode, sensor_qos, stream_qos
from target_nav.state.types import Odometry
from tests.utils.processes import Managed, ros_environment, running, wait_until

pytestmark = [pytest.mark.ros, pytest.mark.linux, pytest.mark.slow]

MODULE = "target_nav.app.odometry_node"


class Feeder:
    """Plays the arduino node at 20 Hz, and listens."""

    def __init__(self, ros: RosNode) -> None:
        from nav_msgs.msg import Odometry as OdometryMessage
        from std_msgs.msg import String

        self._string = String
        self._send = ros.publisher(String, "/arduino/odom_raw", stream_qos())
        self.odometry: list[Odometry] = []
        self.covariances: list[np.ndarray] = []
        self._ros = ros
        ros.subscribe(OdometryMessage, "/odom", self._take, sensor_qos())
        ros.start()

    def say(self, text: str) -> None:
        self._send(self._string(data=text))

    def feed_until(self, condition: Callable[[], bool], what: str, vx_mm: int = 200) -> None:
        def tick() -> bool:
            self.say(json.dumps({"stamp_s": time.monotonic(), "vx_mm": vx_mm, "vy_mm": 0, "wz_mrad": 0}))
            time.sleep(0.05)
            return condition()

        wait_until(tick, what)

    def _take(self, message: object) -> None:
        self.odometry.append(odometry_from_msg(message, self._ros.clock))
        self.covariances.append(np.array(message.pose.covariance).reshape(6, 6))  # type: ignore[attr-defined]


@pytest.fixture
def feeder() -> Iterator[Feeder]:
    ros_environment()
    with RosNode("test_feeder") as ros:
        yield Feeder(ros)


def test_nonsense_is_dropped_and_told(feeder: Feeder, tmp_path: Path) -> None:
    with running(MODULE, folder=tmp_path) as node:
        feeder.feed_until(lambda: len(feeder.odometry) > 3, "odometry")
        feeder.say("no JSON")
        wait_until(lambda: "is not the arduino node's JSON" in node.log(), "a warning")
        count = len(feeder.odometry)
        feeder.feed_until(lambda: len(feeder.odometry) > count, "odometry again")


def test_the_pose_gets_less_certain_with_the_way(feeder: Feeder, tmp_path: Path) -> None:
    with running(MODULE, folder=tmp_path):
        feeder.feed_until(
            lambda: bool(feeder.odometry) and feeder.odometry[-1].pose_in_odom.x_m > 0.1, "ten centimetres"
        )
    forward = [covariance[0, 0] for covariance in feeder.covariances]
    assert forward[-1] > forward[1]
    assert forward == sorted(forward)


def test_a_killed_node_is_succeeded_without_a_jump(feeder: Feeder, tmp_path: Path) -> None:
    state = str(tmp_path / "odometry.state")
    first = Managed(MODULE, ["--state", state], tmp_path)
    first.wait_ready()
    feeder.feed_until(
        lambda: bool(feeder.odometry) and feeder.odometry[-1].pose_in_odom.x_m > 0.3, "thirty centimetres"
    )
    first.process.kill()
    first.process.wait()
    before_m = feeder.odometry[-1].pose_in_odom.x_m
    feeder.odometry.clear()
    first.ready_path.unlink()
    with running(MODULE, "--state", state, folder=tmp_path) as second:
        feeder.feed_until(lambda: bool(feeder.odometry), "the successor", vx_mm=0)
        assert "going on from" in second.log()
    # Some of the predecessor's last messages may not have come here before it was killed.
    assert feeder.odometry[0].pose_in_odom.x_m == pytest.approx(before_m, abs=0.1)


def test_a_state_file_that_cannot_be_is_an_error_that_helps(tmp_path: Path) -> None:
    node = Managed(MODULE, ["--state", str(tmp_path / "nowhere" / "state")], tmp_path)
    assert node.wait() == 2
    assert "cannot be written: No such file" in node.log()

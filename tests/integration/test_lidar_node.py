"""The LiDAR's own driver as a process: simulated device on a pty, real node, /scan over DDS."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from target_nav.app.ros_convert import scan_from_msg
from target_nav.app.ros_support import RosNode, sensor_qos
from target_nav.state.types import Scan
from tests.utils.processes import Managed, ros_environment, running, wait_until
from tests.utils.rplidar_device import PERIOD_S, RplidarDevice, rplidar_device

pytestmark = [pytest.mark.ros, pytest.mark.linux, pytest.mark.slow]

LIDAR = "target_nav.app.lidar_node"


def pin_ahead(angle_deg: float) -> float:
    """Ahead is the device's 180 degrees."""
    return 800.0 if abs(angle_deg - 180.0) < 3.0 else 2500.0


@pytest.fixture
def device(tmp_path: Path) -> Iterator[RplidarDevice]:
    with rplidar_device(tmp_path / "lidar", pin_ahead) as device:
        yield device


@pytest.fixture
def node(device: RplidarDevice, tmp_path: Path) -> Iterator[Managed]:
    with running(LIDAR, "--port", str(device.link), folder=tmp_path) as node:
        yield node


@pytest.fixture
def scans(node: Managed) -> Iterator[list[Scan]]:
    from sensor_msgs.msg import LaserScan

    ros_environment()
    heard: list[Scan] = []
    with RosNode("test_listener") as ros:
        clock = ros.clock
        ros.subscribe(LaserScan, "/scan", lambda m: heard.append(scan_from_msg(m, clock)), sensor_qos())
        ros.start()
        yield heard


def cpu_s(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def test_scans_are_published_as_a_turn_each(
    scans: list[Scan], node: Managed, record_property: pytest.RecordProperty
) -> None:
    wait_until(lambda: len(scans) >= 3, "scans")
    cpu_before_s, begin_s, begun = cpu_s(node.process.pid), time.monotonic(), len(scans)
    wait_until(lambda: len(scans) >= begun + 15, "more scans")
    spent_s = time.monotonic() - begin_s
    record_property("cpu_share", round((cpu_s(node.process.pid) - cpu_before_s) / spent_s, 4))
    print(f"lidar node: {100 * (cpu_s(node.process.pid) - cpu_before_s) / spent_s:.1f} % of a core")

    scan = scans[-1]
    assert len(scan.ranges_m) == 360
    bearings = scan.angle_min_rad + np.arange(360) * scan.angle_increment_rad
    pin = scan.ranges_m < 1.0
    assert np.degrees(np.abs(bearings[pin])).max() < 4.5
    assert 5 <= pin.sum() <= 8
    assert np.all(scan.ranges_m[~pin] == 2.5)
    stamps = np.array([scan.stamp_s for scan in scans])
    assert np.median(np.diff(stamps)) == pytest.approx(PERIOD_S, rel=0.1)
    # A scan is stamped with its first beam, a turn before it could be published.
    assert time.monotonic() - scan.stamp_s > PERIOD_S


def test_a_lost_lidar_is_reported_and_comes_back(
    scans: list[Scan], node: Managed, device: RplidarDevice
) -> None:
    wait_until(lambda: len(scans) >= 1, "scans")
    device.unplug()
    wait_until(lambda: "is lost" in node.log(), "the loss in the log")
    assert node.process.poll() is None
    device.plug_in()
    wait_until(lambda: "is back" in node.log(), "the return in the log")
    begun = len(scans)
    wait_until(lambda: len(scans) >= begun + 2, "scans after the return")


def test_the_motor_and_the_scan_end_with_the_process(node: Managed, device: RplidarDevice) -> None:
    assert node.end() == 0
    wait_until(lambda: device.requests[-1] == 0x25, "STOP")
    assert "LidarStatistics" in node.log()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--port", "/dev/no_such_lidar", "--wait", "0"], "no serial port /dev/no_such_lidar for the LiDAR"),
        (["--set", "lidar.baud=7"], "lidar.baud is 7 baud; it must lie in"),
    ],
)
def test_a_lidar_that_cannot_be_run_is_told(options: list[str], message: str, tmp_path: Path) -> None:
    node = Managed(LIDAR, options, tmp_path)
    assert node.wait() == 2
    assert message in node.log()
    assert "Traceback" not in node.log()

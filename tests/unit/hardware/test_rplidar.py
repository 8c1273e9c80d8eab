"""The driver against a simulated RPLidar on a pty: start, scans, loss and return, refusals."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import serial

from target_nav.config import LidarConfig
from target_nav.errors import DeviceError
from target_nav.hardware import rplidar, rplidar_start
from target_nav.hardware.rplidar import RpLidar
from target_nav.hardware.rplidar_protocol import HealthStatus
from target_nav.state.types import Scan
from tests.utils.rplidar_device import PERIOD_S, SERIAL_NUMBER, RplidarDevice, rplidar_device

pytestmark = pytest.mark.linux

PATIENCE_S = 15.0

PACE = 3.0
"""The simulated device turns so much faster, to save time."""


def wall_and_pin(angle_deg: float) -> float:
    """A room of 2 m with a thing 0.7 m away, 10 degrees wide at the device's 90 degrees, and nothing over 300."""
    if 85.0 <= angle_deg <= 95.0:
        return 700.0
    return 0.0 if angle_deg > 300.0 else 2000.0


class Heard:
    """What the driver reported, with a way to wait for it."""

    def __init__(self) -> None:
        self.scans: list[Scan] = []
        self.connections: list[bool] = []
        self.reasons: list[str] = []
        self._changed = threading.Condition()

    def take_scan(self, scan: Scan) -> None:
        with self._changed:
            self.scans.append(scan)
            self._changed.notify_all()

    def take_connection(self, connected: bool, reason: str) -> None:
        with self._changed:
            self.connections.append(connected)
            self.reasons.append(reason)
            self._changed.notify_all()

    def wait_for(self, condition: Callable[[], bool]) -> None:
        with self._changed:
            assert self._changed.wait_for(condition, PATIENCE_S), (len(self.scans), self.reasons)

    def wait_for_scans(self, count: int) -> list[Scan]:
        begin = len(self.scans)
        self.wait_for(lambda: len(self.scans) >= begin + count)
        return self.scans[begin:]


@pytest.fixture
def device(tmp_path: Path) -> Iterator[RplidarDevice]:
    with rplidar_device(tmp_path / "lidar", wall_and_pin) as device:
        device.pace = PACE
        yield device


@pytest.fixture
def heard() -> Heard:
    return Heard()


@pytest.fixture
def lidar(device: RplidarDevice, heard: Heard) -> Iterator[RpLidar]:
    lidar = RpLidar(LidarConfig(port=str(device.link)), heard.take_scan, heard.take_connection)
    lidar.open()
    yield lidar
    lidar.close()


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Do not wait as long as a real one takes."""
    monkeypatch.setattr(rplidar_start, "ANSWER_S", 0.3)
    monkeypatch.setattr(rplidar_start, "RESET_S", 0.05)
    monkeypatch.setattr(rplidar, "SILENCE_S", 0.6)


def test_it_is_asked_after_its_health_and_name_before_it_scans(lidar: RpLidar, device: RplidarDevice) -> None:
    assert device.requests == [0x25, 0x52, 0x50, 0x20]
    assert lidar.info is not None
    assert (lidar.info.firmware, lidar.info.serial_number) == ("1.29", SERIAL_NUMBER.hex().upper())
    assert lidar.health is not None
    assert lidar.health.status is HealthStatus.GOOD


def test_scans_show_what_stands_around(lidar: RpLidar, heard: Heard) -> None:
    before_s = time.monotonic()
    scan = heard.wait_for_scans(3)[-1]
    bearings = np.degrees(scan.angle_min_rad + np.arange(360) * scan.angle_increment_rad)
    pin = np.flatnonzero(scan.ranges_m == 0.7)
    # The device's 90 degrees, clockwise from behind, are to the left.
    assert bearings[pin].mean() == pytest.approx(90.0, abs=1.0)
    assert 9 <= len(pin) <= 12
    assert 57 <= np.isinf(scan.ranges_m).sum() <= 63
    assert scan.time_increment_s * 360 == pytest.approx(PERIOD_S / PACE, rel=0.3)
    assert before_s - 1.0 < scan.stamp_s < time.monotonic() - 0.5 * PERIOD_S / PACE
    assert (lidar.statistics.resyncs, lidar.statistics.skipped_bytes) == (0, 0)


def test_a_scan_left_running_by_somebody_else_is_ended_first(device: RplidarDevice, heard: Heard) -> None:
    port = serial.Serial(str(device.link))
    port.write(b"\xa5\x20")
    port.read(300)
    port.close()
    lidar = RpLidar(LidarConfig(port=str(device.link)), heard.take_scan)
    lidar.open()
    heard.wait_for_scans(1)
    lidar.close()
    assert device.requests[:5] == [0x20, 0x25, 0x52, 0x50, 0x20]


def test_closing_ends_the_scan(device: RplidarDevice, heard: Heard) -> None:
    lidar = RpLidar(LidarConfig(port=str(device.link)), heard.take_scan)
    lidar.open()
    lidar.close()
    lidar.close()
    deadline_s = time.monotonic() + PATIENCE_S
    while device.requests[-1] != 0x25 and time.monotonic() < deadline_s:
        time.sleep(0.01)
    sent = device.sent_samples
    time.sleep(0.05)
    assert device.sent_samples == sent
    assert not lidar.statistics.connected


def test_the_motor_hangs_on_dtr(monkeypatch: pytest.MonkeyPatch, device: RplidarDevice) -> None:
    orders: list[bool] = []
    # A pty has no DTR: what the driver asks of it is looked at instead.
    monkeypatch.setattr(serial.Serial, "_update_dtr_state", lambda port: orders.append(port._dtr_state))
    started = rplidar_start.start_lidar(str(device.link), 115200)
    assert orders == [False]
    rplidar_start.stop_lidar(started.port)
    assert orders == [False, True]
    assert not started.port.is_open


def test_an_unplugged_lidar_is_started_again(lidar: RpLidar, device: RplidarDevice, heard: Heard) -> None:
    heard.wait_for_scans(1)
    device.unplug()
    heard.wait_for(lambda: heard.connections == [False])
    assert not lidar.statistics.connected
    device.plug_in()
    heard.wait_for(lambda: heard.connections == [False, True])
    heard.wait_for_scans(2)
    assert lidar.statistics.connects == 2


@pytest.mark.usefixtures("quick")
def test_a_silent_lidar_is_started_again(lidar: RpLidar, device: RplidarDevice, heard: Heard) -> None:
    heard.wait_for_scans(1)
    device.mute = True
    heard.wait_for(lambda: heard.connections == [False])
    assert heard.reasons[0].startswith("for 0.6 s it sent ")
    device.mute = False
    heard.wait_for(lambda: heard.connections[-1])
    heard.wait_for_scans(1)


@pytest.mark.usefixtures("quick")
def test_a_head_that_stands_is_told(lidar: RpLidar, device: RplidarDevice, heard: Heard) -> None:
    heard.wait_for_scans(1)
    device.head_stands = True
    heard.wait_for(lambda: heard.connections == [False])
    assert "bytes but no whole turn; does its head turn freely?" in heard.reasons[0]
    device.head_stands = False
    heard.wait_for(lambda: heard.connections[-1])
    heard.wait_for_scans(1)


def test_damaged_bytes_cost_beams_and_not_scans(lidar: RpLidar, device: RplidarDevice, heard: Heard) -> None:
    heard.wait_for_scans(1)
    written = 0

    def damage(data: bytes) -> bytes:
        """Two bytes wrong and two lost, every 100 samples."""
        nonlocal written
        written += len(data)
        if written < 500:
            return data
        written = 0
        return data[:3] + b"\xff\x00" + data[7:]

    device.damage = damage
    scans = heard.wait_for_scans(4)[1:]
    assert lidar.statistics.resyncs >= 4
    for scan in scans:
        assert 200 < np.isfinite(scan.ranges_m).sum() < 298
        assert set(np.unique(scan.ranges_m)) <= {0.7, 2.0, math.inf}


def test_a_banner_of_a_device_that_starts_by_itself_does_not_confuse(
    lidar: RpLidar, device: RplidarDevice, heard: Heard
) -> None:
    heard.wait_for_scans(1)
    device.say(b"RP LIDAR System.\r\nFirmware Ver 1.29\r\n")
    scans = heard.wait_for_scans(3)
    assert set(np.unique(scans[-1].ranges_m)) == {0.7, 2.0, math.inf}


@pytest.mark.usefixtures("quick")
def test_a_lidar_that_protects_itself_is_reset(device: RplidarDevice, heard: Heard) -> None:
    device.health, device.heals_on_reset = (2, 0x8001), True
    lidar = RpLidar(LidarConfig(port=str(device.link)), heard.take_scan)
    lidar.open()
    heard.wait_for_scans(1)
    lidar.close()
    assert 0x40 in device.requests


@pytest.mark.usefixtures("quick")
def test_a_broken_lidar_is_told(device: RplidarDevice, heard: Heard) -> None:
    device.health = (2, 0x8001)
    with pytest.raises(DeviceError, match=r"protect itself \(error 0x8001\) and a reset did not help"):
        RpLidar(LidarConfig(port=str(device.link)), heard.take_scan).open()


@pytest.mark.usefixtures("quick")
def test_a_port_behind_which_nothing_answers_is_told(device: RplidarDevice, heard: Heard) -> None:
    device.mute = True
    with pytest.raises(
        DeviceError, match=r"answered nothing to GET_HEALTH within 0.3 s .* is it an RPLidar A1"
    ):
        RpLidar(LidarConfig(port=str(device.link)), heard.take_scan).open()
    # and the port is free again
    serial.Serial(str(device.link), 115200, exclusive=True).close()


def test_a_lidar_that_appears_in_time_is_taken(tmp_path: Path, heard: Heard) -> None:
    link = tmp_path / "lidar"
    devices: list[RplidarDevice] = []
    timer = threading.Timer(0.2, lambda: devices.append(RplidarDevice(link)))
    timer.start()
    lidar = RpLidar(LidarConfig(port=str(link)), heard.take_scan)
    lidar.open(wait_s=PATIENCE_S)
    heard.wait_for_scans(1)
    lidar.close()
    devices[0].close()


def test_an_error_in_the_handler_is_not_swallowed(device: RplidarDevice) -> None:
    failed = threading.Event()

    def handler(scan: Scan) -> None:
        failed.set()
        raise RuntimeError("handler")

    lidar = RpLidar(LidarConfig(port=str(device.link)), handler)
    lidar.open()
    assert failed.wait(PATIENCE_S)
    lidar.close()
    with pytest.raises(RuntimeError, match="handler"):
        lidar.raise_failure()


def test_a_port_that_cannot_be_opened_names_the_lidar(tmp_path: Path, heard: Heard) -> None:
    with pytest.raises(DeviceError, match=r"there is no serial port .* for the LiDAR"):
        RpLidar(LidarConfig(port=str(tmp_path / "ttyUSB0")), heard.take_scan).open()

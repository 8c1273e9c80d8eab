"""The bridge on a real pty: byte-level input, lost ports, ports that cannot be opened."""

from __future__ import annotations

import os
import select
import threading
import tty
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from target_nav.errors import DeviceError
from target_nav.hardware.arduino_bridge import ArduinoBridge
from target_nav.hardware.protocol import (
    AckLine,
    DeviceLine,
    LineAssembler,
    OdomLine,
    StopCommand,
    parse_command,
)
from target_nav.state.types import Twist2D

pytestmark = pytest.mark.linux

PATIENCE_S = 10.0


class Device:
    """The far end of a serial line, behind a link that survives it being unplugged."""

    def __init__(self, link: Path) -> None:
        self.link = link
        self.plug_in()

    def plug_in(self) -> None:
        self.master, self.slave = os.openpty()
        tty.setraw(self.slave)
        self.link.unlink(missing_ok=True)
        self.link.symlink_to(os.ttyname(self.slave))

    def unplug(self) -> None:
        self.link.unlink()
        os.close(self.slave)
        os.close(self.master)

    def say(self, data: bytes) -> None:
        os.write(self.master, data)

    def hear(self, count: int) -> bytes:
        return os.read(self.master, count)

    def hear_whole(self, expected: bytes) -> bytes:
        """As many bytes as are expected: one read may hand over less, for the bridge writes in a thread."""
        heard = b""
        while len(heard) < len(expected) and select.select([self.master], [], [], PATIENCE_S)[0]:
            heard += self.hear(len(expected) - len(heard))
        return heard


class Heard:
    """What the bridge reported, with a way to wait for it."""

    def __init__(self) -> None:
        self.lines: list[tuple[DeviceLine, float]] = []
        self.connections: list[bool] = []
        self._changed = threading.Condition()

    def take_line(self, line: DeviceLine, stamp_s: float) -> None:
        with self._changed:
            self.lines.append((line, stamp_s))
            self._changed.notify_all()

    def take_connection(self, connected: bool, reason: str) -> None:
        with self._changed:
            self.connections.append(connected)
            self._changed.notify_all()

    def wait_for(self, condition: Callable[[], bool]) -> None:
        with self._changed:
            assert self._changed.wait_for(condition, PATIENCE_S), (self.lines, self.connections)


@pytest.fixture
def device(tmp_path: Path) -> Iterator[Device]:
    device = Device(tmp_path / "arduino")
    yield device
    for end in (device.slave, device.master):
        try:
            os.close(end)
        except OSError:
            continue


@pytest.fixture
def heard() -> Heard:
    return Heard()


@pytest.fixture
def bridge(device: Device, heard: Heard) -> Iterator[ArduinoBridge]:
    bridge = ArduinoBridge(str(device.link), 115200, heard.take_line, heard.take_connection)
    bridge.open()
    yield bridge
    bridge.close()


def test_commands_arrive_byte_for_byte(bridge: ArduinoBridge, device: Device) -> None:
    assert bridge.send_velocity(Twist2D(0.2, 0.0, 0.3))
    assert bridge.send_stop()
    assert bridge.send(b"FWD,100,1719\n")
    expected = b"VEL,200,0,300\nSTOP\nFWD,100,1719\n"
    assert device.hear_whole(expected) == expected
    assert bridge.statistics.written == 3


def test_lines_are_put_together_from_pieces(bridge: ArduinoBridge, device: Device, heard: Heard) -> None:
    for piece in (b"OD", b"OM,1,2", b",3\r\nACK,ST", b"OP\n"):
        device.say(piece)
    heard.wait_for(lambda: len(heard.lines) == 2)
    assert [line for line, _ in heard.lines] == [OdomLine(1, 2, 3), AckLine("STOP")]


def test_garbage_is_counted_and_does_not_hide_the_next_line(
    bridge: ArduinoBridge, device: Device, heard: Heard
) -> None:
    device.say(b"\xff\x00\x80garbage\nODOM,1,2\n" + b"x" * 500 + b"\nODOM,4,5,6\n")
    heard.wait_for(lambda: len(heard.lines) == 1)
    assert heard.lines[0][0] == OdomLine(4, 5, 6)
    statistics = bridge.statistics
    assert (statistics.garbled_lines, statistics.overlong_lines) == (2, 1)
    assert (statistics.lines, statistics.odometry_lines) == (1, 1)


def test_stamps_are_monotonic_times_of_arrival(device: Device, heard: Heard) -> None:
    times = iter(float(n) for n in range(1000))
    bridge = ArduinoBridge(str(device.link), 115200, heard.take_line, clock=lambda: next(times))
    bridge.open()
    device.say(b"ODOM,1,2,3\n")
    heard.wait_for(lambda: len(heard.lines) == 1)
    device.say(b"ODOM,1,2,3\n")
    heard.wait_for(lambda: len(heard.lines) == 2)
    bridge.close()
    assert heard.lines[0][1] < heard.lines[1][1]


def test_a_lost_port_is_opened_again(bridge: ArduinoBridge, device: Device, heard: Heard) -> None:
    device.unplug()
    heard.wait_for(lambda: heard.connections == [False])
    assert not bridge.connected
    assert not bridge.send_stop()
    device.plug_in()
    heard.wait_for(lambda: heard.connections == [False, True])
    device.say(b"ODOM,7,8,9\n")
    heard.wait_for(lambda: len(heard.lines) == 1)
    assert bridge.send(b"STOP\n")
    assert device.hear(100) == b"STOP\n"
    statistics = bridge.statistics
    assert (statistics.connects, statistics.refused_writes) == (2, 1)


def test_half_a_line_before_the_loss_is_not_glued_to_what_comes_after(
    bridge: ArduinoBridge, device: Device, heard: Heard
) -> None:
    device.say(b"ODOM,1,2,3\nODOM,4")
    heard.wait_for(lambda: len(heard.lines) == 1)
    device.unplug()
    heard.wait_for(lambda: heard.connections == [False])
    device.plug_in()
    heard.wait_for(lambda: heard.connections == [False, True])
    device.say(b",5,6\nODOM,7,8,9\n")
    heard.wait_for(lambda: len(heard.lines) == 2)
    assert heard.lines[1][0] == OdomLine(7, 8, 9)


def test_old_input_is_thrown_away_when_the_port_is_opened(device: Device, heard: Heard) -> None:
    device.say(b"ODOM,99,99,99\n")
    bridge = ArduinoBridge(str(device.link), 115200, heard.take_line)
    bridge.open()
    device.say(b"ODOM,1,1,1\n")
    heard.wait_for(lambda: len(heard.lines) == 1)
    bridge.close()
    assert heard.lines[0][0] == OdomLine(1, 1, 1)


def test_a_port_that_takes_nothing_refuses_and_recovers(bridge: ArduinoBridge, device: Device) -> None:
    sent = 0
    while bridge.send(b"FWD,100,1719\n"):
        sent += 1
        assert sent < 100_000, "the port takes everything"
    assert bridge.connected
    firmware = LineAssembler()
    os.set_blocking(device.master, False)
    late: list[bytes] = []
    while not late or late[-1] != b"STOP":
        try:
            late += firmware.feed(device.hear(65536))
        except BlockingIOError:
            bridge.send_stop()
    # The line cut off when the port was full did not swallow the one after it.
    assert parse_command(late[-1]) == StopCommand()
    assert len(late) <= sent + 2


def test_the_robot_is_stopped_on_closing(device: Device, heard: Heard) -> None:
    bridge = ArduinoBridge(str(device.link), 115200, heard.take_line)
    bridge.open()
    bridge.close()
    bridge.close()
    assert device.hear(100) == b"STOP\n"


def test_a_velocity_that_is_not_finite_is_never_sent(bridge: ArduinoBridge, device: Device) -> None:
    with pytest.raises(DeviceError, match="not finite"):
        bridge.send_velocity(Twist2D(float("nan"), 0.0, 0.0))
    bridge.send_stop()
    assert device.hear(100) == b"STOP\n"


def test_an_error_in_the_handler_is_not_swallowed(device: Device) -> None:
    failed = threading.Event()

    def handler(line: DeviceLine, stamp_s: float) -> None:
        failed.set()
        raise RuntimeError("handler")

    bridge = ArduinoBridge(str(device.link), 115200, handler)
    bridge.open()
    device.say(b"ODOM,1,2,3\n")
    assert failed.wait(PATIENCE_S)
    bridge.close()
    with pytest.raises(RuntimeError, match="handler"):
        bridge.raise_failure()


def test_a_port_that_appears_in_time_is_taken(tmp_path: Path, heard: Heard) -> None:
    link = tmp_path / "arduino"
    devices: list[Device] = []
    timer = threading.Timer(0.2, lambda: devices.append(Device(link)))
    timer.start()
    bridge = ArduinoBridge(str(link), 115200, heard.take_line)
    bridge.open(wait_s=PATIENCE_S)
    assert bridge.connected
    bridge.close()
    devices[0].unplug()


def test_a_port_that_cannot_be_opened_names_the_arduino(tmp_path: Path) -> None:
    with pytest.raises(DeviceError, match=r"there is no serial port .* for the Arduino"):
        ArduinoBridge(str(tmp_path / "ttyACM0"), 115200, lambda line, stamp_s: None).open()

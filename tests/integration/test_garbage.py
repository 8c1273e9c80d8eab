"""A million bytes of garbage each way over a pty: nothing moves, nothing crashes, the next line is understood."""

from __future__ import annotations

import random
import time
from pathlib import Path

import pytest

from target_nav.app.arduino_sim import ArduinoSim
from target_nav.app.serial_pty import SerialPty
from target_nav.hardware import protocol
from target_nav.hardware.arduino_bridge import ArduinoBridge
from target_nav.hardware.protocol import DeviceLine, OdomLine, VersionLine
from target_nav.state.types import Twist2D
from tests.utils.processes import wait_until

pytestmark = [pytest.mark.linux, pytest.mark.slow]

BYTES = 1_000_000
CHUNK = 1000
SEEDS = [
    b"VEL,200,0,300", b"FWD,100,1719", b"TMOTOR,FL,100", b"CCW,50,10000", b"ODOM,100,-5,30", b"ENC,1,2,3,4"
]  # fmt: skip


def damaged_line(chance: random.Random) -> bytes:
    """A line that nearly is one: bytes changed, lost, doubled; but none that is a command or a velocity, not even when
    its end is cut off, as a full port does."""
    while True:
        line = bytearray(chance.choice(SEEDS))
        for _ in range(chance.randint(1, 4)):
            at = chance.randrange(len(line) or 1)
            line[at : at + chance.randint(0, 2)] = chance.randbytes(chance.randint(0, 2))
        text = bytes(line).replace(b"\n", b"")
        commands = (protocol.parse_command(text[:end]) for end in range(3, len(text) + 1))
        if not any(commands) and not isinstance(protocol.parse_line(text), OdomLine):
            return text + b"\n"


def garbage(chance: random.Random) -> bytes:
    """A chunk of noise or of damaged lines, never with a whole valid line in it."""
    if chance.random() < 0.5:
        # Noise of any length between two newlines: random bytes that are a command are not to be had in a lifetime.
        return chance.randbytes(CHUNK)
    return b"\n" + b"".join(damaged_line(chance) for _ in range(CHUNK // 16))


def test_the_firmware_moves_nothing(tmp_path: Path) -> None:
    chance, robot = random.Random(1), ArduinoSim(tmp_path / "arduino")
    heard: list[DeviceLine] = []
    bridge = ArduinoBridge(str(tmp_path / "arduino"), 115200, lambda line, stamp_s: heard.append(line))
    try:
        bridge.open()
        sent = 0
        while sent < BYTES:
            data = garbage(chance)
            while not bridge.send(data):
                time.sleep(0.005)  # the line is full
            sent += len(data)
        begin_s = robot.simulation.driven_s
        wait_until(lambda: bridge.send(b"\nVERSION\n"), "room on the line")
        wait_until(lambda: any(isinstance(line, VersionLine) for line in heard), "an answer")
        assert robot.simulation.drive.path_m == 0.0
        assert robot.simulation.drive.ticks == (0, 0, 0, 0)
        assert not any(isinstance(line, OdomLine) for line in heard)
        assert bridge.statistics.garbled_lines == 0
        bridge.send_velocity(Twist2D(0.2, 0.0, 0.0))
        wait_until(lambda: robot.simulation.driven_s > begin_s, "turning wheels")
    finally:
        bridge.close()
        robot.close()


def test_the_bridge_believes_nothing(tmp_path: Path) -> None:
    chance = random.Random(2)
    heard: list[DeviceLine] = []
    with SerialPty(tmp_path / "arduino") as device:
        bridge = ArduinoBridge(str(tmp_path / "arduino"), 115200, lambda line, stamp_s: heard.append(line))
        bridge.open()
        try:
            sent = 0
            while sent < BYTES:
                data = garbage(chance)
                while data:
                    lost = device.lost_bytes
                    device.write(data)
                    data = data[len(data) - (device.lost_bytes - lost) :] if device.lost_bytes > lost else b""
                    if data:
                        time.sleep(0.002)
                sent += CHUNK
            device.write(b"\nODOM,1,2,3\n")
            wait_until(lambda: OdomLine(1, 2, 3) in heard, "the next line")
            bridge.raise_failure()
            assert [line for line in heard if isinstance(line, OdomLine)] == [OdomLine(1, 2, 3)]
            assert bridge.statistics.garbled_lines > 1000
            assert bridge.connected
        finally:
            bridge.close()

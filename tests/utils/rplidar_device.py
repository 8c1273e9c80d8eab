"""An RPLidar A1 as its serial port sees it, on a pty: written from the protocol's document, not from the driver.

It turns once in 182 ms and takes 2000 samples a second, in real time. What goes wrong with real ones can be switched
on: silence, bytes lost or damaged on the line, an unplugged cable, a stopped head, a failed self-test.
"""

from __future__ import annotations

import contextlib
import os
import select
import threading
import time
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

PERIOD_S = 0.182
SAMPLE_S = 0.0005
STEP_DEG = 360.0 * SAMPLE_S / PERIOD_S

SERIAL_NUMBER = bytes(range(0xA0, 0xB0))
ROUND_ROOM_MM = 2000.0


def sample_bytes(angle_deg: float, distance_mm: float, quality: int = 15, starts: bool = False) -> bytes:
    """One sample of a standard scan."""
    angle, distance = round(angle_deg * 64.0), round(distance_mm * 4.0)
    flags = 0b01 if starts else 0b10
    return bytes(
        (quality << 2 | flags, (angle & 0x7F) << 1 | 1, angle >> 7, distance & 0xFF, distance >> 8 & 0xFF)
    )


class RplidarDevice:
    """The device's end of the line, behind `link`, which survives the cable being unplugged.

    `scene` gives the distance in mm seen at an angle in degrees (clockwise, as the device counts), 0 for no return.
    """

    def __init__(self, link: Path, scene: Callable[[float], float] = lambda angle_deg: ROUND_ROOM_MM) -> None:
        self.link = link
        self.scene = scene
        self.health = (0, 0)
        self.heals_on_reset = False
        self.mute = False
        self.head_stands = False
        self.pace = 1.0
        """Times as fast as a real one."""
        self.damage: Callable[[bytes], bytes] = lambda data: data
        self.requests: list[int] = []
        self.sent_samples = 0
        self._scanning = False
        self._stop = threading.Event()
        self._lock = threading.Lock()
        self._master = self._slave = -1
        self.plug_in()
        self._thread = threading.Thread(target=self._run, name="rplidar device", daemon=True)
        self._thread.start()

    def plug_in(self) -> None:
        with self._lock:
            self._master, self._slave = os.openpty()
            tty.setraw(self._slave)
            os.set_blocking(self._master, False)
            self._scanning = False
        self.link.unlink(missing_ok=True)
        self.link.symlink_to(os.ttyname(self._slave))

    def unplug(self) -> None:
        self.link.unlink(missing_ok=True)
        with self._lock:
            for end in (self._slave, self._master):
                with contextlib.suppress(OSError):
                    os.close(end)
            self._master = self._slave = -1

    def say(self, data: bytes) -> None:
        """Put bytes on the line as they are."""
        with self._lock:
            self._write(data)

    def close(self) -> None:
        self._stop.set()
        self._thread.join()
        self.unplug()

    def _run(self) -> None:
        pending = b""
        begun_s, taken = 0.0, 0
        while not self._stop.wait(0.005):
            with self._lock:
                if self._master < 0:
                    pending = b""
                    continue
                pending += self._read()
                while len(pending) >= 2:
                    if pending[0] != 0xA5:
                        pending = pending[1:]
                        continue
                    code, pending = pending[1], pending[2:]
                    self.requests.append(code)
                    if self._answer(code):
                        begun_s, taken = time.monotonic(), 0
                if self._scanning and not self.mute:
                    due = int((time.monotonic() - begun_s) * self.pace / SAMPLE_S)
                    self._write(self.damage(b"".join(self._sample(n) for n in range(taken, due))))
                    taken = due

    def _answer(self, code: int) -> bool:
        """True: a scan begins."""
        if self.mute:
            return False
        if code == 0x25:
            self._scanning = False
        elif code == 0x40:
            self._scanning = False
            if self.heals_on_reset:
                self.health = (0, 0)
            self._write(b"RP LIDAR System.\r\nFirmware Ver 1.29, HW Ver 7\r\nModel: 18\r\n")
        elif code == 0x50:
            self._write(bytes.fromhex("a55a1400000004") + bytes((24, 29, 1, 7)) + SERIAL_NUMBER)
        elif code == 0x52:
            status, error = self.health
            self._write(bytes.fromhex("a55a0300000006") + bytes((status, error & 0xFF, error >> 8)))
        elif code == 0x20 and self.health[0] != 2:
            self._write(bytes.fromhex("a55a0500004081"))
            self._scanning = True
            return True
        return False

    def _sample(self, number: int) -> bytes:
        self.sent_samples += 1
        if self.head_stands:
            return sample_bytes(40.0, self.scene(40.0))
        # A scan begins anywhere in a turn.
        angle_deg = (number * STEP_DEG + 100.0) % 360.0
        distance_mm = self.scene(angle_deg)
        return sample_bytes(angle_deg, distance_mm, 15 if distance_mm else 0, starts=angle_deg < STEP_DEG)

    def _read(self) -> bytes:
        if not select.select([self._master], [], [], 0.0)[0]:
            return b""
        with contextlib.suppress(OSError):
            return os.read(self._master, 1024)
        return b""

    def _write(self, data: bytes) -> None:
        # Nobody reads: lost, as on a wire.
        with contextlib.suppress(BlockingIOError, OSError):
            os.write(self._master, data)


@contextmanager
def rplidar_device(
    link: Path, scene: Callable[[float], float] = lambda angle_deg: ROUND_ROOM_MM
) -> Iterator[RplidarDevice]:
    device = RplidarDevice(link, scene)
    try:
        yield device
    finally:
        device.close()

"""The serial line to the Arduino: opens it, reads lines in the background, opens it again when it was lost.

The reader thread owns the port. It stamps every line with the monotonic time at which its last byte arrived,
and when the cable is pulled it tries again, at growing intervals, until `close`. Callers only write, and a
write to a lost or stuck port is refused at once: old velocities must not be sent late, the next one is 50 ms
away.
"""

from __future__ import annotations

import contextlib
import os
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

import serial

from target_nav.hardware.device_thread import DeviceThread
from target_nav.hardware.protocol import (
    DeviceLine,
    ErrorLine,
    LineAssembler,
    OdomLine,
    encode_stop,
    encode_velocity,
    parse_line,
)
from target_nav.hardware.serial_port import PortUse, open_port
from target_nav.state.types import Twist2D

READ_TIMEOUT_S = 0.1
"""How soon the reader notices that it shall end, or that a write failed."""

PORT_USE = PortUse("Arduino", "serial.port", "another arduino_node or a serial monitor")

LineHandler = Callable[[DeviceLine, float], None]


@dataclass(frozen=True)
class BridgeStatistics:
    """Counters since the start. `last_line_s` is the stamp of the newest good line, -inf before the first."""

    connected: bool
    connects: int
    lines: int
    odometry_lines: int
    error_lines: int
    garbled_lines: int
    overlong_lines: int
    written: int
    refused_writes: int
    last_line_s: float


class ArduinoBridge:
    """One serial port with the firmware behind it.

    Args:
        port: device or a link to one, resolved anew at each opening.
        baud: speed.
        on_line: called from the reader thread with every good line and its stamp.
        on_connection: called from the reader thread with True when the port was opened again, with False when it was
            lost, and why.
    """

    def __init__(
        self,
        port: str,
        baud: int,
        on_line: LineHandler,
        on_connection: Callable[[bool, str], None] | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.port = port
        self.baud = baud
        self._on_line = on_line
        self._clock = clock
        self._serial: serial.Serial | None = None
        self._write_lock = threading.Lock()
        self._lost = threading.Event()
        self._reader = DeviceThread(
            f"serial {port}", self._connect, self._read_until_lost, self._drop_port, on_connection, clock
        )
        self._cut = False
        self._assembler = LineAssembler()
        self._connects = self._lines = self._odometry = self._errors = self._garbled = 0
        self._written = self._refused = 0
        self._last_line_s = float("-inf")

    def open(self, wait_s: float = 0.0) -> None:
        """Open the port, waiting up to `wait_s` for it to appear, and start reading.

        Raises:
            DeviceError: the port is not there, may not be opened, or belongs to another process.
        """
        self._reader.open(wait_s)

    def send_velocity(self, twist: Twist2D) -> bool:
        """Send `VEL`; False when the port is lost or stuck. A twist that is not finite raises DeviceError."""
        return self.send(encode_velocity(twist))

    def send_stop(self) -> bool:
        """Send `STOP`; False when the port is lost or stuck."""
        return self.send(encode_stop())

    def send(self, line: bytes) -> bool:
        """Send one line as it is; False when the port is lost or stuck."""
        with self._write_lock:
            port = self._serial
            if port is None or self._lost.is_set():
                self._refused += 1
                return False
            data = b"\n" + line if self._cut else line
            try:
                # Not pyserial's write: that one takes a busy machine for a stuck port, after the line has gone out.
                sent = os.write(port.fileno(), data)
            except BlockingIOError:
                sent = 0
            except (serial.SerialException, OSError):
                self._refused += 1
                self._lost.set()
                return False
            # What is out of a line that was cut off is ended before the next one.
            self._cut = 0 < sent < len(data) or (self._cut and sent == 0)
            if sent < len(data):
                self._refused += 1
                return False
            self._written += 1
            return True

    def close(self) -> None:
        """Stop the robot as far as it can be reached, end the reader, close the port. May be called again."""
        if not self._reader.running:
            return
        self.send_stop()
        self._reader.close()

    def raise_failure(self) -> None:
        """Raise what ended the reader thread, if something did: an error in `on_line` is not swallowed."""
        self._reader.raise_failure()

    @property
    def connected(self) -> bool:
        return self._serial is not None and not self._lost.is_set()

    @property
    def statistics(self) -> BridgeStatistics:
        return BridgeStatistics(
            connected=self.connected,
            connects=self._connects,
            lines=self._lines,
            odometry_lines=self._odometry,
            error_lines=self._errors,
            garbled_lines=self._garbled,
            overlong_lines=self._assembler.overflows,
            written=self._written,
            refused_writes=self._refused,
            last_line_s=self._last_line_s,
        )

    def _connect(self) -> None:
        port = open_port(self.port, self.baud, PORT_USE, READ_TIMEOUT_S)
        with self._write_lock:
            self._serial = port
            self._cut = False
            self._lost.clear()
        self._connects += 1

    def _read_until_lost(self) -> str:
        port = self._serial
        assert port is not None
        self._assembler.reset()
        try:
            while not self._reader.closing.is_set():
                data = port.read(port.in_waiting or 1)
                if data:
                    self._take(data, self._clock())
                if self._lost.is_set():
                    return "a write failed"
        except (serial.SerialException, OSError) as error:
            return str(error)
        return "closed"

    def _take(self, data: bytes, stamp_s: float) -> None:
        for raw in self._assembler.feed(data):
            line = parse_line(raw)
            if line is None:
                self._garbled += 1
                continue
            self._lines += 1
            self._odometry += isinstance(line, OdomLine)
            self._errors += isinstance(line, ErrorLine)
            self._last_line_s = stamp_s
            self._on_line(line, stamp_s)

    def _drop_port(self) -> None:
        with self._write_lock:
            port, self._serial = self._serial, None
        if port is not None:
            # A device that is gone leaves nothing to close.
            with contextlib.suppress(serial.SerialException, OSError):
                port.close()

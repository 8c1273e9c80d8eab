"""The RPLidar A1's serial protocol as pure functions: requests out, descriptors and samples back.

Source: Slamtec, "RPLIDAR Series: Interface Protocol and Application Notes". A request is A5 and its code. An answer
begins with a descriptor of 7 bytes (A5 5A, 30 bits of length, 2 bits of mode, a data type); SCAN's never ends and
consists of samples of 5 bytes:

    byte 0   quality << 2 | not S << 1 | S      S: the first sample of a turn
    byte 1   angle, low 7 bits << 1 | 1         in 1/64 degree, clockwise seen from above
    byte 2   angle, high 8 bits
    byte 3,4 distance, little endian            in 1/4 mm; 0: nothing came back

A sample has three fixed bits and no checksum, so one that is off by a byte is taken for a sample every fifth time. The
parser therefore also asks that the head goes on from where it was, and after a damage wants several in a row.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from target_nav.errors import DeviceError
from target_nav.state.types import FloatArray

FLAG = 0xA5


class Request(IntEnum):
    STOP = 0x25
    RESET = 0x40
    SCAN = 0x20
    GET_INFO = 0x50
    GET_HEALTH = 0x52

    def encode(self) -> bytes:
        return bytes((FLAG, self))


INFO_DESCRIPTOR = bytes.fromhex("a5 5a 14 00 00 00 04")
HEALTH_DESCRIPTOR = bytes.fromhex("a5 5a 03 00 00 00 06")
SCAN_DESCRIPTOR = bytes.fromhex("a5 5a 05 00 00 40 81")

INFO_BYTES, HEALTH_BYTES, SAMPLE_BYTES = 20, 3, 5

ANGLE_UNITS_PER_TURN = 360 * 64
ANGLE_UNITS_LIMIT = 361 * 64
"""Firmware rounds up to a little over 360 degrees now and then."""

MAX_STEP_UNITS = 20 * 64
"""The head moves by 1 degree a sample; lost samples and the A1's own correction of angles make it a few."""

CONFIRM_SAMPLES = 4
"""So many in a row, each going on from the last, before a damaged stream is believed again."""


@dataclass(frozen=True)
class DeviceInfo:
    """`model` 24 is an A1M8. `serial_number` as 32 hexadecimal digits."""

    model: int
    firmware: str
    hardware: int
    serial_number: str


class HealthStatus(IntEnum):
    GOOD = 0
    WARNING = 1
    ERROR = 2


@dataclass(frozen=True)
class Health:
    status: HealthStatus
    code: int


@dataclass(frozen=True, eq=False)
class Samples:
    """N samples in the order they were taken; every array has shape (N,)."""

    angle_rad: FloatArray
    """Clockwise from the sensor's zero, in [0, 2 pi)."""
    range_m: FloatArray
    """`inf` where nothing came back."""
    quality: NDArray[np.uint8]
    starts_turn: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.range_m)


def parse_info(payload: bytes) -> DeviceInfo:
    """What follows INFO_DESCRIPTOR."""
    model, minor, major, hardware, serial_number = struct.unpack("<BBBB16s", payload)
    return DeviceInfo(model, f"{major}.{minor:02d}", hardware, serial_number.hex().upper())


def parse_health(payload: bytes) -> Health:
    """What follows HEALTH_DESCRIPTOR.

    Raises:
        DeviceError: a status that the protocol does not have.
    """
    status, code = struct.unpack("<BH", payload)
    try:
        return Health(HealthStatus(status), code)
    except ValueError as error:
        raise DeviceError(f"the LiDAR reports health {status}; it must be 0, 1 or 2") from error


class SampleParser:
    """Samples out of the byte stream after SCAN_DESCRIPTOR. Holds less than one confirmation of bytes."""

    def __init__(self) -> None:
        self._buffer = bytearray()
        self._synced = True
        self._last_units: int | None = None
        self.resyncs = 0
        self.skipped_bytes = 0

    def feed(self, data: bytes) -> Samples:
        """The samples that `data` completes."""
        self._buffer += data
        parts: list[NDArray[np.uint8]] = []
        while self._synced or self._find_sync():
            count = len(self._buffer) // SAMPLE_BYTES
            if count == 0:
                break
            rows = np.frombuffer(bytes(self._buffer[: count * SAMPLE_BYTES]), dtype=np.uint8)
            rows = rows.reshape(count, SAMPLE_BYTES)
            good = _is_sample(rows, self._last_units)
            accepted = count if good.all() else int(np.argmin(good))
            if accepted:
                parts.append(rows[:accepted])
                self._last_units = int(_angle_units(rows[accepted - 1 : accepted])[0])
                del self._buffer[: accepted * SAMPLE_BYTES]
            if accepted == count:
                break
            self._synced = False
            self.resyncs += 1
        return _decode(np.concatenate(parts) if parts else np.empty((0, SAMPLE_BYTES), dtype=np.uint8))

    def _find_sync(self) -> bool:
        """Drop bytes until the buffer begins with a row of samples; False when more bytes are needed to tell."""
        window = CONFIRM_SAMPLES * SAMPLE_BYTES
        data = np.frombuffer(bytes(self._buffer), dtype=np.uint8)
        for offset in range(len(data) - window + 1):
            rows = data[offset : offset + window].reshape(CONFIRM_SAMPLES, SAMPLE_BYTES)
            if _is_sample(rows[:1], None)[0] and _is_sample(rows, None).all():
                del self._buffer[:offset]
                self.skipped_bytes += offset
                self._synced = True
                self._last_units = None
                return True
        hopeless = max(len(data) - window + 1, 0)
        del self._buffer[:hopeless]
        self.skipped_bytes += hopeless
        return False


def _angle_units(rows: NDArray[np.uint8]) -> NDArray[np.int32]:
    return (rows[:, 1].astype(np.int32) >> 1) | (rows[:, 2].astype(np.int32) << 7)


def _is_sample(rows: NDArray[np.uint8], last_units: int | None) -> NDArray[np.bool_]:
    """Which rows have the fixed bits, a possible angle, and go on from the row before (the first: `last_units`)."""
    flags = (rows[:, 0] ^ (rows[:, 0] >> 1)) & rows[:, 1] & 1
    units = _angle_units(rows)
    step = np.diff(units, prepend=units[0] if last_units is None else last_units)
    step = (step + ANGLE_UNITS_PER_TURN // 2) % ANGLE_UNITS_PER_TURN - ANGLE_UNITS_PER_TURN // 2
    good: NDArray[np.bool_] = (
        flags.astype(bool) & (units <= ANGLE_UNITS_LIMIT) & (np.abs(step) <= MAX_STEP_UNITS)
    )
    return good


def _decode(rows: NDArray[np.uint8]) -> Samples:
    distance = rows[:, 3].astype(np.float64) + 256.0 * rows[:, 4]
    quality = rows[:, 0] >> 2
    angle = (_angle_units(rows) % ANGLE_UNITS_PER_TURN) * (2.0 * math.pi / ANGLE_UNITS_PER_TURN)
    came_back = (distance > 0.0) & (quality > 0)
    return Samples(
        angle_rad=angle,
        range_m=np.where(came_back, distance / 4000.0, math.inf),
        quality=quality,
        starts_turn=(rows[:, 0] & 1).astype(bool),
    )

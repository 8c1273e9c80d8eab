"""The RPLidar A1's serial protocol as pure functions: requests out, descriptors and samples back.

Source: Slamtec, "RPLIDAR Series: Interface Protocol and Application Notes". A request is A5 and its code. An answer
begins with a descriptor of 7 bytes (A5 5A, 30 bits of length, 2 bits of mode, a data type); SCAN's never ends and
consists of samples of 5 bytes:

    byte 0   quality << 2 | not S << 1 | S      S: the first sample of a turn
    byte 1   angle, low 7 bits << 1 | 1         in 1/64 degree, clockwise seen from above
    byte 2   angle, high 8 bits
    byte 3,4 distance, little endian            in 1/4 mm; 0: nothing came back

A sample has three fixed bits and no checksum, and one that is off by some bytes often looks like one: distances and
qualities repeat. What tells is the head, which goes on turning. The parser believes samples only in rows in which each
is near the one before and the last is well ahead of the first, and holds back the newest until their row is whole.
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
"""From one sample to the next: the head moves by 1 degree, lost samples and the A1's correction of angles by a few."""

ROW = 8
"""Samples in a row; at 2000 a second it takes 4 ms."""

MIN_ROW_UNITS, MAX_ROW_UNITS = 16, 45 * 64
"""From the first of a row to the last: at 2 turns a second 2.5 degrees, at 10 turns 13."""


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


_NO_UNITS: NDArray[np.int32] = np.empty(0, dtype=np.int32)


class SampleParser:
    """Samples out of the byte stream after SCAN_DESCRIPTOR."""

    def __init__(self) -> None:
        self._buffer = bytearray()
        self._synced = True
        self._past_units = _NO_UNITS
        """Angles of the samples given out last, as many as a row looks back on."""
        self.resyncs = 0
        self.skipped_bytes = 0

    @property
    def held_samples(self) -> float:
        """How many samples have come in and were not given out yet."""
        return len(self._buffer) / SAMPLE_BYTES

    def feed(self, data: bytes) -> Samples:
        """The samples that `data` confirms, all but the last few it brings."""
        self._buffer += data
        parts = [b""]
        while self._synced or self._find_sync():
            rows = _rows(self._buffer)
            good = _goes_on(rows, self._past_units)
            broken = not good.all()
            begun = int(np.argmin(good)) if broken else len(rows)
            confirmed = max(begun - ROW + 1, 0)
            if confirmed:
                parts.append(bytes(self._buffer[: confirmed * SAMPLE_BYTES]))
                past = np.concatenate((self._past_units, _angle_units(rows[:confirmed])))
                self._past_units = past[-(ROW - 1) :]
                del self._buffer[: confirmed * SAMPLE_BYTES]
            if not broken:
                break
            # Those right before the damage may belong to it.
            self._drop((begun - confirmed) * SAMPLE_BYTES)
            self.resyncs += 1
            self._synced = False
        return decode_samples(b"".join(parts))

    def _find_sync(self) -> bool:
        """Drop bytes until the buffer begins within a row of samples; False when more bytes are needed to tell."""
        places = max(len(self._buffer) - ROW * SAMPLE_BYTES + 1, 0)
        begins = _begins_row(bytes(self._buffer), places)
        self._synced = bool(begins.any())
        # The row's first sample may be half of the damage.
        self._drop(int(np.argmax(begins)) + SAMPLE_BYTES if self._synced else places)
        self._past_units = _NO_UNITS
        return self._synced

    def _drop(self, count: int) -> None:
        del self._buffer[:count]
        self.skipped_bytes += count


def decode_samples(data: bytes) -> Samples:
    """Whole samples, one after the other; whether they are any is not asked."""
    rows = _rows(data)
    distance = rows[:, 3].astype(np.float64) + 256.0 * rows[:, 4]
    quality: NDArray[np.uint8] = np.right_shift(rows[:, 0], np.uint8(2))
    angle_rad: FloatArray = (_angle_units(rows) % ANGLE_UNITS_PER_TURN).astype(np.float64)
    angle_rad *= 2.0 * math.pi / ANGLE_UNITS_PER_TURN
    came_back = (distance > 0.0) & (quality > 0)
    return Samples(
        angle_rad=angle_rad,
        range_m=np.where(came_back, distance / 4000.0, math.inf),
        quality=quality,
        starts_turn=(rows[:, 0] & 1).astype(bool),
    )


def _rows(data: bytes | bytearray) -> NDArray[np.uint8]:
    """The whole samples in `data`, shape (N, 5)."""
    count = len(data) // SAMPLE_BYTES
    return np.frombuffer(bytes(data[: count * SAMPLE_BYTES]), dtype=np.uint8).reshape(count, SAMPLE_BYTES)


def _angle_units(rows: NDArray[np.uint8]) -> NDArray[np.int32]:
    return (rows[:, 1].astype(np.int32) >> 1) | (rows[:, 2].astype(np.int32) << 7)


def _is_possible(rows: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """Which rows have a sample's fixed bits and an angle that there is."""
    flags = (rows[:, 0] ^ (rows[:, 0] >> 1)) & rows[:, 1] & 1
    possible: NDArray[np.bool_] = flags.astype(bool) & (_angle_units(rows) <= ANGLE_UNITS_LIMIT)
    return possible


def _ahead_units(before: NDArray[np.int32], after: NDArray[np.int32]) -> NDArray[np.int32]:
    """How far the head went from one angle to another, in [-half a turn, half a turn)."""
    half = ANGLE_UNITS_PER_TURN // 2
    return (after - before + half) % ANGLE_UNITS_PER_TURN - half


def _is_near(before: NDArray[np.int32], after: NDArray[np.int32]) -> NDArray[np.bool_]:
    near: NDArray[np.bool_] = np.abs(_ahead_units(before, after)) <= MAX_STEP_UNITS
    return near


def _is_turning(first: NDArray[np.int32], last: NDArray[np.int32]) -> NDArray[np.bool_]:
    ahead = _ahead_units(first, last)
    turning: NDArray[np.bool_] = (ahead >= MIN_ROW_UNITS) & (ahead <= MAX_ROW_UNITS)
    return turning


def _goes_on(rows: NDArray[np.uint8], past_units: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Which rows are possible, near the one before, and well ahead of where the head was a row ago.

    `past_units` are the angles before the first of them, if there are any.
    """
    units = np.concatenate((past_units, _angle_units(rows)))
    good = np.ones(len(units), dtype=bool)
    good[1:] &= _is_near(units[:-1], units[1:])
    good[ROW - 1 :] &= _is_turning(units[: max(len(units) - ROW + 1, 0)], units[ROW - 1 :])
    return good[len(past_units) :] & _is_possible(rows)


def _begins_row(data: bytes, places: int) -> NDArray[np.bool_]:
    """At which of the first `places` bytes a row of samples begins."""
    if places == 0:
        return np.zeros(0, dtype=bool)
    rows = np.lib.stride_tricks.sliding_window_view(np.frombuffer(data, dtype=np.uint8), SAMPLE_BYTES)
    possible, units = _is_possible(rows), _angle_units(rows)
    near = _is_near(units[:-SAMPLE_BYTES], units[SAMPLE_BYTES:])
    last = (ROW - 1) * SAMPLE_BYTES
    row = possible[:places] & _is_turning(units[:places], units[last : last + places])
    for at in range(SAMPLE_BYTES, last + 1, SAMPLE_BYTES):
        row &= possible[at : at + places] & near[at - SAMPLE_BYTES : at - SAMPLE_BYTES + places]
    return row

"""What each channel carries <-> bytes: a fixed head derived from the dataclass, and at most one bounded array after it.

Only as much of the array is stored as is in use. Every payload begins with `stamp_s`, so that its age can be told
without knowing what it is.
"""

from __future__ import annotations

from typing import Any, Generic, NamedTuple, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from target_nav.errors import DeviceError
from target_nav.ipc.cstruct import CStruct, Member
from target_nav.ipc.records import Record
from target_nav.state.snapshots import CameraFrame

T = TypeVar("T")

MAX_DETECTIONS = 64
MAX_POINTS = 1440
MAX_PIXEL_BYTES = 1920 * 1080 * 3


class Encoded(NamedTuple):
    """`length` bytes stand in the private buffer; `bulk` follows them straight from where it lies.

    `dropped` items did not fit.
    """

    length: int
    bulk: memoryview | None = None
    dropped: int = 0


class Codec(Protocol[T]):
    """`head_bytes`: the most that lies under the CRC. `bulk_from`: where bulk begins, None when there is none."""

    @property
    def type(self) -> type[T]: ...
    @property
    def layout(self) -> CStruct: ...
    @property
    def head_bytes(self) -> int: ...
    @property
    def bulk_from(self) -> int | None: ...

    def encode(self, value: T, buffer: bytearray, at: int) -> Encoded: ...

    def decode(self, data: bytes, at: int, bulk: NDArray[np.uint8] | None) -> T: ...


def expect_type(value: object, wanted: type[Any]) -> None:
    if not isinstance(value, wanted):
        raise DeviceError(
            f"the channel carries {wanted.__name__}, not {type(value).__name__}; choose another channel"
        )


class PlainCodec(Generic[T]):
    """A dataclass of fixed size."""

    bulk_from: int | None = None

    def __init__(self, of: type[T]) -> None:
        self.type = of
        self._record = Record(of)
        self.layout = self._record.layout
        self.head_bytes = self.layout.size

    def encode(self, value: T, buffer: bytearray, at: int) -> Encoded:
        expect_type(value, self.type)
        self._record.pack_into(buffer, at, value)
        return Encoded(self.head_bytes)

    def decode(self, data: bytes, at: int, bulk: NDArray[np.uint8] | None) -> T:
        return self._record.unpack_from(data, at)


class ItemsCodec(Generic[T]):
    """A dataclass whose last field is a tuple of other dataclasses, `capacity` of them at most.

    Of more, the `capacity` with the highest score are kept, in their order: the rest is the least likely to matter.
    """

    bulk_from: int | None = None

    def __init__(self, of: type[T], field: str, item: type[Any], capacity: int) -> None:
        self.type = of
        self._field, self._capacity = field, capacity
        self._item = Record(item)
        count = Member(f"{field}_count", "uint32_t")
        items = Member(field, self._item.layout, capacity, counted=True)
        self._record = Record(of, field, [count, items])
        self.layout = self._record.layout
        self._count_at, self._items_at = self.layout[count.name].offset, self.layout[field].offset
        self.head_bytes = self.layout.size

    def encode(self, value: T, buffer: bytearray, at: int) -> Encoded:
        expect_type(value, self.type)
        items = getattr(value, self._field)
        dropped = max(0, len(items) - self._capacity)
        if dropped:
            best = sorted(range(len(items)), key=lambda i: _score(items[i]), reverse=True)[: self._capacity]
            items = [items[i] for i in sorted(best)]
        self._record.pack_into(buffer, at, value)
        count_at = at + self._count_at
        buffer[count_at : count_at + 4] = len(items).to_bytes(4, "little")
        place = at + self._items_at
        for item in items:
            expect_type(item, self._item.type)
            self._item.pack_into(buffer, place, item)
            place += self._item.size
        return Encoded(place - at, None, dropped)

    def decode(self, data: bytes, at: int, bulk: NDArray[np.uint8] | None) -> T:
        count = int.from_bytes(data[at + self._count_at : at + self._count_at + 4], "little")
        first, size, unpack = at + self._items_at, self._item.size, self._item.unpack_from
        return self._record.unpack_from(data, at, tuple(unpack(data, first + i * size) for i in range(count)))


def _score(item: Any) -> float:
    """NaN sorts as the worst; items without a score are all alike, so that the first ones are kept."""
    score = float(getattr(item, "score", 0.0))
    return score if score == score else -np.inf


class PointsCodec(Generic[T]):
    """A dataclass whose last field is `points_in_base_m`, shape (N, 2).

    Of more than `MAX_POINTS` points, evenly spaced ones are kept: they are for a picture.
    """

    bulk_from: int | None = None

    def __init__(self, of: type[T]) -> None:
        self.type = of
        count = Member("points_count", "uint32_t")
        points = Member("points_in_base_m", "double", 2 * MAX_POINTS, counted=True)
        self._record = Record(of, points.name, [count, points])
        self.layout = self._record.layout
        self._count_at, self._points_at = self.layout[count.name].offset, self.layout[points.name].offset
        self.head_bytes = self.layout.size

    def encode(self, value: T, buffer: bytearray, at: int) -> Encoded:
        expect_type(value, self.type)
        points = np.asarray(value.points_in_base_m)  # type: ignore[attr-defined]
        if points.ndim != 2 or points.shape[1] != 2 or points.dtype.kind not in "fiu":
            raise DeviceError(
                f"laser points have shape {points.shape} of {points.dtype}; they must be (N, 2) numbers in metres"
            )
        dropped = max(0, len(points) - MAX_POINTS)
        if dropped:
            points = points[np.linspace(0, len(points) - 1, MAX_POINTS).astype(np.intp)]
        raw = np.ascontiguousarray(points, dtype="<f8").tobytes()
        self._record.pack_into(buffer, at, value)
        count_at, place = at + self._count_at, at + self._points_at
        buffer[count_at : count_at + 4] = len(points).to_bytes(4, "little")
        buffer[place : place + len(raw)] = raw
        return Encoded(self._points_at + len(raw), None, dropped)

    def decode(self, data: bytes, at: int, bulk: NDArray[np.uint8] | None) -> T:
        count = int.from_bytes(data[at + self._count_at : at + self._count_at + 4], "little")
        # A view of `data`, which is bytes: the array is read-only and owns its memory through it.
        points = np.frombuffer(data, "<f8", 2 * count, at + self._points_at).reshape(count, 2)
        return self._record.unpack_from(data, at, points)


class ImageCodec:
    """A CameraFrame. The pixels are too many to be built in a private buffer, and to be put under a CRC-32.

    They are guarded by `pixel_sum`, which lies under the head's CRC: the sum of all 8-byte words modulo 2^64. On a
    picture of 640x480 it takes 17 us where CRC-32 takes 190, and every byte counts in it.
    """

    type = CameraFrame

    def __init__(self) -> None:
        shape = [
            Member("height_px", "uint32_t"),
            Member("width_px", "uint32_t"),
            Member("pixel_sum", "uint64_t"),
        ]
        pixels = Member("image_bgr", "uint8_t", MAX_PIXEL_BYTES, counted=True)
        self._record = Record(CameraFrame, pixels.name, [*shape, pixels])
        self.layout = self._record.layout
        self._height_at, self._sum_at = self.layout["height_px"].offset, self.layout["pixel_sum"].offset
        self.head_bytes = self.layout[pixels.name].offset
        self.bulk_from: int | None = self.head_bytes

    def encode(self, value: CameraFrame, buffer: bytearray, at: int) -> Encoded:
        expect_type(value, CameraFrame)
        image = value.image_bgr
        if (
            not isinstance(image, np.ndarray)
            or image.dtype != np.uint8
            or image.ndim != 3
            or image.shape[2] != 3
        ):
            raise DeviceError(
                f"the picture is {getattr(image, 'dtype', type(image))} of shape {getattr(image, 'shape', None)}; "
                "it must be uint8 of shape (height, width, 3)"
            )
        if not 0 < image.size <= MAX_PIXEL_BYTES:
            raise DeviceError(
                f"the picture has shape {image.shape}, {image.size} bytes; it must have 1 ... {MAX_PIXEL_BYTES} "
                "(1920x1080x3); set camera.width_px and camera.height_px lower"
            )
        flat = np.ascontiguousarray(image).reshape(-1)
        self._record.pack_into(buffer, at, value)
        for place, number, size in (
            (self._height_at, image.shape[0], 4),
            (self._height_at + 4, image.shape[1], 4),
            (self._sum_at, pixel_sum(flat), 8),
        ):
            buffer[at + place : at + place + size] = number.to_bytes(size, "little")
        return Encoded(self.head_bytes, flat.data)

    def shape(self, data: bytes, at: int) -> tuple[int, int, int]:
        height_at = at + self._height_at
        height = int.from_bytes(data[height_at : height_at + 4], "little")
        width = int.from_bytes(data[height_at + 4 : height_at + 8], "little")
        return height, width, 3

    def intact(self, data: bytes, at: int, flat: NDArray[np.uint8]) -> bool:
        return pixel_sum(flat) == int.from_bytes(data[at + self._sum_at : at + self._sum_at + 8], "little")

    def decode(self, data: bytes, at: int, bulk: NDArray[np.uint8] | None) -> CameraFrame:
        return self._record.unpack_from(data, at, bulk)


def pixel_sum(flat: NDArray[np.uint8]) -> int:
    """Sum modulo 2^64 of the little-endian 8-byte words of `flat`, shape (N,), zeros appended."""
    whole = flat.size & ~7
    words = int(np.add.reduce(flat[:whole].view("<u8"), dtype=np.uint64))
    return (words + int.from_bytes(flat[whole:].tobytes(), "little")) & 0xFFFF_FFFF_FFFF_FFFF

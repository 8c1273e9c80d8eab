"""Reading pictures: one copy, verified after copying, into memory of the reader's choice."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from target_nav.errors import DeviceError
from target_nav.ipc.codecs import ImageCodec
from target_nav.ipc.seqlock import SLOTS, Reader
from target_nav.ipc.slots import PAYLOAD_IN_DATA, Loaded
from target_nav.state.snapshots import CameraFrame


class CameraReader(Reader[CameraFrame]):
    """`latest` and `take_new` copy a new picture into a new array, which is read-only: `copy()` it to draw on it."""

    def __init__(self, path: Path, codec: ImageCodec, slot_count: int = SLOTS) -> None:
        super().__init__(path, codec, slot_count)
        self._image_codec = codec
        self._target: NDArray[np.uint8] | None = None
        self._image: NDArray[np.uint8] = np.empty((0, 0, 3), np.uint8)

    def read_into(self, buffer: NDArray[np.uint8]) -> CameraFrame | None:
        """Takes the newest picture, if it was not taken yet, straight into `buffer`.

        Args:
            buffer: contiguous, writable uint8 with room for the picture, of any shape.

        Returns:
            The frame, its image a view (height, width, 3) of `buffer`; None when there is nothing new, and then the
            buffer may hold anything.

        Raises:
            DeviceError: the buffer is too small or of another kind; and as `latest` does.
        """
        if buffer.dtype != np.uint8 or not buffer.flags.c_contiguous or not buffer.flags.writeable:
            raise DeviceError(
                f"the buffer is {buffer.dtype} {buffer.shape}; it must be contiguous, writable uint8"
            )
        self._target = buffer.reshape(-1)
        try:
            loaded = self._fetch(self._taken_sequence, self._allocate)
        finally:
            self._target = None
        if loaded is None:
            return None
        self._taken_sequence = loaded.sequence
        return self._image_codec.decode(loaded.data, PAYLOAD_IN_DATA, self._image)

    def __enter__(self) -> CameraReader:
        return self

    def _poll(self) -> None:
        loaded = self._fetch(self._value_sequence, self._allocate)
        if loaded is not None:
            self._image.flags.writeable = False
            self._value = self._image_codec.decode(loaded.data, PAYLOAD_IN_DATA, self._image)
            self._value_sequence = loaded.sequence

    def _allocate(self, data: bytes, bulk_bytes: int) -> memoryview | None:
        shape = self._image_codec.shape(data, PAYLOAD_IN_DATA)
        if bulk_bytes <= 0 or shape[0] * shape[1] * shape[2] != bulk_bytes:
            return None
        if self._target is None:
            # Kept from a try that failed, if it was: nobody else has seen it.
            if self._image.shape != shape or not self._image.flags.writeable or not self._image.flags.owndata:
                self._image = np.empty(shape, np.uint8)
        elif self._target.size < bulk_bytes:
            raise DeviceError(
                f"the buffer has {self._target.size} bytes; a picture of {shape} needs {bulk_bytes}"
            )
        else:
            self._image = self._target[:bulk_bytes].reshape(shape)
        return self._image.reshape(-1).data

    def _bulk_intact(self, loaded: Loaded) -> bool:
        return self._image_codec.intact(loaded.data, PAYLOAD_IN_DATA, self._image.reshape(-1))

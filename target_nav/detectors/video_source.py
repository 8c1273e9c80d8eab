"""Pictures from a camera or a video file, through OpenCV, with the time at which they were taken."""

from __future__ import annotations

import glob
import os
import time
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np

from target_nav.errors import DeviceError
from target_nav.state.snapshots import CameraFrame

GRABS_LOST = 3
"""So many failures one after the other and the camera is gone."""
EARLY_SHARE = 0.75
"""A picture that comes when this much of the period has gone by is not too early: cameras jitter."""
VIDEO_RATE_HZ = 25.0
"""Of files that do not say."""


class VideoSource:
    """`poll` gives the next picture. A camera's buffer is kept empty, so that what is given is new.

    `ended` says why there will be no more; `lost` that this was not the end of a file.
    """

    def __init__(
        self,
        source: str,
        width_px: int,
        height_px: int,
        rate_hz: float,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """`source` is an index (`0`), a device (`/dev/video0`) or a file; `rate_hz` the most pictures a second.

        Raises:
            DeviceError: it is not there, may not be read, or is neither camera nor video.
        """
        self.ended = ""
        self.lost = False
        self._source = source
        self._clock = clock
        self._is_file = not source.isdigit() and not source.startswith("/dev/")
        self._capture = _open(source, self._is_file)
        if not self._is_file:
            self._capture.set(cv2.CAP_PROP_FRAME_WIDTH, width_px)
            self._capture.set(cv2.CAP_PROP_FRAME_HEIGHT, height_px)
            self._capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)
        elif (file_rate_hz := float(self._capture.get(cv2.CAP_PROP_FPS))) > 0.0:
            rate_hz = min(rate_hz, file_rate_hz)
        else:
            rate_hz = min(rate_hz, VIDEO_RATE_HZ)
        self._period_s = 1.0 / rate_hz
        self._given_s = -np.inf
        self._frame_id = 0
        self._failures = 0

    def poll(self) -> CameraFrame | None:
        """The newest picture, or None if none is due. With a camera this waits for its next one."""
        early_s = self._period_s * (1.0 if self._is_file else EARLY_SHARE)
        if self._is_file and self._clock() - self._given_s < early_s:
            return None
        if not self._capture.grab():
            self._note_failure()
            return None
        # The nearest to the exposure that OpenCV tells: the picture has just arrived.
        stamp_s = self._clock()
        self._failures = 0
        if stamp_s - self._given_s < early_s:
            return None
        done, image = self._capture.retrieve()
        if not done:
            self._note_failure()
            return None
        self._given_s = stamp_s
        self._frame_id += 1
        return CameraFrame(stamp_s, self._frame_id, np.asarray(image, np.uint8))

    def close(self) -> None:
        self._capture.release()

    def _note_failure(self) -> None:
        if self._is_file:
            self.ended = f"end of {self._source} after {self._frame_id} pictures"
            return
        self._failures += 1
        if self._failures >= GRABS_LOST:
            self.lost = True
            self.ended = f"camera {self._source} gives no more pictures; is it still plugged in?"


def _open(source: str, is_file: bool) -> cv2.VideoCapture:
    if is_file and not Path(source).is_file():
        raise DeviceError(
            f"video {source} is not there; --source takes sim, a camera (0, /dev/video0) or a video file"
        )
    device = f"/dev/video{source}" if source.isdigit() else source
    if not is_file and not Path(device).exists():
        present = ", ".join(sorted(glob.glob("/dev/video*"))) or "none"
        raise DeviceError(
            f"camera {device} is not there (present: {present}); plug it in or choose another --source"
        )
    if not os.access(source if is_file else device, os.R_OK):
        raise DeviceError(f"{device} may not be read; add the user to the group `video` and log in again")
    capture = cv2.VideoCapture(int(source)) if source.isdigit() else cv2.VideoCapture(source)
    if not capture.isOpened():
        capture.release()
        raise DeviceError(f"{source} cannot be opened as a camera or video; does another program hold it?")
    return capture

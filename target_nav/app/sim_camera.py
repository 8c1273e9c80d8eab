"""The simulated camera's thread: draws frames beside the physics and hands them to the detector process.

Drawing takes about 10 ms, which must not delay the serial line, so it has a thread of its own and NumPy and OpenCV
leave the interpreter lock while they work. A frame that comes due while the last one is still drawn is dropped.
"""

from __future__ import annotations

import queue
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from target_nav.state.snapshots import CameraFrame
from target_nav.state.types import Pose2D

Draw = Callable[[Pose2D, float, np.random.Generator], NDArray[np.uint8]]


@dataclass(frozen=True)
class CameraStatistics:
    """Times are of drawing and handing over one frame, over the last 600."""

    frames: int
    dropped: int
    draw_p50_s: float
    draw_p99_s: float


class SimCamera:
    """`expose` never blocks. An error while drawing is raised by the next `expose`."""

    def __init__(self, draw: Draw, write: Callable[[CameraFrame], object], seed: int) -> None:
        self._draw = draw
        self._write = write
        self._rng = np.random.default_rng(seed)
        self._due: queue.Queue[tuple[Pose2D, float] | None] = queue.Queue(maxsize=1)
        self._times_s: deque[float] = deque(maxlen=600)
        self._frames = self._dropped = 0
        self._failure: Exception | None = None
        self._thread = threading.Thread(target=self._run, name="sim camera", daemon=True)
        self._thread.start()

    def expose(self, true_pose: Pose2D, stamp_s: float) -> None:
        """Have a frame drawn of what is seen from `true_pose`."""
        if self._failure is not None:
            raise self._failure
        try:
            self._due.put_nowait((true_pose, stamp_s))
        except queue.Full:
            self._dropped += 1

    def close(self) -> None:
        """Let the frame in work be finished and end the thread."""
        self._due.put(None)
        self._thread.join(timeout=2.0)

    @property
    def statistics(self) -> CameraStatistics:
        times = sorted(self._times_s)
        last = len(times) - 1
        return CameraStatistics(
            self._frames,
            self._dropped,
            times[last // 2] if times else 0.0,
            times[round(0.99 * last)] if times else 0.0,
        )

    def _run(self) -> None:
        while (due := self._due.get()) is not None and self._failure is None:
            pose, stamp_s = due
            begin_s = time.monotonic()
            try:
                image = self._draw(pose, stamp_s, self._rng)
                self._write(CameraFrame(stamp_s, self._frames, image))
            except Exception as error:
                # Kept for the main thread, where the process's one catch is.
                self._failure = error
                continue
            self._frames += 1
            self._times_s.append(time.monotonic() - begin_s)

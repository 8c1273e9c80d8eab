"""Where the robot truly was, so that a sensor can be asked about a moment between two steps."""

from __future__ import annotations

import numpy as np

from target_nav.state.types import FloatArray

KEEP_S = 3.0
"""Longer than the slowest LiDAR's turn (0.5 Hz) and a camera's latency need."""


class PoseHistory:
    """Poses on an even grid of time. Yaw is not wrapped, so that straight lines between poses are right."""

    def __init__(self, start_s: float, step_s: float, x_m: float, y_m: float, yaw_rad: float) -> None:
        self._start_s = start_s
        self._step_s = step_s
        self._dropped = 0
        self._x, self._y, self._yaw = [x_m], [y_m], [yaw_rad]
        self._keep = int(KEEP_S / step_s)

    def append(self, x_m: float, y_m: float, yaw_rad: float) -> None:
        """The pose one step after the last one."""
        self._x.append(x_m)
        self._y.append(y_m)
        self._yaw.append(yaw_rad)
        if len(self._x) > 2 * self._keep:
            drop = len(self._x) - self._keep
            del self._x[:drop], self._y[:drop], self._yaw[:drop]
            self._dropped += drop

    def at(self, stamp_s: float) -> tuple[float, float, float]:
        """x, y, yaw at a moment; the nearest end where the moment lies outside."""
        place = (stamp_s - self._start_s) / self._step_s - self._dropped
        last = len(self._x) - 1
        i = int(place)
        if place <= 0.0 or last == 0:
            return self._x[0], self._y[0], self._yaw[0]
        if i >= last:
            return self._x[last], self._y[last], self._yaw[last]
        f = place - i
        return (
            self._x[i] + f * (self._x[i + 1] - self._x[i]),
            self._y[i] + f * (self._y[i + 1] - self._y[i]),
            self._yaw[i] + f * (self._yaw[i + 1] - self._yaw[i]),
        )

    def at_many(self, stamps_s: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The same for ascending moments, shape (N,) each."""
        first, last = (
            int((stamp - self._start_s) / self._step_s) - self._dropped for stamp in stamps_s[[0, -1]]
        )
        end = max(min(last + 2, len(self._x)), 1)
        begin = min(max(first, 0), end - 1)
        grid = np.arange(begin + self._dropped, end + self._dropped) * self._step_s + self._start_s
        return (
            np.interp(stamps_s, grid, self._x[begin:end]),
            np.interp(stamps_s, grid, self._y[begin:end]),
            np.interp(stamps_s, grid, self._yaw[begin:end]),
        )

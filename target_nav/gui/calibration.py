"""Camera and distance calibration with a pin at a known place: straight ahead, so far in front of the robot.

The pinhole model makes range proportional to the focal length, so the focal length is off by the same factor as the
range is; and a pin that stands straight ahead is seen at minus the camera's yaw error. Medians, because a detector's
boxes have outliers.
"""

from __future__ import annotations

import math
import statistics
from dataclasses import dataclass

from target_nav.config import Config
from target_nav.gui.source import World

LEAST_SAMPLES = 15
MOST_SAMPLES = 60
MOST_FOCAL_CHANGE, MOST_YAW_CHANGE_RAD = 0.25, 0.1
"""Another unit's calibration is 4.4 % off, a mount 0.8 degrees (measured): more is a pin at the wrong place."""


@dataclass(frozen=True)
class CalibrationResult:
    """`focal_px` and `yaw_rad` are the values to set; `spread` is the relative deviation of the ranges (MAD based)."""

    samples: int
    measured_m: float
    true_m: float
    focal_px: float
    yaw_rad: float
    spread: float
    problem: str = ""
    """Why it must not be kept: a result so far from the present values says that the pin stood elsewhere."""

    @property
    def text(self) -> str:
        return (
            f"seen at {self.measured_m:.3f} m, stands at {self.true_m:.3f} m: focal length {self.focal_px:.1f} px, "
            f"camera yaw {math.degrees(self.yaw_rad):+.2f}°, spread {100 * self.spread:.1f} % of {self.samples} boxes"
        )


class PinCalibration:
    """Collects one detection a frame; `gap_m` is from the robot's front edge to the pin's surface."""

    def __init__(self, config: Config, gap_m: float, pin_width_m: float) -> None:
        camera = config.camera
        self.true_m = gap_m + config.robot.front_m + 0.5 * pin_width_m - camera.x_m
        self._focal_px, self._yaw_rad = camera.focal_px, camera.yaw_rad
        # left of the camera's axis is where the pin is, when the camera is mounted to the right of the middle
        self._true_bearing_rad = math.atan2(-camera.y_m, self.true_m)
        self._frame_id = -1
        self._samples: list[tuple[float, float]] = []

    @property
    def count(self) -> int:
        return len(self._samples)

    @property
    def done(self) -> bool:
        return self.count >= MOST_SAMPLES

    def see(self, world: World) -> None:
        """Take a new frame's best box of the target's class, unless it is clipped or older than it may be."""
        frame, nav = world.det.value, world.nav.value
        if (
            frame is None
            or nav is None
            or not world.det.fresh
            or frame.frame_id == self._frame_id
            or self.done
        ):
            return
        self._frame_id = frame.frame_id
        usable = [
            d for d in frame.detections
            if d.class_name == nav.spec.class_name and d.confirmed and not d.clipped and math.isfinite(d.range_m)
        ]  # fmt: skip
        if usable:
            best = max(usable, key=lambda d: d.score)
            self._samples.append((best.range_m, best.bearing_rad))

    def result(self) -> CalibrationResult | None:
        """None before there are enough boxes."""
        if self.count < LEAST_SAMPLES:
            return None
        ranges, bearings = zip(*self._samples)
        measured = statistics.median(ranges)
        spread = 1.4826 * statistics.median(abs(r - measured) for r in ranges) / measured
        # the direction in base_link is yaw + bearing: it should be the true one
        yaw = self._true_bearing_rad - statistics.median(bearings)
        focal_px = self._focal_px * self.true_m / measured
        problem = ""
        if (
            abs(focal_px / self._focal_px - 1.0) > MOST_FOCAL_CHANGE
            or abs(yaw - self._yaw_rad) > MOST_YAW_CHANGE_RAD
        ):
            problem = (
                "the target does not stand where the number says: straight ahead, so far from the front edge"
            )
        return CalibrationResult(self.count, measured, self.true_m, focal_px, yaw, spread, problem)

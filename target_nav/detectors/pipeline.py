"""From the boxes of one frame to objects with a range and a bearing: what the camera process does, without the process.

Virtual time calls this as well, so it reads no clock and imports no OpenCV. Three layers keep false boxes out: the
detector's score, the shape against the target's real size, and tracking from frame to frame. Each counts what it
refuses.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass

from target_nav.config import Config
from target_nav.detectors.tracking import BoxTracker, TrackedBox
from target_nav.errors import StaleInput
from target_nav.state.target_label import is_scaled_by_width
from target_nav.state.types import Detection, DetectionFrame, RawDetection, RawDetectionFrame, TargetSpec
from target_nav.utils.distance import (
    Box,
    Clipping,
    bearing_from_u,
    bearing_sigma,
    clipping_of,
    range_from_height,
    range_from_width,
    range_sigma,
)

CLIPPED_RANGE_SIGMA = 1.0
"""Of the range: a clipped box measures what fits into the picture, not the target."""


@dataclass
class PipelineCounters:
    """What became of every box: boxes = malformed + other_class + low_score + wrong_shape + unconfirmed + confirmed.

    `clipped` counts those of the last two that touched the border.
    """

    frames: int = 0
    boxes: int = 0
    malformed: int = 0
    other_class: int = 0
    low_score: int = 0
    wrong_shape: int = 0
    unconfirmed: int = 0
    confirmed: int = 0
    clipped: int = 0

    def as_dict(self) -> dict[str, int]:
        return asdict(self)


class DetectionPipeline:
    """Keeps the tracker between frames; everything else is a function of the frame."""

    def __init__(self, config: Config) -> None:
        self.counters = PipelineCounters()
        self._camera = config.camera
        self._detector = config.detector
        self._tracker = BoxTracker(config)
        self._bearing_sigma_rad = bearing_sigma(config.detector)
        self._spec: TargetSpec | None = None
        self._last_stamp_s = -math.inf

    def process(self, raw: RawDetectionFrame, spec: TargetSpec) -> DetectionFrame:
        """Objects of `spec` in this frame, those not confirmed yet included and marked so.

        An object that is out of sight is not in the frame, though its id is kept for a while: a prediction is no
        measurement. Another spec than last time starts the tracker anew.

        Raises:
            StaleInput: the frame is not newer than the one before; it must not be taken for a second look.
        """
        if not raw.stamp_s > self._last_stamp_s or math.isinf(raw.stamp_s):
            raise StaleInput(
                f"detection frame {raw.frame_id} was taken at {raw.stamp_s:.3f} s, the one before at "
                f"{self._last_stamp_s:.3f} s; stamps must grow: is a second detector writing?"
            )
        self._last_stamp_s = raw.stamp_s
        if spec != self._spec:
            self._spec = spec
            self._tracker.reset()
        self.counters.frames += 1
        kept: list[tuple[RawDetection, Box, Clipping]] = []
        for detection in raw.detections:
            candidate = self._examine(detection, spec)
            if candidate is not None:
                kept.append(candidate)
        tracks = self._tracker.update(raw.stamp_s, [box for _, box, _ in kept])
        detections = tuple(
            self._place(detection, box, clipping, track, spec)
            for (detection, box, clipping), track in zip(kept, tracks)
        )
        return DetectionFrame(raw.stamp_s, raw.frame_id, detections)

    def _examine(self, raw: RawDetection, spec: TargetSpec) -> tuple[RawDetection, Box, Clipping] | None:
        """First and second layer."""
        counters = self.counters
        counters.boxes += 1
        if not self._is_well_formed(raw):
            counters.malformed += 1
            return None
        if raw.class_name != spec.class_name:
            counters.other_class += 1
            return None
        if raw.score < self._detector.score_min:
            counters.low_score += 1
            return None
        box = Box(raw.u_px, raw.v_px, raw.width_px, raw.height_px)
        clipping = clipping_of(self._camera, box, self._detector.border_px)
        if not self._has_shape(box, clipping, spec):
            counters.wrong_shape += 1
            return None
        return raw, box, clipping

    def _is_well_formed(self, raw: RawDetection) -> bool:
        total = raw.score + raw.u_px + raw.v_px + raw.width_px + raw.height_px
        return (
            math.isfinite(total)
            and 0.0 <= raw.score <= 1.0
            and raw.width_px > 0.0
            and raw.height_px > 0.0
            and 0.0 <= raw.u_px <= self._camera.width_px
            and 0.0 <= raw.v_px <= self._camera.height_px
        )

    def _has_shape(self, box: Box, clipping: Clipping, spec: TargetSpec) -> bool:
        """Width to height as the target's, off the axis a little wider. A border can only take away: a box that lost
        height may look too wide, one that lost width too slim, and neither speaks against it."""
        square = spec.width_m / spec.height_m / self._camera.pixel_aspect
        expected = square / math.cos(bearing_from_u(self._camera, box.u_px))
        deviation = math.log(box.width_px / box.height_px / expected)
        tolerance = self._detector.aspect_tolerance
        too_wide = deviation > tolerance and not clipping.upright
        too_slim = deviation < -tolerance and not clipping.sideways
        return not (too_wide or too_slim)

    def _place(
        self, raw: RawDetection, box: Box, clipping: Clipping, track: TrackedBox, spec: TargetSpec
    ) -> Detection:
        counters = self.counters
        if track.confirmed:
            counters.confirmed += 1
        else:
            counters.unconfirmed += 1
        if clipping.any:
            counters.clipped += 1
            range_m, range_sigma_m, bearing_rad, bearing_sigma_rad = self._measure_clipped(
                box, clipping, spec
            )
        else:
            bearing_rad = bearing_from_u(self._camera, box.u_px)
            bearing_sigma_rad = self._bearing_sigma_rad
            if is_scaled_by_width(spec.class_name):
                range_m = range_from_width(self._camera, spec.width_m, box.width_px, bearing_rad)
                range_sigma_m = range_sigma(self._detector, range_m, box.width_px)
            else:
                range_m = range_from_height(self._camera, spec.height_m, box.height_px, bearing_rad)
                range_sigma_m = range_sigma(self._detector, range_m, box.height_px)
        return Detection(
            raw.class_name,
            raw.score,
            track.track_id,
            box.u_px,
            box.v_px,
            box.width_px,
            box.height_px,
            range_m,
            range_sigma_m,
            bearing_rad,
            bearing_sigma_rad,
            clipping.any,
            track.confirmed,
        )

    def _measure_clipped(
        self, box: Box, clipping: Clipping, spec: TargetSpec
    ) -> tuple[float, float, float, float]:
        """(range, its sigma, bearing, its sigma) of a box whose true size is at least what is seen.

        Both sizes then give a range that is too long, so the shorter is the better one, and its sigma says that it is
        an upper limit. A box cut off at one side still shows its other edge: the axis lies half a width from that.
        """
        camera = self._camera
        bearing_rad = bearing_from_u(camera, box.u_px)
        range_m = min(
            range_from_height(camera, spec.height_m, box.height_px, bearing_rad),
            range_from_width(camera, spec.width_m, box.width_px, bearing_rad),
        )
        whole_width_px = camera.focal_px * spec.width_m / (range_m * math.cos(bearing_rad) ** 2)
        hidden_px = max(whole_width_px - box.width_px, 0.0)
        left_px, _, right_px, _ = box.edges
        if clipping.left and not clipping.right:
            bearing_rad = bearing_from_u(camera, right_px - 0.5 * whole_width_px)
        elif clipping.right and not clipping.left:
            bearing_rad = bearing_from_u(camera, left_px + 0.5 * whole_width_px)
        # Uniform over the hidden part: its half, over the square root of three.
        extra_rad = 0.5 * hidden_px / math.sqrt(3.0) / camera.focal_px if clipping.sideways else 0.0
        return (
            range_m,
            CLIPPED_RANGE_SIGMA * range_m,
            bearing_rad,
            math.hypot(self._bearing_sigma_rad, extra_rad),
        )

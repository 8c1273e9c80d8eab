"""Raw boxes as a perfect detector would give them."""

from __future__ import annotations

from target_nav.config import Config
from target_nav.state.types import RawDetection, RawDetectionFrame, TargetSpec
from target_nav.utils.distance import Box, clip_box, project

CONFIG = Config()
PIN = TargetSpec()


def raw(box: Box, score: float = 0.9, class_name: str = "bowling_pin") -> RawDetection:
    return RawDetection(class_name, score, box.u_px, box.v_px, box.width_px, box.height_px)


def raw_at(
    range_m: float, bearing_rad: float = 0.0, score: float = 0.9, spec: TargetSpec = PIN
) -> RawDetection:
    """The visible part of a target's box; it must be in the picture."""
    box = project(CONFIG.camera, range_m, bearing_rad, spec.height_m, spec.width_m)
    visible = clip_box(CONFIG.camera, box) if box is not None else None
    assert visible is not None
    return raw(visible, score, spec.class_name)


def frame(index: int, *detections: RawDetection, period_s: float = 0.1) -> RawDetectionFrame:
    return RawDetectionFrame(10.0 + period_s * index, index, detections)

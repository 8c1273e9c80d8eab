"""The camera's picture, and over it the boxes that the camera process stands behind."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from target_nav.gui.source import World
from target_nav.state.types import Detection, TargetSpec, Track

_SAME_BEARING_RAD = 0.15
"""A box in the track's direction is the target's; others are only candidates."""


@dataclass(frozen=True)
class BoxView:
    """One box in pixels of the picture. `score` is 0 ... 1; `range_m` of a clipped box is not to be believed."""

    left_px: float
    top_px: float
    right_px: float
    bottom_px: float
    class_name: str
    score: float
    range_m: float
    bearing_rad: float
    confirmed: bool
    clipped: bool
    is_target: bool
    label: str


@dataclass(frozen=True, eq=False)
class CameraView:
    """`image_bgr` is the newest picture there ever was, None without one; `fresh` says whether to believe it."""

    image_bgr: NDArray[np.uint8] | None
    frame_id: int
    width_px: int
    height_px: int
    age_s: float
    fresh: bool
    message: str
    boxes: tuple[BoxView, ...]
    boxes_age_s: float
    boxes_fresh: bool
    boxes_message: str


def camera_view(world: World, width_px: int = 640, height_px: int = 480) -> CameraView:
    """`width_px` and `height_px` stand in while there is no picture: boxes can be shown without one."""
    frame, nav = world.camera.value, world.nav.value
    image = frame.image_bgr if frame is not None else None
    if image is not None:
        height_px, width_px = image.shape[:2]
    detections = world.det.value
    spec = nav.spec if nav is not None else TargetSpec()
    track = nav.track if nav is not None and world.nav.fresh else None
    boxes = tuple(_box(d, spec, track) for d in detections.detections) if detections is not None else ()
    return CameraView(
        image_bgr=image,
        frame_id=frame.frame_id if frame is not None else -1,
        width_px=width_px,
        height_px=height_px,
        age_s=world.camera.age_s,
        fresh=world.camera.fresh,
        message=world.camera.excuse,
        boxes=boxes,
        boxes_age_s=world.det.age_s,
        boxes_fresh=world.det.fresh,
        boxes_message=world.det.excuse,
    )


def _box(d: Detection, spec: TargetSpec, track: Track | None) -> BoxView:
    is_target = (
        track is not None
        and d.class_name == spec.class_name
        and abs(math.remainder(d.bearing_rad - track.bearing_rad, math.tau)) < _SAME_BEARING_RAD
    )
    far = "clipped" if d.clipped else f"{d.range_m:.2f} m"
    return BoxView(
        left_px=d.u_px - 0.5 * d.width_px,
        top_px=d.v_px - 0.5 * d.height_px,
        right_px=d.u_px + 0.5 * d.width_px,
        bottom_px=d.v_px + 0.5 * d.height_px,
        class_name=d.class_name,
        score=d.score,
        range_m=d.range_m,
        bearing_rad=d.bearing_rad,
        confirmed=d.confirmed,
        clipped=d.clipped,
        is_target=is_target,
        label=f"{d.class_name.replace('_', ' ')} {far} {100 * d.score:.0f}%",
    )

"""The things that stand on the floor, by class: what they measure and what colour they are.

A thing is an upright cylinder for the LiDAR, the footprint and the box camera. Sizes are those of shop goods; the pin's
are the reference's.
"""

from __future__ import annotations

import difflib
from dataclasses import dataclass

Rgb = tuple[int, int, int]


@dataclass(frozen=True)
class ObjectShape:
    """`band_rgb` is a stripe round the thing, None if it has none."""

    radius_m: float
    height_m: float
    body_rgb: Rgb
    band_rgb: Rgb | None = None


OBJECTS: dict[str, ObjectShape] = {
    "bowling_pin": ObjectShape(0.040, 0.28, (240, 238, 230), (200, 30, 35)),
    "bottle": ObjectShape(0.035, 0.25, (30, 110, 60), (235, 235, 235)),
    "can": ObjectShape(0.033, 0.115, (190, 30, 40), (225, 225, 225)),
    "cup": ObjectShape(0.042, 0.10, (235, 235, 240)),
    "vase": ObjectShape(0.070, 0.30, (70, 100, 160)),
    "ball": ObjectShape(0.110, 0.22, (235, 130, 40)),
    "cone": ObjectShape(0.110, 0.30, (240, 90, 20), (245, 245, 245)),
    "bin": ObjectShape(0.140, 0.30, (90, 95, 100)),
    "chair_leg": ObjectShape(0.020, 0.45, (110, 75, 45)),
}

OBSTACLE_HEIGHT_M = 0.5
"""Boxes, circles and walls: higher than the LiDAR, the camera and every pin, so they hide what is behind them."""

TAG_PREFIX = "apriltag:"
"""A tag's class is the label that its detector gives it: `apriltag:7`."""
TAG_FAMILY_SIZE = 587
TAG_SIDE_M, TAG_MIDDLE_M = 0.16, 0.16
"""Outer edge of the black square, and how high its middle hangs."""
TAG_CELLS, TAG_MARGIN_CELLS = 8, 1
"""36h11 with its black border is eight cells wide; one white cell is left round it."""
_TAG_SHAPE = ObjectShape(0.0, TAG_SIDE_M, (255, 255, 255))
"""Flat: neither the LiDAR nor the footprint meets it, but the wall it hangs on."""


def tag_number(class_name: str) -> int:
    """The number of a tag's class; -1: not a tag."""
    what = class_name.removeprefix(TAG_PREFIX)
    is_tag = class_name.startswith(TAG_PREFIX) and what.isascii() and what.isdecimal()
    return int(what) if is_tag and int(what) < TAG_FAMILY_SIZE else -1


def is_tag(class_name: str) -> bool:
    return tag_number(class_name) >= 0


def is_class(name: str) -> bool:
    return name in OBJECTS or is_tag(name)


def shape_of(class_name: str) -> ObjectShape:
    """Raises KeyError for a class that there is not."""
    return _TAG_SHAPE if is_tag(class_name) else OBJECTS[class_name]


def unknown_class(name: str) -> str:
    """What to tell somebody who wrote a class that there is not."""
    if name.startswith(TAG_PREFIX):
        return f"{name!r} is not a tag of the family 36h11; {TAG_PREFIX}0 ... {TAG_PREFIX}{TAG_FAMILY_SIZE - 1} are"
    near = difflib.get_close_matches(name, OBJECTS, n=1)
    hint = f"did you mean {near[0]!r}?" if near else f"known: {', '.join(sorted(OBJECTS))}"
    return f"there is no class {name!r}; {hint}"

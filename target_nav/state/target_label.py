"""A target's label: which detector finds it, and what that detector looks for.

`bowling_pin` is the trained network's class, `colour:green` a green thing, `two_boxes:green` a pair of them,
`apriltag:7` a tag. The label is the class name wherever a target travels: in shared memory, on every box.
"""

from __future__ import annotations

from enum import Enum

from target_nav.errors import ConfigError


class TargetDetector(str, Enum):
    """Named as a mission's author writes them."""

    network = "network"
    """The trained network."""
    outline = "outline"
    """A pin's stripes and outline, without a network."""
    colour = "colour"
    """The share of red, green or blue in the light."""
    hsv = "hsv"
    """Hue, saturation and value."""
    two_boxes = "two_boxes"
    """Two boxes of one colour; the target's width is the gap between their middles."""
    apriltag = "apriltag"
    """A tag of the family 36h11, by number."""


def make_label(detector: TargetDetector, what: str) -> str:
    """Raises:
    ConfigError: nothing to look for, or a name that would not come apart again.
    """
    if not what or ":" in what:
        raise ConfigError(
            f"the detector {detector.value!r} cannot look for {what!r}: a class, a colour or a tag's number"
        )
    return what if detector is TargetDetector.network else f"{detector.value}:{what}"


def split_label(label: str) -> tuple[TargetDetector, str]:
    """The detector, and what it looks for.

    Raises:
        ConfigError: no such detector, or nothing to look for.
    """
    name, colon, what = label.partition(":")
    if not colon:
        name, what = TargetDetector.network.value, label
    if name not in TargetDetector.__members__ or not what:
        raise ConfigError(f"no detector for {label!r}; known: {', '.join(TargetDetector.__members__)}")
    return TargetDetector[name], what


def is_scaled_by_width(label: str) -> bool:
    """Whether the range comes from the width of the box, not from its height."""
    return label.startswith(f"{TargetDetector.two_boxes.value}:")

"""Glance, then look: what is small in the whole frame is looked at once more in the frame's own pixels.

At half size a pin 3 m away is 26 pixels high: its height is off by 5 %, its width by 40 %, and a bright thing passes
for one. The network is fully convolutional, so it also takes a part of the frame, at a quarter of the cost. This file
is the rule, without pictures; `docs/model.md` has it as a contract, and the C++ detector goes by the same numbers.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from target_nav.detectors.onnx_heads import BOXES_MAX, OVERLAP_MAX, ScoredBox

LOOK_WIDTH, LOOK_HEIGHT = 160, 128
"""Of the part, pixels of the frame and of the network alike."""
LOOK_BELOW_PX = 96.0
"""A box less high and less wide than this is small."""
LOOKS_MAX = 2
GLANCE_SCORE_MIN = 0.15
"""From which score on a small box is worth a look."""
LOOK_MARGIN_PX = 4.0
"""A box nearer than this to the part's border may be cut by it, unless the frame ends there."""
SAME_OVERLAP_MIN = 0.3
"""Of what was glanced at and what the look sees, to be one thing."""


@dataclass(frozen=True)
class Part:
    """The corner of what is looked at: LOOK_WIDTH x LOOK_HEIGHT pixels of a frame."""

    left: int
    top: int

    @classmethod
    def around(cls, box: ScoredBox, frame_width: int, frame_height: int) -> Part:
        """With the box in its middle as far as the frame's borders allow. The frame must not be smaller."""
        return cls(
            _start(0.5 * (box.left + box.right), LOOK_WIDTH, frame_width),
            _start(0.5 * (box.top + box.bottom), LOOK_HEIGHT, frame_height),
        )

    def holds(self, box: ScoredBox, frame_width: int, frame_height: int) -> bool:
        """The whole box, with its margin where the frame goes on."""
        return (
            _inside(box.left, box.right, self.left, self.left + LOOK_WIDTH, frame_width)
            and _inside(box.top, box.bottom, self.top, self.top + LOOK_HEIGHT, frame_height)
        )  # fmt: skip


def _start(middle: float, size: int, limit: int) -> int:
    return min(max(math.floor(middle - 0.5 * size + 0.5), 0), limit - size)


def _inside(low: float, high: float, start: int, end: int, limit: int) -> bool:
    return (start == 0 or low >= start + LOOK_MARGIN_PX) and (end == limit or high <= end - LOOK_MARGIN_PX)


def look_again(
    glanced: Sequence[ScoredBox],
    look: Callable[[Part], Sequence[ScoredBox]],
    frame_width: int,
    frame_height: int,
    score_min: float,
) -> list[ScoredBox]:
    """Boxes of one frame, best score first.

    `glanced` are those of the whole frame from min(`score_min`, GLANCE_SCORE_MIN) on, best first, after suppression;
    `look(part)` gives those of a part in the frame's pixels, from `score_min` on, best first, after suppression.
    """
    if frame_width < LOOK_WIDTH or frame_height < LOOK_HEIGHT:
        return [box for box in glanced if box.score >= score_min]
    open_: list[ScoredBox] = [box for box in glanced if _is_small(box)]
    kept = [box for box in glanced if not _is_small(box) and box.score >= score_min]
    for _ in range(LOOKS_MAX):
        first = next((box for box in open_ if box.score >= GLANCE_SCORE_MIN), None)
        if first is None:
            break
        part = Part.around(first, frame_width, frame_height)
        settled = [box for box in open_ if box is first or part.holds(box, frame_width, frame_height)]
        open_ = [box for box in open_ if not any(box is other for other in settled)]
        for seen in look(part):
            if part.holds(seen, frame_width, frame_height) and any(
                overlap(seen, box) >= SAME_OVERLAP_MIN for box in settled
            ):
                kept.append(seen)
    kept += [box for box in open_ if box.score >= score_min]
    return _best_first(kept)


def _is_small(box: ScoredBox) -> bool:
    return box.bottom - box.top < LOOK_BELOW_PX and box.right - box.left < LOOK_BELOW_PX


def _best_first(boxes: list[ScoredBox]) -> list[ScoredBox]:
    """Greedy suppression, as after the glance; of equal scores the earlier stays."""
    chosen: list[ScoredBox] = []
    for box in sorted(boxes, key=lambda box: -box.score):
        if len(chosen) < BOXES_MAX and all(overlap(box, other) <= OVERLAP_MAX for other in chosen):
            chosen.append(box)
    return chosen


def overlap(first: ScoredBox, second: ScoredBox) -> float:
    """Intersection over union."""
    width = min(first.right, second.right) - max(first.left, second.left)
    height = min(first.bottom, second.bottom) - max(first.top, second.top)
    if width <= 0.0 or height <= 0.0:
        return 0.0
    common = width * height
    areas = sum((box.right - box.left) * (box.bottom - box.top) for box in (first, second))
    return common / (areas - common)

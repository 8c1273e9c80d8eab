"""Glance, then look: what is small in the whole frame is looked at once more, enlarged.

At half size a pin 3 m away is 26 pixels high: its height is off by 5 %, its width by 40 %, and a bright thing passes
for one. The network is fully convolutional, so it also takes a part of the frame, at a quarter of the cost. This file
is the rule, without pictures; `docs/model.md` has it as a contract, and the C++ detector goes by the same numbers.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from target_nav.detectors.onnx_heads import BOXES_MAX, OVERLAP_MAX, ScoredBox

LOOK_WIDTH, LOOK_HEIGHT = 160, 128
"""What the network gets to see of a part, pixels."""
PART_SIZES = ((80, 64), (100, 80), (120, 96), (160, 128))
"""Of a part in the frame, pixels. Enlarged to LOOK_WIDTH x LOOK_HEIGHT, twice at most."""
PART_FILL_MAX = 0.625
"""A part is the smallest of which a box fills no more than this share, in height and in width."""
LOOK_BELOW_PX = 96.0
"""A box less high and less wide than this is small."""
LOOKS_MAX = 2
GLANCE_SCORE_MIN = 0.15
"""From which score on a small box is worth a look."""
LOOK_MARGIN_PX = 4.0
"""A box nearer than this to the part's border may be cut by it, unless the frame ends there."""
EDGE_BIAS_PX = 0.25
"""So far above and below the thing this network's looks end, in the frame's pixels, whatever the enlargement (measured
on 490 pictures, docs/model.md)."""
SAME_OVERLAP_MIN = 0.3
"""Of what was glanced at and what the look sees, to be one thing."""


@dataclass(frozen=True)
class Part:
    """What is looked at, pixels of the frame."""

    left: int
    top: int
    width: int
    height: int

    @classmethod
    def around(cls, box: ScoredBox, frame_width: int, frame_height: int) -> Part:
        """With the box in its middle as far as the frame's borders allow. The frame must not be smaller."""
        width, height = _part_size(box)
        return cls(
            _start(0.5 * (box.left + box.right), width, frame_width),
            _start(0.5 * (box.top + box.bottom), height, frame_height),
            width,
            height,
        )

    def holds(self, box: ScoredBox, frame_width: int, frame_height: int) -> bool:
        """The whole box, with its margin where the frame goes on."""
        return (
            _inside(box.left, box.right, self.left, self.left + self.width, frame_width)
            and _inside(box.top, box.bottom, self.top, self.top + self.height, frame_height)
        )  # fmt: skip


def _part_size(box: ScoredBox) -> tuple[int, int]:
    for width, height in PART_SIZES:
        if box.bottom - box.top <= PART_FILL_MAX * height and box.right - box.left <= PART_FILL_MAX * width:
            return width, height
    return PART_SIZES[-1]


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
    if frame_width < PART_SIZES[-1][0] or frame_height < PART_SIZES[-1][1]:
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
            if part.holds(seen, frame_width, frame_height):
                # Best first, so it is the best glance at the same thing.
                same = next((box for box in settled if overlap(seen, box) >= SAME_OVERLAP_MIN), None)
                if same is not None and (score := combined(same.score, seen.score)) >= score_min:
                    kept.append(_measured(seen, score, frame_height))
    kept += [box for box in open_ if box.score >= score_min]
    return _best_first(kept)


def _measured(seen: ScoredBox, score: float, frame_height: int) -> ScoredBox:
    """Less the bias of both edges; an edge at the frame's border stays there, so that the border rule flags it."""
    top = seen.top + EDGE_BIAS_PX if seen.top > 0.0 else seen.top
    bottom = seen.bottom - EDGE_BIAS_PX if seen.bottom < frame_height else seen.bottom
    return replace(seen, score=score, top=top, bottom=bottom)


def combined(glance: float, look: float) -> float:
    """Geometric mean of the two scores, the look's taken twice: both have to see something."""
    return float((glance * look * look) ** (1.0 / 3.0))


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

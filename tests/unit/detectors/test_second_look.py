"""Glance, then look: what is looked at again, where, and what becomes of it.

`drpai/tests/test_second_look.cpp` says the same of the C++ detector.
"""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.detectors.onnx_heads import OVERLAP_MAX, ScoredBox
from target_nav.detectors.second_look import (
    EDGE_BIAS_PX,
    GLANCE_SCORE_MIN,
    LOOKS_MAX,
    PART_SIZES,
    Part,
    look_again,
    overlap,
)

WIDTH, HEIGHT = 640, 480


def box(score: float, u: float, v: float, width: float, height: float) -> ScoredBox:
    return ScoredBox(score, u - 0.5 * width, v - 0.5 * height, u + 0.5 * width, v + 0.5 * height)


class Seen:
    """Answers look after look, and keeps what was looked at."""

    def __init__(self, *answers: list[ScoredBox]) -> None:
        self.parts: list[Part] = []
        self._answers = answers

    def __call__(self, part: Part) -> list[ScoredBox]:
        self.parts.append(part)
        return self._answers[len(self.parts) - 1] if len(self.parts) <= len(self._answers) else []


def after(seen: Seen, *glanced: ScoredBox, score_min: float = 0.5) -> list[ScoredBox]:
    return look_again(glanced, seen, WIDTH, HEIGHT, score_min)


def test_a_large_box_needs_no_second_look() -> None:
    seen = Seen()
    large = box(0.9, 300, 200, 40, 96)
    assert after(seen, large, box(0.3, 500, 200, 96, 40)) == [large]
    assert seen.parts == []


def test_what_the_look_sees_takes_the_glances_place_also_below_its_threshold() -> None:
    seen = Seen([box(0.8, 301, 201, 15, 50)])
    (found,) = after(seen, box(0.2, 300, 200, 20, 48))
    assert seen.parts == [Part(250, 160, 100, 80)]
    assert found.score == pytest.approx((0.2 * 0.8 * 0.8) ** (1 / 3))
    assert (found.left, found.right) == (293.5, 308.5)
    assert (found.top, found.bottom) == (176 + EDGE_BIAS_PX, 226 - EDGE_BIAS_PX)


def test_both_the_glance_and_the_look_must_see_something() -> None:
    assert after(Seen([box(0.6, 300, 200, 20, 48)]), box(0.2, 300, 200, 20, 48)) == []


@pytest.mark.parametrize(
    ("width", "height", "size"),
    [(10, 40, (80, 64)), (10, 41, (100, 80)), (10, 50, (100, 80)), (10, 51, (120, 96)), (10, 60, (120, 96)),
     (10, 61, (160, 128)), (10, 95, (160, 128)), (51, 20, (100, 80))],
)  # fmt: skip
def test_a_part_is_the_smallest_that_leaves_room_round_the_box(
    width: float, height: float, size: tuple[int, int]
) -> None:
    part = Part.around(box(0.5, 300, 200, width, height), WIDTH, HEIGHT)
    assert (part.width, part.height) == size


def test_what_the_look_does_not_see_is_no_object_and_what_it_sees_elsewhere_is_none_either() -> None:
    assert after(Seen([box(0.9, 260, 180, 15, 40)]), box(0.7, 300, 200, 20, 48)) == []


@pytest.mark.parametrize(
    ("u", "v", "corner"),
    [(5, 5, (0, 0)), (635, 475, (480, 352)), (80, 64, (0, 0)), (81, 65, (1, 1)), (80.5, 64.49, (1, 0))],
)
def test_the_part_stays_in_the_frame(u: float, v: float, corner: tuple[int, int]) -> None:
    part = Part.around(box(0.5, u, v, 10, 80), WIDTH, HEIGHT)
    assert (part.left, part.top) == corner


def test_one_look_settles_all_that_it_holds_and_the_third_group_keeps_the_glances_word() -> None:
    seen = Seen()
    third = box(0.6, 100, 400, 15, 40)
    found = after(
        seen,
        box(0.9, 100, 100, 15, 40),
        box(0.8, 120, 100, 15, 40),
        box(0.7, 400, 100, 15, 40),
        third,
        box(0.4, 600, 400, 15, 40),
    )
    assert found == [third]
    assert len(seen.parts) == LOOKS_MAX


def test_a_box_that_the_parts_border_may_cut_is_left_out_one_at_the_frames_border_is_not() -> None:
    seen = Seen([box(0.9, 252, 200, 20, 48)], [box(0.9, 8, 450, 16, 60)])
    (found,) = after(seen, box(0.9, 300, 200, 20, 48), box(0.8, 8, 450, 16, 60))
    assert (found.left, found.bottom) == (0, HEIGHT)


def test_a_small_frame_or_a_score_too_low_is_not_looked_at_again() -> None:
    seen = Seen()
    one = box(0.9, 50, 50, 15, 40)
    assert look_again([one], seen, PART_SIZES[-1][0] - 1, HEIGHT, 0.5) == [one]
    assert after(seen, box(0.99 * GLANCE_SCORE_MIN, 50, 50, 15, 40)) == []
    assert seen.parts == []


boxes = st.builds(
    box,
    st.floats(0.0, 1.0),
    st.floats(0, WIDTH),
    st.floats(0, HEIGHT),
    st.floats(2, 150),
    st.floats(2, 150),
)


@given(st.lists(boxes, max_size=12), st.lists(st.lists(boxes, max_size=6), max_size=3))
def test_whatever_is_seen_boxes_come_best_first_apart_and_above_the_threshold(
    glanced: list[ScoredBox], answers: list[list[ScoredBox]]
) -> None:
    seen = Seen(*([b for b in answer if b.score >= 0.5] for answer in answers))
    found = after(seen, *sorted(glanced, key=lambda b: -b.score))
    assert [b.score for b in found] == sorted((b.score for b in found), reverse=True)
    assert all(b.score >= 0.5 for b in found)
    assert all(overlap(a, b) <= OVERLAP_MAX for i, a in enumerate(found) for b in found[:i])
    assert len(seen.parts) <= LOOKS_MAX
    for part in seen.parts:
        assert 0 <= part.left <= WIDTH - part.width
        assert 0 <= part.top <= HEIGHT - part.height

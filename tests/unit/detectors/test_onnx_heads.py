"""From raw heads to boxes: the decoder says exactly what the heads say, whatever the size of the frame."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.detectors.onnx_heads import (
    BOXES_MAX,
    INPUT_HEIGHT,
    INPUT_WIDTH,
    OVERLAP_MAX,
    Letterbox,
    ScoredBox,
    decode_heads,
    stride_of,
)

FULL = Letterbox.of(640, 480)


def empty_heads() -> list[np.ndarray]:
    heads = [np.zeros((1, 5, INPUT_HEIGHT // s, INPUT_WIDTH // s), np.float32) for s in (8, 16, 32)]
    for head in heads:
        head[0, 0] = -20.0
    return heads


def say(heads: list[np.ndarray], stride: int, row: int, column: int, *values: float) -> None:
    next(head for head in heads if stride_of(head) == stride)[0, :, row, column] = values


def decode(heads: list[np.ndarray], score_min: float = 0.3) -> list[ScoredBox]:
    return decode_heads(heads, FULL, 640, 480, score_min)


def test_a_640x480_frame_is_halved_and_gets_eight_rows_above_and_below() -> None:
    assert Letterbox.of(640, 480) == Letterbox(0.5, 0, 8, 320, 240)
    frame = np.zeros((480, 640, 3), np.uint8)
    frame[:, :, 2] = 255
    blob = FULL.apply(frame)
    assert blob.shape == (1, 3, 256, 320)
    assert blob.dtype == np.float32
    assert blob[0, :, 0, 0] == pytest.approx([114 / 255] * 3)
    assert blob[0, :, 8, 0] == pytest.approx([1.0, 0.0, 0.0])  # red first
    assert blob[0, :, 247, 319] == pytest.approx([1.0, 0.0, 0.0])
    assert blob[0, :, 248, 0] == pytest.approx([114 / 255] * 3)


def test_one_cell_says_one_box() -> None:
    heads = empty_heads()
    say(heads, 16, 5, 7, 0.0, 1.0, 2.0, 0.5, 3.0)
    (box,) = decode(heads)
    u, v = 7.5 * 16, 5.5 * 16 - 8
    assert box.score == pytest.approx(0.5)
    assert (box.left, box.top) == pytest.approx((2 * (u - 16), 2 * (v - 32)))
    assert (box.right, box.bottom) == pytest.approx((2 * (u + 8), 2 * (v + 48)))


def test_edges_beyond_the_frame_end_at_its_border() -> None:
    heads = empty_heads()
    say(heads, 32, 7, 9, 3.0, 1.0, 4.0, 2.0, 2.0)
    (box,) = decode(heads)
    assert (box.right, box.bottom) == (640.0, 480.0)


def test_the_better_of_two_boxes_on_one_thing_stays() -> None:
    heads = empty_heads()
    say(heads, 8, 10, 10, 1.0, 2.0, 4.0, 2.0, 4.0)
    say(heads, 8, 10, 11, 2.0, 3.0, 4.0, 1.0, 4.0)
    say(heads, 8, 10, 30, 0.5, 2.0, 4.0, 2.0, 4.0)
    found = decode(heads)
    assert [round(box.score, 3) for box in found] == [round(1 / (1 + math.exp(-x)), 3) for x in (2.0, 0.5)]


def test_numbers_that_are_none_and_boxes_of_no_size_are_left_out() -> None:
    heads = empty_heads()
    say(heads, 8, 3, 3, math.nan, 1.0, 1.0, 1.0, 1.0)
    say(heads, 8, 3, 9, 3.0, math.inf, 1.0, 1.0, 1.0)
    say(heads, 8, 3, 15, 3.0, 0.0, 1.0, 0.05, 1.0)
    assert decode(heads) == []


def test_the_order_of_the_outputs_does_not_matter() -> None:
    heads = empty_heads()
    say(heads, 8, 10, 10, 1.0, 2.0, 4.0, 2.0, 4.0)
    say(heads, 32, 2, 2, 1.0, 2.0, 2.0, 2.0, 2.0)
    assert decode(heads) == decode(heads[::-1])


@given(st.integers(0, 2**32 - 1))
def test_boxes_come_best_first_apart_from_each_other_and_inside_the_frame(seed: int) -> None:
    rng = np.random.default_rng(seed)
    heads = []
    for stride in (8, 16, 32):
        head = rng.uniform(0.0, 4.0, (1, 5, INPUT_HEIGHT // stride, INPUT_WIDTH // stride)).astype(np.float32)
        head[0, 0] = rng.normal(-2.0, 2.0, head.shape[2:])
        heads.append(head)
    found = decode(heads, 0.4)
    assert len(found) <= BOXES_MAX
    scores = [box.score for box in found]
    assert scores == sorted(scores, reverse=True)
    assert all(score >= 0.4 - 1e-6 for score in scores)
    for i, a in enumerate(found):
        assert 0.0 <= a.left < a.right <= 640.0
        assert 0.0 <= a.top < a.bottom <= 480.0
        for b in found[:i]:
            assert overlap(a, b) <= OVERLAP_MAX + 1e-9


def overlap(a: ScoredBox, b: ScoredBox) -> float:
    width = max(min(a.right, b.right) - max(a.left, b.left), 0.0)
    height = max(min(a.bottom, b.bottom) - max(a.top, b.top), 0.0)
    areas = (a.right - a.left) * (a.bottom - a.top) + (b.right - b.left) * (b.bottom - b.top)
    return width * height / (areas - width * height)


@pytest.mark.parametrize("shape", [(1, 6, 32, 40), (1, 5, 33, 40), (1, 5, 32, 32), (5, 32, 40)])
def test_what_is_no_head_is_said_to_be_none(shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match="head"):
        stride_of(np.zeros(shape, np.float32))

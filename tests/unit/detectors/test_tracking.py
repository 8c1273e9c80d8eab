"""Tracking of boxes in the picture."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.detectors.tracking import BoxTracker
from target_nav.utils.distance import Box
from tests.unit.detectors.boxes import CONFIG

PERIOD_S = 0.1
COAST = CONFIG.detector.coast_frames
CONFIRM = CONFIG.detector.confirm_frames


def box(u_px: float, height_px: float = 80.0, v_px: float = 240.0) -> Box:
    return Box(u_px, v_px, height_px * 0.286, height_px)


class Run:
    """Frames at a constant period."""

    def __init__(self) -> None:
        self.tracker = BoxTracker(CONFIG)
        self.now_s = 5.0

    def see(self, *boxes: Box, after_s: float = PERIOD_S) -> list[int]:
        """The ids of the boxes."""
        self.now_s += after_s
        return [track.track_id for track in self.tracker.update(self.now_s, list(boxes))]


@given(st.floats(-550.0, 550.0), st.floats(20.0, 200.0))
def test_an_object_keeps_its_id_while_the_robot_turns_at_full_rate(
    rate_px_per_s: float, height_px: float
) -> None:
    run = Run()
    ids = {run.see(box(1000.0 + rate_px_per_s * k * PERIOD_S, height_px))[0] for k in range(12)}
    assert len(ids) == 1


def test_two_objects_side_by_side_keep_their_ids_in_any_order() -> None:
    run = Run()
    left, right = run.see(box(300.0), box(330.0))
    for k in range(1, 10):
        moved = 4.0 * k
        assert run.see(box(330.0 + moved), box(300.0 + moved)) == [right, left]


def test_the_nearest_pair_is_joined_first() -> None:
    run = Run()
    (first,) = run.see(box(300.0))
    assert run.see(box(304.0), box(301.0))[1] == first


def test_a_box_of_another_size_is_another_object() -> None:
    run = Run()
    (near,) = run.see(box(300.0, 160.0))
    assert run.see(box(300.0, 80.0)) != [near]


def test_a_box_at_another_height_in_the_picture_is_another_object() -> None:
    run = Run()
    (first,) = run.see(box(300.0, v_px=240.0))
    assert run.see(box(300.0, v_px=300.0)) != [first]


@pytest.mark.parametrize(("missed", "same"), [(COAST, True), (COAST + 1, False)])
def test_a_confirmed_object_survives_so_many_frames_unseen(missed: int, same: bool) -> None:
    run = Run()
    for _ in range(CONFIRM):
        (before,) = run.see(box(300.0))
    for _ in range(missed):
        run.see()
    assert (run.see(box(300.0)) == [before]) is same


def test_an_unconfirmed_object_survives_one() -> None:
    run = Run()
    (first,) = run.see(box(300.0))
    run.see()
    assert run.see(box(300.0)) == [first]
    run.see()
    run.see()
    assert run.see(box(300.0)) != [first]


def test_a_coasting_object_moves_on_with_the_picture() -> None:
    run = Run()
    for k in range(6):
        (moving,) = run.see(box(100.0 + 40.0 * k))
    for _ in range(3):
        run.see()
    assert run.see(box(100.0 + 40.0 * 9)) == [moving]


def test_after_a_long_gap_everything_is_new() -> None:
    run = Run()
    for _ in range(CONFIRM):
        (before,) = run.see(box(300.0))
    (after,) = run.see(box(300.0), after_s=CONFIG.loop.camera_max_age_s + 0.01)
    assert after > before
    assert not run.tracker.tracks[0].confirmed


@given(st.lists(st.lists(st.floats(0.0, 640.0), max_size=6), max_size=12))
def test_ids_are_unique_in_a_frame_and_never_come_back(frames: list[list[float]]) -> None:
    run = Run()
    gone: set[int] = set()
    alive: set[int] = set()
    for columns in frames:
        ids = run.see(*(box(u) for u in columns))
        assert len(set(ids)) == len(ids) == len(columns)
        assert not gone & set(ids)
        now = {track.track_id for track in run.tracker.tracks}
        gone |= alive - now
        alive = now

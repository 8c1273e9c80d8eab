"""The past: complete as far as it goes, and bounded whatever comes."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from target_nav.web.timeline import CHUNK, Mark, Timeline


def mark(number: int) -> Mark:
    return Mark(0.1 * number, "IDLE", f"leaf {number}", number % 2 == 0)


def filled(count: int, **limits: int) -> Timeline:
    timeline = Timeline(**limits)
    for number in range(count):
        assert timeline.add(mark(number), f'{{"n":{number}}}') == number
    return timeline


@given(st.integers(0, 5 * CHUNK), st.integers(CHUNK, 3 * CHUNK))
def test_every_frame_that_is_kept_comes_back_as_it_was(count: int, most: int) -> None:
    timeline = filled(count, most_frames=most)
    assert timeline.end == count
    for number in range(timeline.begin, timeline.end):
        assert timeline.frame(number) == f'{{"n":{number}}}'
    assert timeline.frame(timeline.begin - 1) is None
    assert timeline.frame(timeline.end) is None
    assert [row[0] for row in timeline.marks(0)] == list(range(timeline.begin, timeline.end))


@given(st.integers(0, 8 * CHUNK), st.integers(CHUNK, 4 * CHUNK))
def test_it_keeps_what_it_may_and_no_more_than_a_chunk_beyond(count: int, most: int) -> None:
    timeline = filled(count, most_frames=most)
    kept = timeline.end - timeline.begin
    assert kept <= most + CHUNK
    assert kept >= min(count, most - CHUNK + 1)


def test_bytes_are_bounded_by_dropping_the_oldest() -> None:
    import random

    timeline = Timeline(most_bytes=20_000)
    noise = random.Random(1)
    for number in range(40 * CHUNK):
        timeline.add(mark(number), "".join(noise.choices("abcdefgh", k=200)))
    assert timeline.size_bytes <= 20_000
    assert timeline.end == 40 * CHUNK
    assert timeline.begin % CHUNK == 0
    assert timeline.begin > 0
    assert timeline.frame(timeline.begin) is not None


def test_a_picture_goes_with_the_frames_after_it_until_the_next() -> None:
    timeline = Timeline()
    for number in range(6):
        timeline.add(mark(number), "{}", {1: b"one", 4: b"two"}.get(number))
    assert [timeline.picture(n) for n in range(6)] == [None, b"one", b"one", b"one", b"two", b"two"]


def test_pictures_have_a_bound_of_their_own() -> None:
    timeline = Timeline(most_picture_bytes=1000)
    for number in range(100):
        timeline.add(mark(number), "{}", bytes(90))
    assert timeline.picture(0) is None
    assert timeline.picture(99) is not None
    assert sum(timeline.picture(n) is not None for n in range(100)) <= 11


def test_marks_go_on_from_where_a_page_has_them() -> None:
    timeline = filled(30)
    assert timeline.marks(28) == [[28, 2.8, "IDLE", "leaf 28", 1], [29, 2.9, "IDLE", "leaf 29", 0]]
    assert [row[0] for row in timeline.marks(5, most=3)] == [5, 6, 7]
    assert timeline.marks(30) == []

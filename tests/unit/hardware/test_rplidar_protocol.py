"""The RPLidar's bytes: requests, answers, samples, and what is made of damaged ones."""

from __future__ import annotations

import math
import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from target_nav.errors import DeviceError
from target_nav.hardware.rplidar_protocol import (
    HEALTH_DESCRIPTOR,
    INFO_DESCRIPTOR,
    ROW,
    SCAN_DESCRIPTOR,
    HealthStatus,
    Request,
    SampleParser,
    Samples,
    decode_samples,
    parse_health,
    parse_info,
)
from tests.utils.rplidar_device import STEP_DEG, sample_bytes


def turn_bytes(first: int = 0, count: int = 364) -> list[bytes]:
    """Samples of a turning head, as on the wire; a range tells the sample's number."""
    samples = []
    for n in range(first, first + count):
        angle_deg = n * STEP_DEG % 360.0
        samples.append(sample_bytes(angle_deg, 1000.0 + n, starts=angle_deg < STEP_DEG))
    return samples


def numbers(samples: Samples) -> list[int]:
    return [round(range_m * 1000.0) - 1000 if math.isfinite(range_m) else -1 for range_m in samples.range_m]


def test_requests_are_two_bytes() -> None:
    expected = {"STOP": "a525", "RESET": "a540", "SCAN": "a520", "GET_INFO": "a550", "GET_HEALTH": "a552"}
    assert {request.name: request.encode().hex() for request in Request} == expected


def test_descriptors_are_those_of_the_document() -> None:
    assert SCAN_DESCRIPTOR.hex() == "a55a0500004081"
    assert INFO_DESCRIPTOR.hex() == "a55a1400000004"
    assert HEALTH_DESCRIPTOR.hex() == "a55a0300000006"


def test_info_of_an_a1() -> None:
    info = parse_info(bytes((24, 29, 1, 7)) + bytes(range(16)))
    assert (info.model, info.firmware, info.hardware) == (24, "1.29", 7)
    assert info.serial_number == "000102030405060708090A0B0C0D0E0F"


def test_health() -> None:
    health = parse_health(b"\x02\x01\x80")
    assert (health.status, health.code) == (HealthStatus.ERROR, 0x8001)
    with pytest.raises(DeviceError, match="health 7; it must be 0, 1 or 2"):
        parse_health(b"\x07\x00\x00")


def test_a_sample_byte_for_byte() -> None:
    # quality 15, first of a turn; 90 degrees = 5760/64 = 0x1680; 1234.5 mm = 4938/4 = 0x134a
    samples = decode_samples(bytes((0b00111101, 0x01, 0x2D, 0x4A, 0x13)))
    assert samples.angle_rad[0] == pytest.approx(math.pi / 2.0)
    assert samples.range_m[0] == pytest.approx(1.2345)
    assert samples.quality[0] == 15
    assert samples.starts_turn[0]


@pytest.mark.parametrize(("distance_mm", "quality"), [(0.0, 15), (0.0, 0), (1000.0, 0)])
def test_no_distance_or_no_quality_is_no_return(distance_mm: float, quality: int) -> None:
    assert math.isinf(decode_samples(sample_bytes(10.0, distance_mm, quality)).range_m[0])


@settings(deadline=None)
@given(st.floats(0.0, 359.98), st.floats(0.25, 16000.0), st.integers(1, 63), st.booleans())
def test_what_was_encoded_is_read(angle_deg: float, distance_mm: float, quality: int, starts: bool) -> None:
    samples = decode_samples(sample_bytes(angle_deg, distance_mm, quality, starts))
    off_rad = math.remainder(samples.angle_rad[0] - math.radians(angle_deg), 2.0 * math.pi)
    assert abs(off_rad) <= math.radians(0.5 / 64.0) + 1e-12
    assert samples.range_m[0] == pytest.approx(distance_mm / 1000.0, abs=0.000126)
    assert (samples.quality[0], samples.starts_turn[0]) == (quality, starts)


def test_angles_past_a_turn_are_the_same_direction() -> None:
    assert decode_samples(sample_bytes(360.5, 1000.0)).angle_rad[0] == pytest.approx(math.radians(0.5))


@settings(deadline=None)
@given(st.lists(st.integers(1, 200), min_size=1, max_size=40))
def test_it_does_not_matter_how_the_bytes_are_cut(cuts: list[int]) -> None:
    parser, data, found = SampleParser(), b"".join(turn_bytes()), []
    while data:
        for cut in cuts:
            found += numbers(parser.feed(data[:cut]))
            data = data[cut:]
    assert found == list(range(364 - ROW + 1))
    assert parser.held_samples == ROW - 1
    assert (parser.resyncs, parser.skipped_bytes) == (0, 0)


@settings(deadline=None)
@given(st.integers(0, 1900), st.binary(min_size=1, max_size=300))
def test_garbage_in_the_stream_costs_a_few_samples(at: int, garbage: bytes) -> None:
    data = b"".join(turn_bytes(count=400))
    parser = SampleParser()
    found = numbers(parser.feed(data[:at] + garbage + data[at:]))
    # Garbage that is a whole row of samples cannot be told from samples.
    assert len([n for n in found if n not in range(400)]) <= len(garbage) // 5
    missing = [n for n in range(400 - ROW) if n not in found]
    assert len(missing) <= 2 * ROW + 2
    assert parser.skipped_bytes <= len(garbage) + 5 * (2 * ROW + 2)


@settings(deadline=None)
@given(st.integers(0, 1900), st.integers(1, 40))
def test_lost_bytes_cost_a_few_samples_and_invent_none(at: int, lost: int) -> None:
    data = b"".join(turn_bytes(count=400))
    found = numbers(SampleParser().feed(data[:at] + data[at + lost :]))
    assert set(found) <= set(range(400))
    kept = {n for n in range(400 - ROW) if 5 * n + 5 <= at or 5 * n >= at + lost}
    assert len(kept - set(found)) <= 2 * ROW


def test_a_million_random_bytes_give_next_to_nothing_and_hold_no_memory() -> None:
    parser = SampleParser()
    noise = random.Random(6)
    taken = sum(len(parser.feed(noise.randbytes(50_000))) for _ in range(20))
    # A row of eight by chance: 0.18 * (0.18 * 41/360)^7 of all places is one in ten to the thirteenth.
    assert taken == 0
    assert parser.held_samples < 2 * ROW
    assert numbers(parser.feed(b"".join(turn_bytes())))[-300:] == list(range(57, 357))


def test_the_zero_crossing_is_no_jump() -> None:
    parser = SampleParser()
    angles = [(355.9 + n) % 360.0 for n in range(2 * ROW)]
    assert len(parser.feed(b"".join(sample_bytes(angle, 500.0) for angle in angles))) == ROW + 1
    assert parser.resyncs == 0


def test_a_banner_between_the_samples_is_skipped() -> None:
    parser = SampleParser()
    data = [*turn_bytes(count=50), b"RP LIDAR System.\r\nFirmware Ver 1.29\r\n", *turn_bytes(50, 50)]
    found = numbers(parser.feed(b"".join(data)))
    assert found[:40] == list(range(40))
    assert found[-40:] == list(range(53, 93))
    assert parser.resyncs == 1

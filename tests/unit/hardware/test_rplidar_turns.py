"""From samples to scans: bins, frame, times, and turns that are none."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from target_nav.config import LidarConfig
from target_nav.hardware.rplidar_protocol import Samples
from target_nav.hardware.rplidar_turns import SAMPLE_PERIOD_S, TurnAssembler
from target_nav.nav.poses import PoseHistory
from target_nav.nav.scan_points import deskewed_points_in_odom
from target_nav.state.types import Odometry, Pose2D, Scan, Twist2D

CONFIG = LidarConfig()
PERIOD_S = 0.182
PER_TURN = round(PERIOD_S / SAMPLE_PERIOD_S)


def samples_of(angles_deg: np.ndarray, range_m: float | np.ndarray = 2.0) -> Samples:
    """Samples at unwrapped clockwise angles; a turn starts where they pass zero."""
    turns = np.floor(angles_deg / 360.0)
    return Samples(
        np.radians(angles_deg % 360.0),
        np.broadcast_to(np.asarray(range_m, dtype=float), angles_deg.shape).copy(),
        np.full(len(angles_deg), 15, dtype=np.uint8),
        np.diff(turns, prepend=turns[0]) > 0,
    )


def turning(begin_deg: float, end_deg: float, step_deg: float = 360.0 / PER_TURN) -> np.ndarray:
    return np.arange(begin_deg, end_deg, step_deg)


def scans_of(angles_deg: np.ndarray, range_m: float | np.ndarray = 2.0, end_s: float = 100.0) -> list[Scan]:
    return TurnAssembler(CONFIG).add(samples_of(angles_deg, range_m), end_s)


def test_only_whole_turns_are_scans() -> None:
    assert len(scans_of(turning(100.0, 360.0 * 4 + 90.0))) == 3
    assert scans_of(turning(100.0, 700.0)) == []


def test_a_turn_has_the_geometry_of_its_bins() -> None:
    (scan,) = scans_of(turning(300.0, 725.0))
    assert len(scan.ranges_m) == 360
    # Bins begin at the sensor's zero, beams are their middles.
    assert scan.angle_min_rad == pytest.approx(math.radians(179.5))
    assert scan.angle_increment_rad == pytest.approx(-math.radians(1.0))
    assert scan.time_increment_s * 360 == pytest.approx(PERIOD_S, rel=0.01)
    assert (scan.range_min_m, scan.range_max_m) == (CONFIG.range_min_m, CONFIG.range_max_m)
    assert np.all(scan.ranges_m == 2.0)


@pytest.mark.parametrize(
    ("clockwise_deg", "bearing_deg"), [(0.0, 180.0), (90.0, 90.0), (180.0, 0.0), (270.0, -90.0)]
)
def test_clockwise_from_behind_is_counter_clockwise_from_ahead(
    clockwise_deg: float, bearing_deg: float
) -> None:
    angles = turning(300.0, 1085.0)
    off = np.abs((angles - clockwise_deg + 180.0) % 360.0 - 180.0)
    scan = scans_of(angles, np.where(off < 1.5, 1.0, 3.0))[0]
    near = np.flatnonzero(scan.ranges_m < 2.0)
    bearings = scan.angle_min_rad + near * scan.angle_increment_rad
    bearing = math.atan2(np.sin(bearings).mean(), np.cos(bearings).mean())
    assert math.remainder(bearing - math.radians(bearing_deg), 2.0 * math.pi) == pytest.approx(0.0, abs=0.01)


def test_beams_are_stamped_with_the_time_they_were_taken() -> None:
    angles = turning(300.0, 1085.0)
    scan = scans_of(angles, end_s=50.0)[0]
    for beam in (0, 90, 200, 359):
        taken = np.argmin(np.abs(angles - (360.5 + beam)))
        taken_s = 50.0 - (len(angles) - 1 - taken) * SAMPLE_PERIOD_S
        assert scan.stamp_s + beam * scan.time_increment_s == pytest.approx(taken_s, abs=2 * SAMPLE_PERIOD_S)


def test_the_nearest_of_a_bin_counts_and_an_empty_bin_is_a_drop_out() -> None:
    angles = np.concatenate([turning(300.0, 449.9), turning(451.1, 725.0, 0.5)])
    ranges = np.where((angles >= 500.0) & (angles < 500.5), 1.0, 3.0)
    scan = scans_of(angles, ranges)[0]
    assert scan.ranges_m[140] == 1.0
    assert math.isinf(scan.ranges_m[90])
    assert np.all(np.delete(scan.ranges_m, [90, 140]) == 3.0)


@settings(deadline=None)
@given(st.floats(0.0, 20.0))
def test_ranges_are_within_the_limits_or_drop_outs(range_m: float) -> None:
    scan = scans_of(turning(300.0, 725.0), range_m)[0]
    believed = CONFIG.range_min_m <= range_m <= CONFIG.range_max_m
    assert np.all(scan.ranges_m == (range_m if believed else math.inf))


@settings(deadline=None)
@given(st.lists(st.integers(1, 400), min_size=1, max_size=10), st.floats(1.5, 10.0))
def test_batches_do_not_matter(cuts: list[int], rate_hz: float) -> None:
    angles = turning(200.0, 2000.0, 360.0 * SAMPLE_PERIOD_S * rate_hz)
    ranges = 1.0 + angles / 1000.0
    whole = scans_of(angles, ranges)
    assembler, pieces, begin = TurnAssembler(CONFIG), [], 0
    samples = samples_of(angles, ranges)
    while begin < len(angles):
        for cut in cuts:
            end = min(begin + cut, len(angles))
            part = Samples(
                *(getattr(samples, f)[begin:end] for f in ("angle_rad", "range_m", "quality", "starts_turn"))
            )
            pieces += assembler.add(part, 100.0 - (len(angles) - end) * SAMPLE_PERIOD_S)
            begin = end
    assert len(pieces) == len(whole) == 4
    for piece, scan in zip(pieces, whole):
        assert np.array_equal(piece.ranges_m, scan.ranges_m)
        assert piece.stamp_s == pytest.approx(scan.stamp_s, abs=1e-9)


def test_a_turn_that_was_not_seen_is_dropped() -> None:
    assembler = TurnAssembler(CONFIG)
    angles = np.concatenate([turning(300.0, 460.0), turning(520.0, 1085.0)])
    assert len(assembler.add(samples_of(angles), 100.0)) == 1
    assert assembler.dropped_turns == 1


def test_two_turns_run_together_by_a_lost_beginning_are_no_scan() -> None:
    angles = turning(300.0, 1500.0)
    samples = samples_of(angles)
    samples.starts_turn[np.argmax(angles >= 720.0)] = False
    assembler = TurnAssembler(CONFIG)
    scans = assembler.add(samples, 100.0)
    assert len(scans) == 1
    assert assembler.dropped_turns == 1


def test_a_head_that_stands_gives_no_scan_and_does_not_pile_up() -> None:
    assembler = TurnAssembler(CONFIG)
    assembler.add(samples_of(turning(300.0, 400.0)), 100.0)
    for second in range(20):
        assert assembler.add(samples_of(np.full(2000, 40.0)), 101.0 + second) == []
    assert sum(map(len, assembler._samples)) <= 2 * 2000


def test_after_a_reset_the_turn_begun_is_forgotten() -> None:
    assembler = TurnAssembler(CONFIG)
    assembler.add(samples_of(turning(300.0, 500.0)), 100.0)
    assembler.reset()
    assert assembler.add(samples_of(turning(500.0, 725.0)), 200.0) == []


def test_other_bins_can_be_asked_for() -> None:
    assembler = TurnAssembler(LidarConfig(beams=180))
    (scan,) = assembler.add(samples_of(turning(300.0, 725.0)), 100.0)
    assert len(scan.ranges_m) == 180
    assert np.all(scan.ranges_m == 2.0)


@pytest.mark.parametrize("yaw_rate_radps", [-0.5, 0.0, 0.5])
def test_a_wall_seen_while_turning_is_straight_again_after_deskewing(yaw_rate_radps: float) -> None:
    """Beams carry their own times in the right order: put in odom one by one, they meet the wall."""
    angles = turning(300.0, 725.0)
    end_s = 100.0
    times_s = end_s - SAMPLE_PERIOD_S * np.arange(len(angles) - 1, -1, -1.0)
    bearings = math.pi - np.radians(angles) + yaw_rate_radps * (times_s - 99.0)
    ranges = np.where(np.cos(bearings) > 0.7, 2.0 / np.maximum(np.cos(bearings), 0.7), 20.0)
    scan = scans_of(angles, ranges, end_s)[0]
    poses = PoseHistory()
    for t_s in np.arange(99.0, 100.1, 0.05):
        pose = Pose2D(0.0, 0.0, yaw_rate_radps * (t_s - 99.0))
        poses.add(Odometry(float(t_s), pose, Twist2D(0.0, 0.0, yaw_rate_radps)))
    points = deskewed_points_in_odom(scan, poses, LidarConfig())
    assert points is not None
    # Half a bin at 45 degrees is 17 mm.
    assert len(points.points_in_odom_m) > 80
    assert np.abs(points.points_in_odom_m[:, 0] - 2.0).max() < 0.025

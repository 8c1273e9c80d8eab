"""The limiter: what must never be sent, and what must never be held back."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from target_nav.config import Config
from target_nav.nav.footprint import Footprint
from target_nav.nav.limiter import Limited, VelocityLimiter
from target_nav.state.types import STOP, FloatArray, MotionRequest, NavState, Twist2D
from tests.unit.nav.views import NO_POINTS, assert_mirrored, points, wall

CONFIG = Config()
ROBOT, AVOID = CONFIG.robot, CONFIG.avoid
BODY = Footprint.of(ROBOT)
DT = 0.05
FORWARD = Twist2D(0.3, 0.0, 0.0)

anything = st.floats(allow_nan=True, allow_infinity=True)
twists = st.builds(Twist2D, st.floats(-0.6, 0.6), st.floats(-0.6, 0.6), st.floats(-2.0, 2.0))
clouds = st.lists(st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0)), max_size=20)


def ask(twist: Twist2D, near_target: bool = False) -> MotionRequest:
    return MotionRequest("test", NavState.NAVIGATING, twist, near_target=near_target)


def limit(
    limiter: VelocityLimiter,
    request: MotionRequest | None,
    obstacles: FloatArray = NO_POINTS,
    *,
    dt_s: float = DT,
    scan_age_s: float = 0.1,
    odom_age_s: float = 0.05,
    camera_age_s: float = 0.1,
    target: tuple[float, float] | None = None,
    measured: Twist2D = STOP,
) -> Limited:
    return limiter.limit(
        request,
        dt_s=dt_s,
        scan_age_s=scan_age_s,
        odom_age_s=odom_age_s,
        camera_age_s=camera_age_s,
        obstacles_in_base_m=obstacles,
        target_in_base=target,
        measured=measured,
    )


def cruise(limiter: VelocityLimiter, twist: Twist2D, ticks: int = 40) -> Limited:
    """Get up to a speed on a free floor."""
    limited = Limited(STOP)
    for _ in range(ticks):
        limited = limit(limiter, ask(twist))
    return limited


def test_a_reasonable_request_on_a_free_floor_passes_unchanged() -> None:
    limiter = VelocityLimiter(CONFIG)
    wanted = Twist2D(0.2, -0.1, 0.4)
    assert cruise(limiter, wanted) == Limited(wanted, "")


@pytest.mark.parametrize(
    ("scan_age_s", "odom_age_s", "dt_s", "measured_x", "rule"),
    [
        (0.9, 0.05, DT, 0.0, "stale scan"),
        (math.inf, 0.05, DT, 0.0, "stale scan"),
        (math.nan, 0.05, DT, 0.0, "stale scan"),
        (0.1, 0.4, DT, 0.0, "stale odometry"),
        (0.1, math.nan, DT, 0.0, "stale odometry"),
        (0.1, 0.05, DT, math.nan, "odometry not finite"),
        (0.1, 0.05, math.nan, 0.0, "clock not finite"),
    ],
)
def test_an_input_that_cannot_be_trusted_sends_zero_at_once(
    scan_age_s: float, odom_age_s: float, dt_s: float, measured_x: float, rule: str
) -> None:
    limiter = VelocityLimiter(CONFIG)
    cruise(limiter, FORWARD)
    measured = Twist2D(measured_x, 0.0, 0.0)
    limited = limit(
        limiter, ask(FORWARD), scan_age_s=scan_age_s, odom_age_s=odom_age_s, dt_s=dt_s, measured=measured
    )
    assert limited == Limited(STOP, rule)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_request_or_an_obstacle_that_is_not_finite_sends_zero_at_once(bad: float) -> None:
    limiter = VelocityLimiter(CONFIG)
    cruise(limiter, FORWARD)
    assert limit(limiter, ask(Twist2D(0.1, bad, 0.0))) == Limited(STOP, "request not finite")
    cruise(limiter, FORWARD)
    assert limit(limiter, ask(FORWARD), points((bad, 0.0))) == Limited(STOP, "obstacles not finite")


def test_a_stale_camera_limits_nothing_here() -> None:
    limiter = VelocityLimiter(CONFIG)
    cruise(limiter, FORWARD)
    assert limit(limiter, ask(FORWARD), camera_age_s=99.0).twist == FORWARD


def test_without_a_request_it_brakes_to_zero_within_the_limit() -> None:
    limiter = VelocityLimiter(CONFIG)
    cruise(limiter, FORWARD)
    speeds = []
    for _ in range(10):
        limited = limit(limiter, None)
        speeds.append(limited.twist.vx_mps)
    assert speeds[:3] == pytest.approx([0.24, 0.18, 0.12])
    assert speeds[-1] == 0.0
    assert limit(limiter, None) == Limited(STOP, "")


@settings(max_examples=60)
@given(
    st.lists(
        st.tuples(
            st.builds(Twist2D, anything, anything, anything),
            clouds,
            st.one_of(st.none(), st.just((0.5, 0.1))),
        ),
        min_size=1,
        max_size=6,
    ),
    st.sampled_from(["mecanum", "differential"]),
    anything,
)
def test_whatever_comes_in_nothing_leaves_the_limits(
    ticks: list[tuple[Twist2D, list[tuple[float, float]], tuple[float, float] | None]], drive: str, dt: float
) -> None:
    config = CONFIG.override({"robot.drive": drive})
    limiter = VelocityLimiter(config)
    for twist, cloud, target in ticks:
        sent = limit(limiter, ask(twist), points(*cloud), target=target, dt_s=dt).twist
        assert sent.is_finite()
        assert abs(sent.vx_mps) <= ROBOT.max_speed_mps + 1e-9
        assert abs(sent.vy_mps) <= ROBOT.max_lateral_speed_mps + 1e-9
        assert abs(sent.wz_radps) <= ROBOT.max_yaw_rate_radps + 1e-9
        assert drive == "mecanum" or sent.vy_mps == 0.0


@settings(max_examples=80)
@given(st.lists(st.tuples(st.one_of(st.none(), twists), clouds), min_size=2, max_size=10))
def test_what_is_sent_changes_within_the_limits_of_acceleration_or_is_zero(
    ticks: list[tuple[Twist2D | None, list[tuple[float, float]]]],
) -> None:
    limiter = VelocityLimiter(CONFIG)
    last = STOP
    for twist, cloud in ticks:
        sent = limit(limiter, None if twist is None else ask(twist), points(*cloud)).twist
        if sent != STOP:
            change = math.hypot(sent.vx_mps - last.vx_mps, sent.vy_mps - last.vy_mps)
            assert change <= ROBOT.max_decel_mps2 * DT + 1e-9
            assert sent.speed_mps - last.speed_mps <= ROBOT.max_accel_mps2 * DT + 1e-9
            assert abs(sent.wz_radps - last.wz_radps) <= ROBOT.max_yaw_accel_radps2 * DT + 1e-9
        last = sent


@settings(max_examples=60)
@given(twists, clouds)
def test_a_mirrored_world_gets_a_mirrored_velocity(twist: Twist2D, cloud: list[tuple[float, float]]) -> None:
    obstacles = points(*cloud)
    one, other = VelocityLimiter(CONFIG), VelocityLimiter(CONFIG)
    flipped = Twist2D(twist.vx_mps, -twist.vy_mps, -twist.wz_radps)
    for _ in range(5):
        left = limit(one, ask(twist), obstacles)
        right = limit(other, ask(flipped), obstacles * [1.0, -1.0])
        assert_mirrored(left.twist, right.twist)
        assert left.limited_by == right.limited_by


def drive_at(obstacles: FloatArray, twist: Twist2D, ticks: int = 200) -> tuple[float, list[Limited]]:
    """Keep asking for a twist while a robot with a lag of 80 ms obeys; the least clearance on the way."""
    limiter = VelocityLimiter(CONFIG)
    x = y = yaw = 0.0
    real = STOP
    least, sent = math.inf, []
    for _ in range(ticks):
        c, s = math.cos(yaw), math.sin(yaw)
        seen = (obstacles - [x, y]) @ np.array([[c, -s], [s, c]])
        least = min(least, float(BODY.clearances_m(seen).min()))
        sent.append(limit(limiter, ask(twist), seen, measured=real))
        part = 1.0 - math.exp(-DT / 0.08)
        goal = sent[-1].twist
        real = Twist2D(
            real.vx_mps + part * (goal.vx_mps - real.vx_mps),
            real.vy_mps + part * (goal.vy_mps - real.vy_mps),
            real.wz_radps + part * (goal.wz_radps - real.wz_radps),
        )
        x += (c * real.vx_mps - s * real.vy_mps) * DT
        y += (s * real.vx_mps + c * real.vy_mps) * DT
        yaw += real.wz_radps * DT
    return least, sent


@pytest.mark.parametrize(
    "twist",
    [
        Twist2D(0.3, 0.0, 0.0),
        Twist2D(0.2, 0.2, 0.0),
        Twist2D(-0.3, 0.0, 0.0),
        Twist2D(0.0, -0.25, 0.0),
        Twist2D(0.2, 0.0, 0.8),
        Twist2D(0.1, -0.1, -0.3),
    ],
)
def test_driving_at_walls_all_round_stops_before_them(twist: Twist2D) -> None:
    room = np.vstack(
        [
            wall(0.6, -0.6, 0.6, 0.6),
            wall(-0.6, -0.6, -0.6, 0.6),
            wall(-0.6, 0.6, 0.6, 0.6),
            wall(-0.6, -0.6, 0.6, -0.6),
        ]
    )
    least, sent = drive_at(room, twist)
    assert 0.01 < least < 0.12, "it comes near, and stops before it touches"
    assert any(limited.limited_by == "clearance" for limited in sent)


def test_the_last_way_to_a_wall_is_not_driven_under_the_dead_band() -> None:
    _, sent = drive_at(wall(0.6, -0.6, 0.6, 0.6), FORWARD)
    assert sent[-1].twist == STOP
    slow = [limited.twist.vx_mps for limited in sent[10:] if 0.0 < limited.twist.vx_mps < ROBOT.min_speed_mps]
    assert slow == []


@settings(max_examples=60)
@given(st.floats(-math.pi, math.pi), st.floats(0.001, 0.028))
def test_away_from_an_obstacle_the_robot_is_never_held(bearing: float, gap: float) -> None:
    """However near the obstacle is, within the stop clearance too."""
    c, s = math.cos(bearing), math.sin(bearing)
    reach = min(
        (0.15 / abs(c)) if abs(c) > 1e-9 else math.inf,
        (0.14 / abs(s)) if abs(s) > 1e-9 else math.inf,
    )
    near = points(((reach + gap) * c, (reach + gap) * s))
    side = np.argmin([abs(0.15 - abs(near[0, 0])), abs(0.14 - abs(near[0, 1]))])
    away = (
        Twist2D(-math.copysign(0.1, c), 0.0, 0.0) if side == 0 else Twist2D(0.0, -math.copysign(0.1, s), 0.0)
    )
    limiter = VelocityLimiter(CONFIG)
    for _ in range(6):
        limited = limit(limiter, ask(away), near)
    assert limited.twist == away


def test_along_a_wall_within_the_stop_clearance_it_may_drive_but_not_towards_it() -> None:
    beside = wall(-1.0, 0.16, 1.0, 0.16)
    limiter = VelocityLimiter(CONFIG)
    for _ in range(12):
        along = limit(limiter, ask(Twist2D(0.2, 0.0, 0.0)), beside)
    assert along.twist == Twist2D(0.2, 0.0, 0.0)
    limiter.reset()
    for _ in range(12):
        towards = limit(limiter, ask(Twist2D(0.0, 0.1, 0.0)), beside)
    assert towards == Limited(STOP, "clearance")


@pytest.mark.parametrize("slope_rad", [0.01, 0.03, 0.1, 0.5])
def test_a_wall_is_not_grazed_however_shallow_the_angle(slope_rad: float) -> None:
    c, s = math.cos(slope_rad), math.sin(slope_rad)
    slanted = wall(-1.0, 0.0, 3.0, 0.0, 0.02) @ np.array([[c, -s], [s, c]]) + [0.0, 0.2 + 0.2 * slope_rad]
    least, _ = drive_at(slanted, Twist2D(0.2, 0.0, 0.0), ticks=400)
    assert least > 0.01


def test_a_corner_does_not_sweep_into_what_is_beside_the_body() -> None:
    beside = wall(-1.0, 0.18, 1.0, 0.18)
    least, _ = drive_at(beside, Twist2D(0.0, 0.0, 0.8))
    assert least > 0.01


def test_the_target_is_kept_off_unless_the_request_is_meant_to_go_near_it() -> None:
    there = (0.25, 0.0)
    limiter = VelocityLimiter(CONFIG)
    slow = Twist2D(0.1, 0.0, 0.0)
    for _ in range(6):
        kept_off = limit(limiter, ask(slow), target=there)
    assert kept_off.twist.vx_mps < 0.1
    limiter.reset()
    for _ in range(6):
        near = limit(limiter, ask(slow, near_target=True), target=there)
    assert near.twist == slow


def test_near_the_target_other_things_still_count() -> None:
    limiter = VelocityLimiter(CONFIG)
    for _ in range(6):
        held = limit(
            limiter, ask(Twist2D(0.1, 0.0, 0.0), near_target=True), points((0.17, 0.1)), target=(0.25, 0.0)
        )
    assert held == Limited(STOP, "clearance")


def test_an_obstacle_that_appears_right_in_front_stops_it_at_once() -> None:
    limiter = VelocityLimiter(CONFIG)
    cruise(limiter, FORWARD)
    assert limit(limiter, ask(FORWARD), points((0.17, 0.0)), measured=FORWARD) == Limited(STOP, "clearance")


def test_a_late_tick_does_not_jump() -> None:
    limiter = VelocityLimiter(CONFIG)
    assert limit(limiter, ask(FORWARD), dt_s=5.0).twist.vx_mps <= ROBOT.max_accel_mps2 * 0.2 + 1e-9


def test_reset_begins_from_standstill() -> None:
    limiter = VelocityLimiter(CONFIG)
    cruise(limiter, FORWARD)
    limiter.reset()
    assert limit(limiter, ask(FORWARD)).twist.vx_mps == pytest.approx(ROBOT.max_accel_mps2 * DT)


@settings(max_examples=60)
@given(twists, st.integers(0, 12), st.floats(0.0, 0.4), st.floats(-0.1, 0.1))
def test_a_stop_for_safety_is_as_short_as_without_a_limit_of_jerk(
    twist: Twist2D, ticks: int, ahead: float, aside: float
) -> None:
    """Stopping because nobody asks, standstill is asked for or something is near: no tick of it is made faster."""
    smooth, harsh = (
        VelocityLimiter(CONFIG.override({"robot.max_jerk_mps3": jerk, "robot.max_yaw_jerk_radps3": yaw}))
        for jerk, yaw in ((0.5, 1.0), (1000.0, 5000.0))
    )
    for _ in range(ticks + 60):
        limit(smooth, ask(twist)), limit(harsh, ask(twist))
    near = points((0.16 + ahead, aside))
    for obstacles, request in ((near, ask(twist)), (NO_POINTS, None), (NO_POINTS, ask(STOP))):
        for _ in range(6):
            one = limit(smooth, request, obstacles).twist
            other = limit(harsh, request, obstacles).twist
            assert one.speed_mps <= other.speed_mps + 1e-6
            assert abs(one.wz_radps) <= abs(other.wz_radps) + 1e-6

"""The drivetrain does to a command what was measured on real ones."""

import math
from dataclasses import replace

import numpy as np
import pytest

from target_nav.config import Config, DriveSimConfig
from target_nav.sim.arena import Arena, Bounds, PlacedObject
from target_nav.sim.contact import ContactMonitor
from target_nav.sim.drive import MAX_PWM, Drive
from target_nav.sim.wheels import TICK_M, Base, top_wheel_speed_mps
from target_nav.sim.world import World
from target_nav.state.types import Pose2D

STEP_S = 0.01
CONFIG = Config()
BASE = Base.of(CONFIG.robot)
TOP_MPS = top_wheel_speed_mps(CONFIG.robot)
HONEST = DriveSimConfig()
PERFECT = DriveSimConfig(
    forward_scale_error=0.0, lateral_over_report=0.0, heading_drift_rad_per_m=0.0, slip_rate_per_m=0.0
)
HALL = Arena("hall", Bounds(-500, -500, 500, 500), Pose2D())


def drive_in(
    arena: Arena, sim: DriveSimConfig, seed: int = 1, start: Pose2D | None = None
) -> tuple[Drive, ContactMonitor]:
    start = start or arena.robot
    contact = ContactMonitor(World(arena), start.x_m, start.y_m, start.yaw_rad)
    return Drive(CONFIG.robot, sim, start, contact, np.random.default_rng(seed), STEP_S), contact


def pwm(vx: float, vy: float = 0.0, wz: float = 0.0) -> tuple[int, int, int, int]:
    a, b, c, d = (round(speed / TOP_MPS * MAX_PWM) for speed in BASE.wheel_speeds(vx, vy, wz))
    return (a, b, c, d)


def run(drive: Drive, command: tuple[int, int, int, int], seconds: float) -> None:
    for _ in range(round(seconds / STEP_S)):
        drive.step(command)


def reported(drive: Drive) -> tuple[float, float, float]:
    """What the encoders add up to, in m and rad; right for motion along one axis."""
    return BASE.body_speeds(tuple(tick * TICK_M for tick in drive.ticks))


def test_without_errors_the_base_goes_where_its_wheels_say():
    drive, _ = drive_in(HALL, PERFECT)
    run(drive, pwm(0.2), 20.0)
    forward, left, turned = reported(drive)
    # Motors differ, so the way is not straight; its length is that of the wheels.
    assert drive.path_m == pytest.approx(math.hypot(forward, left), rel=1e-3)
    assert drive.yaw_rad == pytest.approx(turned, abs=1e-3)


def test_forward_scale_is_off_by_up_to_its_limit_either_way():
    errors = []
    for seed in range(60):
        drive, _ = drive_in(HALL, replace(PERFECT, forward_scale_error=0.02), seed)
        run(drive, pwm(0.3), 3.0)
        forward, left, _ = reported(drive)
        errors.append(drive.path_m / math.hypot(forward, left) - 1.0)
    assert max(np.abs(errors)) <= 0.0205
    assert min(errors) < -0.01
    assert max(errors) > 0.01


def test_strafing_is_over_reported_by_5_to_10_per_cent():
    over = []
    for seed in range(60):
        drive, _ = drive_in(HALL, replace(PERFECT, lateral_over_report=0.08), seed)
        run(drive, pwm(0.0, 0.2), 4.0)
        over.append(abs(reported(drive)[1]) / drive.path_m - 1.0)
    assert min(over) >= 0.045
    assert max(over) <= 0.105
    assert max(over) - min(over) > 0.02


def test_heading_drifts_by_0_3_to_0_6_degrees_a_metre_to_either_side():
    drifts = []
    for seed in range(60):
        drive, _ = drive_in(HALL, replace(PERFECT, heading_drift_rad_per_m=0.008), seed)
        run(drive, pwm(0.3), 10.0)
        drifts.append(math.degrees(drive.yaw_rad - reported(drive)[2]) / drive.path_m)
    assert min(np.abs(drifts)) >= 0.28
    assert max(np.abs(drifts)) <= 0.62
    assert min(drifts) < 0.0 < max(drifts)


def test_slips_come_by_the_metre_and_turn_the_base_smoothly():
    drive, _ = drive_in(HALL, replace(PERFECT, slip_rate_per_m=0.5, slip_heading_rad=0.02))
    command = pwm(0.3)
    lost, before, rates = [], 0.0, []
    for _ in range(60_000):
        drive.step(command)
        now = drive.yaw_rad - reported(drive)[2]
        rates.append(abs(drive.wz_radps))
        if drive._slip_steps == 0 and abs(now - before) > 2e-3:
            lost.append(now - before)
            before = now
    slips_a_metre = len(lost) / drive.path_m
    assert 0.3 <= slips_a_metre <= 0.55  # the smallest slips are not told from encoder steps
    assert np.std(lost) == pytest.approx(0.02, rel=0.25)
    assert max(rates) < 0.6


def test_wheels_follow_with_a_first_order_lag():
    drive, _ = drive_in(HALL, replace(PERFECT, lag_s=0.08))
    run(drive, pwm(0.2), 0.08)
    after_one_lag = drive._speeds[0]
    run(drive, pwm(0.2), 2.0)
    assert after_one_lag / drive._speeds[0] == pytest.approx(1.0 - math.exp(-1.0), abs=0.01)


def test_the_lag_s_way_is_exact_at_any_step():
    """Way while speeding up for a time T: v (T - lag (1 - exp(-T / lag)))."""
    drive, _ = drive_in(HALL, replace(PERFECT, lag_s=0.2))
    run(drive, pwm(0.2), 0.5)
    speed = 0.2 / TOP_MPS * MAX_PWM
    speed = round(speed) * drive._mps_per_pwm[0]
    assert drive._travels[0] == pytest.approx(speed * (0.5 - 0.2 * (1 - math.exp(-0.5 / 0.2))), rel=1e-9)


def test_under_its_dead_band_a_motor_stands():
    drive, _ = drive_in(HALL, replace(PERFECT, deadband_mps=0.02))
    run(drive, pwm(0.018), 2.0)
    assert drive.pose == HALL.robot
    assert drive.ticks == (0, 0, 0, 0)
    run(drive, pwm(0.025), 2.0)
    assert drive.path_m > 0.03


def test_the_base_stands_still_some_time_after_the_motors_stop():
    drive, _ = drive_in(HALL, HONEST)
    run(drive, pwm(0.3), 2.0)
    run(drive, (0, 0, 0, 0), 2.0)
    assert (drive.vx_mps, drive.vy_mps, drive.wz_radps) == (0.0, 0.0, 0.0)


def test_arcs_are_exact_whatever_the_step():
    """Forward, sideways and turning at once: a hundred small steps and one large one end in the same place."""
    ends = []
    for step_s in (0.01, 1.0):
        contact = ContactMonitor(World(HALL), 0.0, 0.0, 0.0)
        sim = replace(PERFECT, lag_s=0.0)
        drive = Drive(CONFIG.robot, sim, Pose2D(0.0, 0.0, 0.4), contact, np.random.default_rng(1), step_s)
        for _ in range(round(1.0 / step_s)):
            drive.step(pwm(0.2, 0.1, 1.0))
        ends.append((drive.x_m, drive.y_m, drive.yaw_rad))
    assert ends[0] == pytest.approx(ends[1], abs=1e-9)
    forward, left, turned = reported(drive)
    assert turned == pytest.approx(1.0, rel=0.1)
    # On an arc the base ends to the left of where it looked at first, by what the wheels' speeds say.
    radius = complex(forward, left) / turned
    end = (
        radius
        * (complex(math.cos(turned), math.sin(turned)) - 1.0)
        / 1j
        * complex(math.cos(0.4), math.sin(0.4))
    )
    assert (ends[1][0], ends[1][1]) == pytest.approx((end.real, end.imag), abs=1e-3)


def test_a_wall_stops_the_base_but_not_its_wheels():
    room = Arena("room", Bounds(-1, -1, 1, 1), Pose2D())
    drive, contact = drive_in(room, PERFECT)
    run(drive, pwm(0.3), 6.0)
    # The front edge is 0.15 m ahead of base_link; the last free step ends at most one step's way before the wall.
    assert 0.845 <= max(abs(drive.x_m), abs(drive.y_m)) <= 0.85
    assert contact.collided
    assert contact.min_clearance_m == 0.0
    assert drive.vx_mps == 0.0
    assert drive.ticks[0] * TICK_M > 1.2


def test_the_base_gets_free_again_backwards_and_collided_stays():
    room = Arena("room", Bounds(-1, -1, 1, 1), Pose2D())
    drive, contact = drive_in(room, PERFECT)
    run(drive, pwm(0.3), 6.0)
    run(drive, pwm(-0.3), 1.0)
    assert drive.x_m < 0.7
    assert contact.collided


def test_the_pin_blocks_and_counts_as_touched():
    arena = Arena("pin", Bounds(-3, -3, 3, 3), Pose2D(), target=PlacedObject("bowling_pin", 0.6, 0.0))
    drive, contact = drive_in(arena, PERFECT)
    run(drive, pwm(0.3), 4.0)
    assert contact.collided
    assert drive.x_m <= 0.6 - 0.15 - 0.04


def test_least_clearance_is_that_of_the_path_driven():
    arena = Arena(
        "pin", Bounds(-3, -3, 3, 3), Pose2D(-1.0, 0.3), target=PlacedObject("bowling_pin", 0.0, 0.0)
    )
    drive, contact = drive_in(arena, PERFECT)
    world, least = World(arena), math.inf
    for _ in range(600):
        drive.step(pwm(0.3))
        least = min(least, world.clearance_m(drive.x_m, drive.y_m, drive.yaw_rad))
    assert contact.min_clearance_m == pytest.approx(least, abs=1e-12)
    assert not contact.collided

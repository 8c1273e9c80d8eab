"""Driving towards spots: facing what it looks at, turned where it must be, at speeds that fit the room."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from target_nav.config import Config
from target_nav.nav.drive import Drive, Driver
from target_nav.nav.footprint import Footprint
from target_nav.nav.limiter import VelocityLimiter
from target_nav.state.types import STOP, FloatArray, MotionRequest, NavState, Pose2D, Twist2D
from target_nav.utils.frames import compose, points_to_child
from tests.unit.nav.views import NO_POINTS, ORIGIN, view, wall

CONFIG = Config()
DIFFERENTIAL = CONFIG.override({"robot.drive": "differential"})
LONG = CONFIG.override({"robot.front_m": 0.25, "robot.rear_m": 0.25, "robot.half_width_m": 0.12})
DT = 0.05


def spots(*xy: tuple[float, float]) -> FloatArray:
    return np.array([(x, y, 0.0) for x, y in xy])


def follow(
    config: Config,
    obstacles: FloatArray,
    goal: tuple[float, float],
    *,
    face: tuple[float, float] | None = None,
    seconds: float = 40.0,
    speed_mps: float = 0.2,
    start: Pose2D = ORIGIN,
    limiter: VelocityLimiter | None = None,
) -> tuple[list[Pose2D], float, Drive]:
    """An ideal robot that does what it is told, or what `limiter` lets through: poses, least clearance, last step."""
    driver, body = Driver(config), Footprint.of(config.robot)
    pose, twist = start, STOP
    poses, least = [pose], math.inf
    for tick in range(round(seconds / DT)):
        near = points_to_child(pose, obstacles)
        if len(near):
            least = min(least, float(body.clearances_m(near).min()))
        bearing = None
        if face is not None:
            bearing = math.remainder(
                math.atan2(face[1] - pose.y_m, face[0] - pose.x_m) - pose.yaw_rad, math.tau
            )
        seen = view(100.0 + tick * DT, pose=pose, twist=twist, obstacles=near)
        drive = driver.drive(seen, lambda _: spots(goal), speed_mps=speed_mps, face_rad=bearing)
        if drive.at_goal:
            break
        if limiter is None:
            twist = drive.twist
        else:
            twist = limiter.limit(
                MotionRequest("test", NavState.NAVIGATING, drive.twist),
                dt_s=DT,
                scan_age_s=0.0,
                odom_age_s=0.0,
                camera_age_s=0.0,
                obstacles_in_base_m=near,
                target_in_base=None,
                measured=twist,
            ).twist
        pose = compose(pose, Pose2D(twist.vx_mps * DT, twist.vy_mps * DT, twist.wz_radps * DT))
        poses.append(pose)
    return poses, least, drive


def gap(width: float, x: float = 1.0) -> FloatArray:
    return np.vstack([wall(x, width / 2, x, 2.0), wall(x, -2.0, x, -width / 2)])


def test_it_arrives_on_a_free_floor() -> None:
    poses, _, last = follow(CONFIG, NO_POINTS, (1.0, 0.5))
    assert last.at_goal
    assert (poses[-1].x_m, poses[-1].y_m) == pytest.approx((1.0, 0.5), abs=0.1)


@pytest.mark.parametrize("config", [CONFIG, DIFFERENTIAL, LONG])
def test_it_goes_round_a_box_without_touching_it(config: Config) -> None:
    sides = [
        wall(0.9, -0.4, 0.9, 0.3),
        wall(1.3, -0.4, 1.3, 0.3),
        wall(0.9, -0.4, 1.3, -0.4),
        wall(0.9, 0.3, 1.3, 0.3),
    ]
    _, least, last = follow(config, np.vstack(sides), (2.2, 0.0))
    assert last.at_goal
    assert least > config.avoid.stop_clearance_m


@pytest.mark.parametrize("config", [CONFIG, DIFFERENTIAL, LONG])
@pytest.mark.parametrize("width", [0.7, 0.45])
def test_it_passes_a_doorway(config: Config, width: float) -> None:
    _, least, last = follow(config, gap(width), (2.0, 0.3))
    assert last.at_goal
    assert least > 0.01


def test_a_strafing_base_faces_what_it_looks_at_all_the_way() -> None:
    looked_at = (1.0, 2.0)
    poses, _, _ = follow(CONFIG, NO_POINTS, (2.0, 0.0), face=looked_at)
    errors = [
        abs(math.remainder(math.atan2(looked_at[1] - p.y_m, looked_at[0] - p.x_m) - p.yaw_rad, math.tau))
        for p in poses
    ]
    assert max(errors[60:]) < 0.15


def test_a_long_body_that_looks_aside_turns_along_the_way_for_a_narrow_gap() -> None:
    obstacles = gap(0.40)
    poses, least, last = follow(LONG, obstacles, (2.0, 0.0), face=(1.0, 5.0))
    assert last.at_goal
    assert least > 0.01
    inside = [pose.yaw_rad for pose in poses if abs(pose.x_m - 1.0) < 0.1]
    assert max(abs(yaw) for yaw in inside) < 0.3
    assert poses[-1].yaw_rad > 0.8, "and looks aside again behind it"


def bent_passage(width: float) -> FloatArray:
    """From the left along y = 0 to the bend at the origin, then down along x = 0 and to the right at y = -1.2."""
    w = width / 2
    sides = [
        wall(-1.5, w, w, w),
        wall(-1.5, -w, -w, -w),
        wall(w, w, w, -1.2 + w),
        wall(-w, -w, -w, -1.2 - w),
        wall(w, -1.2 + w, 1.5, -1.2 + w),
        wall(-w, -1.2 - w, 1.5, -1.2 - w),
    ]
    return np.vstack(sides)


@pytest.mark.parametrize(
    ("goal", "askew_deg"), [((-2.0, 0.0), 30), ((-2.0, 0.0), 45), ((2.0, -1.2), -40), ((2.0, -1.2), 70)]
)
def test_askew_in_a_bend_it_turns_to_where_it_fits(goal: tuple[float, float], askew_deg: int) -> None:
    """Half a metre is 9 cm more than the body's diagonal: askew it fits nowhere but where it stands."""
    start = Pose2D(0.02, -0.02, math.radians(askew_deg))
    _, least, last = follow(
        CONFIG, bent_passage(0.5), goal, start=start, seconds=60.0, limiter=VelocityLimiter(CONFIG)
    )
    assert last.at_goal
    assert least > 0.01


@pytest.mark.parametrize("y", [-1.0, 0.4, 1.0])
def test_a_differential_base_never_strafes(y: float) -> None:
    drive = Driver(DIFFERENTIAL).drive(view(), lambda _: spots((0.5, y)), speed_mps=0.2, face_rad=1.0)
    assert drive.twist.vy_mps == 0.0
    assert drive.twist.vx_mps >= 0.0
    assert drive.twist.wz_radps * y > 0.0


def test_it_is_slower_where_it_is_narrow() -> None:
    def speed(width: float) -> float:
        walls = np.vstack([wall(-0.5, width / 2, 2.0, width / 2), wall(-0.5, -width / 2, 2.0, -width / 2)])
        return (
            Driver(CONFIG)
            .drive(view(obstacles=walls), lambda _: spots((1.5, 0.0)), speed_mps=0.3)
            .twist.vx_mps
        )

    assert speed(3.0) == pytest.approx(0.3)
    assert 0.05 < speed(0.5) < speed(0.8) < 0.3


def test_without_a_way_it_stands_and_says_so() -> None:
    ring = [(0.4 * math.cos(a), 0.4 * math.sin(a)) for a in np.linspace(0.0, 6.28, 80)]
    drive = Driver(CONFIG).drive(view(obstacles=ring), lambda _: spots((2.0, 0.0)), speed_mps=0.2)
    assert math.isinf(drive.cost_to_go_m)
    assert drive.twist == STOP
    assert drive.reason == "no way"


def test_no_spots_are_no_way() -> None:
    drive = Driver(CONFIG).drive(view(), lambda _: spots(), speed_mps=0.2)
    assert math.isinf(drive.cost_to_go_m)


def test_a_straight_way_needs_no_route() -> None:
    driver = Driver(CONFIG)
    drive = driver.drive(view(), lambda _: spots((0.0, 5.0)), speed_mps=0.2, straight_to_m=(1.0, 0.0))
    assert drive.twist == Twist2D(0.2, 0.0, 0.0)
    assert drive.cost_to_go_m == pytest.approx(1.0)
    assert driver.route is None


def plans_of(driver: Driver, busy: list[bool], start_s: float = 0.0) -> list[int]:
    """The ticks in which a plan was made, for a box that hides the goal."""
    planned: list[int] = []
    box = wall(0.9, -0.3, 0.9, 0.3)
    for tick, is_busy in enumerate(busy):

        def goals(_: FloatArray, tick: int = tick) -> FloatArray:
            planned.append(tick)
            return spots((2.0, 0.0))

        seen = view(start_s + tick * DT, obstacles=box)
        driver.drive(replace(seen, is_busy=is_busy), goals, speed_mps=0.2)
    return planned


def test_a_plan_waits_for_a_tick_without_a_scan() -> None:
    busy = [tick % 4 == 0 for tick in range(24)]
    planned = plans_of(Driver(CONFIG), busy)
    assert planned[0] == 0, "without any plan it does not wait"
    assert not any(busy[tick] for tick in planned[1:])


def test_but_not_for_long() -> None:
    planned = plans_of(Driver(CONFIG), [True] * 40)
    gaps = np.diff(planned)
    assert len(gaps) >= 4
    assert gaps.max() * DT <= 0.3 + 0.1 + DT + 1e-9


def test_a_straight_way_that_closes_in_a_busy_tick_is_planned_round_in_the_next() -> None:
    driver = Driver(CONFIG)
    planned: list[float] = []

    def goals(_: FloatArray) -> FloatArray:
        planned.append(1.0)
        return spots((2.0, 0.0))

    driver.drive(view(0.0), goals, speed_mps=0.2, straight_to_m=(2.0, 0.0))
    closed = wall(0.6, -0.3, 0.6, 0.3)
    busy = driver.drive(replace(view(DT, obstacles=closed), is_busy=True), goals, speed_mps=0.2)
    assert planned == []
    assert busy.reason != "no way"
    assert busy.twist != STOP, "it goes on, with avoidance looking after that tick"
    driver.drive(replace(view(2 * DT, obstacles=closed), is_busy=True), goals, speed_mps=0.2)
    assert len(planned) == 1

"""What one tick of the nav loop costs without the tree, for each skill: 360 beams, five pins in the picture.

The robot drives in the simulator, in closed loop, with the measured noise on; timed is what the nav process does
between its inputs and its command: odometry's buffer, obstacle memory, tracker, one skill, limiter. CPU time of the
thread, so that what else runs on the machine counts little. Bounds: p50 1.0 ms, p99 3 ms.
"""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks import OURS, Row
from target_nav.app.virtual import SimIo
from target_nav.config import Config
from target_nav.hardware import protocol
from target_nav.nav.arrival import ConfirmArrival
from target_nav.nav.blind_approach import BlindApproach
from target_nav.nav.go_to_point import GoToPoint
from target_nav.nav.hold_still import HoldStill
from target_nav.nav.limiter import VelocityLimiter
from target_nav.nav.look_round import LookRound
from target_nav.nav.navigate import NavigateToTarget
from target_nav.nav.obstacles import ObstacleMemory
from target_nav.nav.poses import PoseHistory
from target_nav.nav.skill import Skill, SkillStatus, View
from target_nav.nav.spiral_search import SpiralSearch
from target_nav.nav.tracker import TargetTracker
from target_nav.nav.turn_search import TurnSearch
from target_nav.sim.arena_types import Arena, Bounds, BoxObstacle, PlacedObject
from target_nav.sim.simulation import Simulation
from target_nav.state.types import STOP, MotionRequest, NavState, Pose2D, TargetSpec
from target_nav.utils.frames import to_child

TICKS = 600
TICK_S = 0.05
CONFIG = Config()
SPEC = TargetSpec()
STAND_OFF_M, RADIUS_M = 0.10, 0.04
PINS = ((1.4, 0.1), (1.9, -0.7), (2.2, 0.9), (2.4, -0.2), (2.0, 0.4))
"""The first is the nearest, and so the one that is meant."""
BOXES = (
    BoxObstacle(0.0, 0.1, 0.4, 0.5, 0.0), BoxObstacle(-1.0, 1.2, 0.5, 0.3, 0.3), BoxObstacle(0.9, -0.9, 0.3, 0.6, 0.0),
    BoxObstacle(-0.4, -1.4, 0.6, 0.3, 0.5), BoxObstacle(2.6, -1.8, 0.4, 0.4, 0.0),
)  # fmt: skip
FAR, NEAR, THERE = Pose2D(-1.4, -0.2, 0.0), Pose2D(0.62, 0.1, 0.0), Pose2D(1.4 - 0.15 - 0.10 - 0.04, 0.1, 0.0)


@dataclass(frozen=True)
class Case:
    """`with_track`: the skill is told of the track; a search is not, or it would end."""

    name: str
    make: Callable[[], Skill]
    start: Pose2D
    with_track: bool
    near_target: bool = False


CASES = (
    Case("HoldStill", HoldStill, FAR, True),
    Case("TurnSearch", lambda: TurnSearch(CONFIG, time_limit_s=30.0, yaw_rate_radps=0.8), FAR, False),
    Case("LookRound", lambda: LookRound(CONFIG, time_limit_s=30.0, yaw_rate_radps=0.8), FAR, True),
    Case(
        "SpiralSearch",
        lambda: SpiralSearch(CONFIG, time_limit_s=180.0, radius_m=8.0, spacing_m=0.8, speed_mps=0.25),
        FAR,
        False,
    ),
    Case(
        "NavigateToTarget",
        lambda: NavigateToTarget(CONFIG, cruise_speed_mps=0.15, until_range_m=0.8, lost_after_s=3.0),
        FAR,
        True,
    ),
    Case(
        "GoToPoint",
        lambda: GoToPoint(CONFIG, x_m=3.6, y_m=-1.0, within_m=0.1, speed_mps=0.2, time_limit_s=90.0),
        FAR,
        True,
    ),
    Case(
        "BlindApproach",
        lambda: BlindApproach(
            CONFIG, stand_off_m=STAND_OFF_M, speed_mps=0.1, timeout_s=15.0, target_radius_m=RADIUS_M
        ),
        NEAR,
        True,
        near_target=True,
    ),
    Case(
        "ConfirmArrival",
        lambda: ConfirmArrival(
            CONFIG, stand_off_m=STAND_OFF_M, confirm_s=0.3, target_radius_m=RADIUS_M, timeout_s=3.0
        ),
        THERE,
        True,
        near_target=True,
    ),
)


def run() -> list[Row]:
    rows = []
    parts: dict[str, list[float]] = defaultdict(list)
    for case in CASES:
        times = drive(case, parts)
        rows.append(Row(f"{case.name}: one tick, p50", OURS, 1e3 * float(np.median(times)), "ms"))
        rows.append(Row(f"{case.name}: one tick, p99", OURS, 1e3 * float(np.quantile(times, 0.99)), "ms"))
    for name, spent in parts.items():
        note = f"p99 {1e3 * float(np.quantile(spent, 0.99)):.2f} ms, over all cases"
        rows.append(Row(f"of which {name}, p50", OURS, 1e3 * float(np.median(spent)), "ms", note))
    return rows


def arena_of(start: Pose2D) -> Arena:
    pins = [PlacedObject("bowling_pin", x, y) for x, y in PINS]
    return Arena(
        name="bench",
        bounds=Bounds(-3.0, -3.0, 3.5, 3.0),
        robot=start,
        target=pins[0],
        obstacles=BOXES,
        decoys=tuple(pins[1:]),
        config=CONFIG,
    )


def drive(case: Case, parts: dict[str, list[float]]) -> list[float]:
    """CPU seconds of each of TICKS ticks; a skill that ends begins anew from the start."""
    times: list[float] = []
    seed = 0
    while len(times) < TICKS:
        times += one_run(case, seed, TICKS - len(times), parts)
        seed += 1
    return times


def one_run(case: Case, seed: int, ticks: int, parts: dict[str, list[float]]) -> list[float]:
    simulation = Simulation(arena_of(case.start), seed)
    io = SimIo(simulation, CONFIG)
    poses, obstacles = PoseHistory(), ObstacleMemory(CONFIG)
    tracker, limiter = TargetTracker(CONFIG), VelocityLimiter(CONFIG)
    skill: Skill | None = None
    times: list[float] = []
    tick = 0
    while len(times) < ticks:
        tick += 1
        now_s = tick * TICK_S
        inputs = io.read(now_s)
        begin_s = time.thread_time()
        for odometry in inputs.odometry_since:
            poses.add(odometry)
        pose, latest = poses.predict(now_s), poses.latest
        if pose is None or latest is None:
            simulation.serial_write(protocol.encode_velocity(STOP))
            continue
        obstacles.update(now_s, poses, inputs.scan)
        seen_s = time.thread_time()
        track = tracker.update(now_s, poses, SPEC, inputs.detections, inputs.scan)
        tracked_s = time.thread_time()
        points = obstacles.points_in_base(pose, track, SPEC)
        view = View(
            now_s,
            TICK_S,
            pose,
            latest.twist_in_base,
            track if case.with_track else None,
            points,
            inputs.detections,
        )
        given_s = time.thread_time()
        if skill is None and now_s >= 2.0:
            skill = case.make()
            skill.start(view)
        step = skill.step(view) if skill is not None else None
        stepped_s = time.thread_time()
        request = None
        if step is not None:
            request = MotionRequest(case.name, NavState.NAVIGATING, step.twist, near_target=case.near_target)
        limited = limiter.limit(
            request,
            dt_s=TICK_S,
            scan_age_s=0.1,
            odom_age_s=0.0,
            camera_age_s=0.1,
            obstacles_in_base_m=points,
            target_in_base=to_child(pose, track.x_m, track.y_m) if track is not None else None,
            measured=latest.twist_in_base,
        )
        end_s = time.thread_time()
        simulation.serial_write(protocol.encode_velocity(limited.twist))
        if step is None:
            continue  # the scene is only coming up
        times.append(end_s - begin_s)
        spent = (
            seen_s - begin_s + given_s - tracked_s,
            tracked_s - seen_s,
            stepped_s - given_s,
            end_s - stepped_s,
        )
        for name, each in zip(("poses and obstacles", "tracker", "skill", "limiter"), spent):
            parts[name].append(each)
        if step.status is not SkillStatus.RUNNING:
            break
    return times

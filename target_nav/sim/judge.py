"""How a run went, by the truth: what a person with a tape measure would find."""

from __future__ import annotations

import math
from dataclasses import dataclass

from target_nav.sim.arena_types import Arena, PlacedObject
from target_nav.sim.geometry import point_to_segment
from target_nav.state.types import Pose2D, Twist2D
from target_nav.utils.frames import to_child

STOP_TOLERANCE_M = 0.05
"""A stop is right within this: half of the reference's stand-off, and a gripper's reach."""

BEARING_TOLERANCE_RAD = 0.25
"""The target is ahead within this: at the reference's stand-off, well inside of the robot's width."""

STILL_MPS = 0.01
STILL_RADPS = 0.03
"""Slower than this stands still: under the motors' dead-band."""


@dataclass(frozen=True)
class Verdict:
    """`stop_error_m` is the gap from the front edge to the target's surface less the stand-off, or the distance to the
    goal; `bearing_error_rad` is the target's direction off straight ahead. None where there is nothing to measure to.
    """

    success: bool
    collided: bool
    stop_error_m: float | None
    bearing_error_rad: float | None
    min_clearance_m: float
    standing_still: bool
    path_m: float


def target_gap_m(pose: Pose2D, arena: Arena, target: PlacedObject) -> float:
    """From the footprint's front edge to the target's surface."""
    body = arena.config.robot
    x, y = to_child(pose, target.x_m, target.y_m)
    centre_m = point_to_segment(x, y, body.front_m, -body.half_width_m, body.front_m, body.half_width_m)
    return centre_m - target.shape.radius_m


def judge(
    arena: Arena,
    pose: Pose2D,
    twist: Twist2D,
    *,
    stand_off_m: float,
    reported_arrived: bool,
    collided: bool,
    min_clearance_m: float,
    path_m: float,
) -> Verdict:
    """Success is: with a target, arrival reported, standing still, the target ahead at the stand-off; with a goal,
    standing still within its radius; where nothing is to be found, no arrival reported and standing still.
    """
    still = twist.speed_mps <= STILL_MPS and abs(twist.wz_radps) <= STILL_RADPS
    stop_error: float | None = None
    bearing: float | None = None
    there = False
    if arena.target is not None:
        stop_error = target_gap_m(pose, arena, arena.target) - stand_off_m
        x, y = to_child(pose, arena.target.x_m, arena.target.y_m)
        bearing = math.atan2(y, x)
        there = (
            reported_arrived and abs(stop_error) <= STOP_TOLERANCE_M and abs(bearing) <= BEARING_TOLERANCE_RAD
        )
    elif arena.goal is not None:
        stop_error = math.hypot(arena.goal.x_m - pose.x_m, arena.goal.y_m - pose.y_m)
        there = stop_error <= arena.goal.radius_m
    if arena.expect == "not_found":
        there = not reported_arrived
    return Verdict(
        success=there and still,
        collided=collided,
        stop_error_m=stop_error,
        bearing_error_rad=bearing,
        min_clearance_m=min_clearance_m,
        standing_still=still,
        path_m=path_m,
    )

"""What counts as success, by the tape measure."""

import pytest

from target_nav.sim.arena import Arena, Bounds, Goal, PlacedObject
from target_nav.sim.judge import Verdict, judge
from target_nav.state.types import Pose2D, Twist2D

BOUNDS = Bounds(-3, -3, 3, 3)
PIN = Arena("pin", BOUNDS, Pose2D(), target=PlacedObject("bowling_pin", 1.0, 0.0))
# The front edge is 0.15 m ahead of base_link, the pin's radius 0.04 m: 0.10 m of stand-off is at x = 0.71.
RIGHT = Pose2D(0.71, 0.0, 0.0)


def verdict(
    arena: Arena = PIN, pose: Pose2D = RIGHT, twist: Twist2D | None = None, arrived: bool = True
) -> Verdict:
    return judge(
        arena, pose, twist or Twist2D(), stand_off_m=0.10, reported_arrived=arrived, collided=False,
        min_clearance_m=0.1, path_m=2.0,
    )  # fmt: skip


def test_standing_at_the_stand_off_with_the_pin_ahead_is_success():
    result = verdict()
    assert result.success
    assert result.stop_error_m == pytest.approx(0.0)
    assert result.bearing_error_rad == pytest.approx(0.0)


@pytest.mark.parametrize(
    ("pose", "stop_error_m"),
    [(Pose2D(0.61, 0.0, 0.0), 0.10), (Pose2D(0.79, 0.0, 0.0), -0.08)],
)
def test_too_far_and_too_near_are_not(pose, stop_error_m):
    result = verdict(pose=pose)
    assert not result.success
    assert result.stop_error_m == pytest.approx(stop_error_m)


def test_a_pin_at_the_corner_of_the_front_edge_is_measured_from_there():
    """0.14 m to the left of the middle the edge ends; the bearing says that the pin is not ahead."""
    result = verdict(pose=Pose2D(0.71, -0.14, 0.0))
    assert result.stop_error_m == pytest.approx(0.0)
    assert result.bearing_error_rad > 0.25
    assert not result.success


def test_passing_by_is_not_standing():
    assert not verdict(twist=Twist2D(0.05, 0.0, 0.0)).success
    assert not verdict(twist=Twist2D(0.0, 0.0, 0.1)).success


def test_arrival_must_have_been_reported():
    assert not verdict(arrived=False).success


def test_a_goal_is_reached_within_its_radius_reported_or_not():
    arena = Arena("goal", BOUNDS, Pose2D(), goal=Goal(1.0, 0.0, 0.1))
    assert verdict(arena, Pose2D(0.95, 0.0, 2.0), arrived=False).success
    assert not verdict(arena, Pose2D(0.85, 0.0, 0.0)).success


def test_where_nothing_is_to_be_found_arrival_is_the_mistake():
    arena = Arena("nothing", BOUNDS, Pose2D(), expect="not_found")
    right = verdict(arena, arrived=False)
    assert right.success
    assert right.stop_error_m is None
    assert right.bearing_error_rad is None
    assert not verdict(arena, arrived=True).success

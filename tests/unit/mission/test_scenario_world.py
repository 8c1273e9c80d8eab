"""The scripted blackboard: what a friendly word means, tick after tick."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from py_trees.blackboard import Blackboard

from target_nav.config import Config
from target_nav.mission.scenario_values import BadScript, value_of
from target_nav.mission.scenario_world import ScriptedWorld, full_name, names
from target_nav.state import keys
from target_nav.state.types import STOP, MotionRequest, NavState, Pose2D, TargetSpec, Track, Twist2D
from tests.utils.board import track_at

TICK_S = 0.05


@pytest.fixture
def world() -> Iterator[ScriptedWorld]:
    Blackboard.clear()
    made = ScriptedWorld(Config(), drives=True)
    made.begin_tick(0.0, TICK_S)
    yield made
    Blackboard.clear()


def at(world: ScriptedWorld, now_s: float, key: keys.Key) -> Any:
    world.begin_tick(now_s, TICK_S)
    return Blackboard.get(key.name)


def ask(twist: Twist2D) -> None:
    Blackboard.set(keys.REQUEST.name, MotionRequest("leaf", NavState.NAVIGATING, twist))


def test_all_keys_of_the_table_are_there_and_harmless(world: ScriptedWorld) -> None:
    board = Blackboard.storage
    assert {key.name for key in keys.ALL} == set(board)
    loop = Config().loop
    assert board[keys.SCAN_AGE_S.name] < loop.scan_max_age_s
    assert board[keys.ODOM_AGE_S.name] < loop.odom_max_age_s
    assert board[keys.CAMERA_AGE_S.name] < loop.camera_max_age_s
    assert (board[keys.REQUESTED.name], board[keys.TRACK.name], board[keys.POSE.name]) == (
        False,
        None,
        Pose2D(),
    )
    for key in keys.ALL:
        value = board[key.name]
        assert isinstance(value, key.type) or (value is None and key.optional), key.name


def test_a_name_is_the_last_part_of_a_key_or_the_whole() -> None:
    assert full_name("track") == full_name("/target/track") == "/target/track"
    assert full_name("/goal") == "/goal"
    with pytest.raises(BadScript, match='did you mean "track"'):
        full_name("trak")
    assert len(set(names())) == len(keys.ALL) + 1


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("now_s", "own clock"),
        ("/clock/dt_s", "own clock"),
        ("config", "given by `config`"),
        ("request", "written by \\*motion"),
        ("outcome", "written by \\*ending"),
        ("spec", "written by SetTarget"),
        ("nonsense", "there is no key"),
    ],
)
def test_what_others_write_cannot_be_scripted(world: ScriptedWorld, name: str, why: str) -> None:
    with pytest.raises(BadScript, match=why):
        world.set(name, 1)


def test_an_age_stays_or_grows_once_the_input_stops(world: ScriptedWorld) -> None:
    world.set("scan_age_s", 0.3)
    assert at(world, 1.0, keys.SCAN_AGE_S) == at(world, 5.0, keys.SCAN_AGE_S) == 0.3
    world.set("scan_age_s", "stops")
    assert at(world, 7.0, keys.SCAN_AGE_S) == pytest.approx(2.3)
    world.set("scan_age_s", "never")
    assert at(world, 8.0, keys.SCAN_AGE_S) == math.inf
    with pytest.raises(BadScript, match="seconds, `stops` or `never`"):
        world.set("scan_age_s", "gone")


def test_a_track_is_placed_from_where_the_robot_is_then_and_stays_there(world: ScriptedWorld) -> None:
    world.set("pose_in_odom", [1.0, 0.0, math.pi / 2])
    world.set("track", {"range_m": 2.0, "bearing_rad": -math.pi / 2})
    track: Track = at(world, 0.5, keys.TRACK)
    assert (track.x_m, track.y_m) == pytest.approx((3.0, 0.0))
    world.set("pose_in_odom", {"yaw_rad": 0.0})
    track = at(world, 1.0, keys.TRACK)
    assert (track.range_m, track.bearing_rad) == pytest.approx((2.0, 0.0))
    assert (track.stamp_s, track.last_seen_s, track.last_ranged_s) == (1.0, 1.0, 1.0)


def test_a_track_that_is_not_seen_any_more_grows_old_from_then_on(world: ScriptedWorld) -> None:
    world.set("track", {"x_m": 1.0, "y_m": 0.0})
    at(world, 2.0, keys.TRACK)
    world.set("track", {"seen": False})
    track: Track = at(world, 5.0, keys.TRACK)
    assert (track.last_seen_s, track.last_ranged_s, track.x_m) == (2.0, 5.0, 1.0)
    world.set("track", {"seen": False, "ranged": False})
    assert at(world, 6.0, keys.TRACK).last_seen_s == 2.0
    world.set("track", {"seen": True})
    assert at(world, 7.0, keys.TRACK).last_seen_s == 7.0
    world.set("track", "none")
    assert at(world, 8.0, keys.TRACK) is None


def test_a_new_track_that_is_not_ranged_never_was(world: ScriptedWorld) -> None:
    world.set("track", {"x_m": 1.0, "y_m": 0.0, "ranged": False})
    assert at(world, 1.0, keys.TRACK).last_ranged_s == -math.inf


def test_a_track_object_is_taken_as_it_is(world: ScriptedWorld) -> None:
    world.set("track", track_at(1.0, 2.0, confirmed=False))
    track: Track = at(world, 1.0, keys.TRACK)
    assert (track.x_m, track.y_m, track.confirmed) == (1.0, 2.0, False)


@pytest.mark.parametrize(
    ("data", "why"),
    [
        ({"confirmed": True}, "track is new"),
        ({"x_m": 1.0}, "track is new"),
        ({"x_m": 1.0, "y_m": 0.0, "range_m": 2.0}, "placed twice"),
        ({"x_m": "far", "y_m": 0.0}, "x_m is 'far'"),
        ({"range": 2.0}, "track has no 'range'; did you mean \"ranged\""),
        (3.0, "must be a mapping"),
        ({"x_m": 1.0, "y_m": 0.0, "hits": 2.5}, "whole number"),
        ({"x_m": 1.0, "y_m": 0.0, "seen": 1}, "true or false"),
    ],
)
def test_a_track_that_is_not_one(world: ScriptedWorld, data: Any, why: str) -> None:
    with pytest.raises(BadScript, match=why):
        world.set("track", data)


def test_obstacles_stand_in_odom_while_the_robot_moves(world: ScriptedWorld) -> None:
    world.set("obstacles", [{"circle": [2.0, 0.0, 0.1]}, {"wall": [0.0, 1.0, 1.0, 1.0]}])
    points = at(world, 0.0, keys.OBSTACLES)
    assert np.hypot(points[:, 0] - 2.0, points[:, 1]).min() == pytest.approx(0.1)
    world.set("pose_in_odom", [1.0, 0.0, 0.0])
    moved = at(world, 0.1, keys.OBSTACLES)
    assert moved == pytest.approx(points - [1.0, 0.0])
    world.set("obstacles", None)
    assert at(world, 0.2, keys.OBSTACLES).shape == (0, 2)


def test_a_box_is_its_outline(world: ScriptedWorld) -> None:
    world.set("obstacles", [{"box": [1.0, 0.0, 0.4, 0.2, 0.0]}])
    points = at(world, 0.0, keys.OBSTACLES)
    assert (points.min(axis=0), points.max(axis=0)) == (pytest.approx([0.8, -0.1]), pytest.approx([1.2, 0.1]))
    assert (np.isclose(np.abs(points[:, 0] - 1.0), 0.2) | np.isclose(np.abs(points[:, 1]), 0.1)).all()


def test_points_in_base_go_along(world: ScriptedWorld) -> None:
    world.set("obstacles_in_base_m", [[1.0, 0.5]])
    world.set("pose_in_odom", [3.0, 3.0, 1.0])
    assert at(world, 0.1, keys.OBSTACLES).tolist() == [[1.0, 0.5]]
    with pytest.raises(BadScript, match=r"\[\[x, y\], \.\.\.\]"):
        world.set("obstacles_in_base_m", [[1.0]])


def test_a_detection_has_the_box_that_the_target_would_have(world: ScriptedWorld) -> None:
    world.set("camera_age_s", 0.2)
    world.set("detections", [{"range_m": 2.0, "bearing_rad": 0.1}])
    frame = at(world, 1.0, keys.DETECTIONS)
    (detection,) = frame.detections
    camera, spec = Config().camera, TargetSpec()
    assert frame.stamp_s == pytest.approx(0.8)
    assert detection.class_name == spec.class_name
    assert detection.height_px == pytest.approx(camera.focal_px * spec.height_m / 2.0)
    assert detection.u_px < camera.width_px / 2.0, "left in the picture for a bearing to the left"
    world.set("detections", [])
    assert at(world, 1.1, keys.DETECTIONS).detections == ()
    world.set("detections", "none")
    assert at(world, 1.2, keys.DETECTIONS) is None


def test_a_robot_that_drives_follows_what_is_asked_for(world: ScriptedWorld) -> None:
    for _ in range(20):
        world.begin_tick(0.0, TICK_S)
        ask(Twist2D(0.2, 0.0, 0.0))
        world.end_tick(TICK_S)
    assert world.pose_in_odom.x_m == pytest.approx(0.2)
    assert at(world, 1.0, keys.TWIST) == Twist2D(0.2, 0.0, 0.0)
    world.hold()
    world.end_tick(TICK_S)
    assert (world.pose_in_odom.x_m, at(world, 1.05, keys.TWIST)) == (pytest.approx(0.2), STOP)


def test_it_drives_a_circle_back_to_where_it_began(world: ScriptedWorld) -> None:
    ticks = 200
    ask(Twist2D(0.3, 0.0, math.tau / (ticks * TICK_S)))
    farthest = 0.0
    for _ in range(ticks):
        world.end_tick(TICK_S)
        farthest = max(farthest, math.hypot(world.pose_in_odom.x_m, world.pose_in_odom.y_m))
    assert world.pose_in_odom.x_m == pytest.approx(0.0, abs=1e-9)
    assert world.pose_in_odom.y_m == pytest.approx(0.0, abs=1e-9)
    assert farthest == pytest.approx(2.0 * 0.3 * ticks * TICK_S / math.tau, rel=1e-3)


def test_a_velocity_that_is_no_number_moves_nothing(world: ScriptedWorld) -> None:
    ask(Twist2D(math.nan, 0.0, 0.0))
    world.end_tick(TICK_S)
    assert world.pose_in_odom == Pose2D()


def test_a_robot_that_stands_is_where_the_script_says() -> None:
    Blackboard.clear()
    world = ScriptedWorld(Config(), drives=False)
    world.set("twist_in_base", {"vx_mps": 0.1})
    ask(Twist2D(0.2, 0.0, 0.0))
    world.end_tick(TICK_S)
    assert at(world, 0.0, keys.POSE) == Pose2D()
    assert at(world, 0.0, keys.TWIST) == Twist2D(0.1, 0.0, 0.0)
    Blackboard.clear()


def test_a_robot_that_drives_has_no_scripted_velocity(world: ScriptedWorld) -> None:
    with pytest.raises(BadScript, match="robot: stands"):
        world.set("twist_in_base", {"vx_mps": 0.1})


def test_a_missions_own_entry_takes_what_it_is_given(world: ScriptedWorld) -> None:
    world.set("/goal", {"x_m": 1.0})
    assert Blackboard.get("/goal") == {"x_m": 1.0}


@pytest.mark.parametrize(
    ("data", "wanted", "value"),
    [
        (1, float, 1.0),
        (True, bool, True),
        ("NAVIGATING", NavState, NavState.NAVIGATING),
        ({"x_m": 1, "yaw_rad": 0.5}, Pose2D, Pose2D(1.0, 0.0, 0.5)),
        ([1, 2], tuple[float, float], (1.0, 2.0)),
        ([1, 2, 3], tuple[int, ...], (1, 2, 3)),
        (None, float | None, None),
        (2, float | None, 2.0),
        (Pose2D(1.0), Pose2D, Pose2D(1.0)),
    ],
)
def test_values_of_every_kind_of_key(data: Any, wanted: Any, value: Any) -> None:
    assert value_of(data, wanted, "it") == value


@pytest.mark.parametrize(
    ("data", "wanted", "why"),
    [
        (True, float, "must be a number"),
        (1, bool, "true or false"),
        (1.5, int, "whole number"),
        ("FLYING", NavState, "IDLE or NAVIGATING"),
        ({"x": 1}, Pose2D, "it has no 'x'"),
        ({"owner": "a"}, MotionRequest, "lacks state, twist"),
        ({"x_m": "a"}, Pose2D, "it: x_m is 'a'"),
        ([1], tuple[float, float], "must have 2"),
        (None, float, "it is none"),
    ],
)
def test_values_that_a_key_cannot_hold(data: Any, wanted: Any, why: str) -> None:
    with pytest.raises(BadScript, match=why):
        value_of(data, wanted, "it")

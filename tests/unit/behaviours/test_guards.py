"""The guards say yes or no, and when no, what is missing."""

from __future__ import annotations

import math

import pytest
from py_trees.common import Access, Status

from behaviours import InputsFresh, MissionRequested, SetTarget, TargetTracked
from behaviours.leaf import MissionLeaf
from target_nav.state import keys
from target_nav.state.target_label import TargetDetector
from target_nav.state.types import TargetSpec
from tests.utils.board import ScriptedBoard, track_at


def ticked(leaf: MissionLeaf, **ports: object) -> Status:
    """The leaf's status after one tick, with its ports as a mission file would set them."""
    leaf.setup_ports(port_remappings={port: f"/test/{port}" for port in ports})
    client = leaf.attach_blackboard_client(name="test")
    for port, value in ports.items():
        client.register_key(key=f"/test/{port}", access=Access.WRITE)
        client.set(f"/test/{port}", value)
    leaf.tick_once()
    return leaf.status


def test_mission_requested_follows_the_operators_last_word(board: ScriptedBoard) -> None:
    leaf = MissionRequested("requested")
    assert ticked(leaf) is Status.SUCCESS
    board.write(keys.REQUESTED, False)
    leaf.tick_once()
    assert leaf.status is Status.FAILURE


def test_fresh_inputs_pass(board: ScriptedBoard) -> None:
    assert ticked(InputsFresh("fresh")) is Status.SUCCESS


@pytest.mark.parametrize(
    ("key", "age_s", "words"),
    [
        (keys.SCAN_AGE_S, 0.82, "scan 0.82 s old (limit 0.80 s); is the LiDAR running?"),
        (keys.SCAN_AGE_S, math.inf, "scan has not come yet (limit 0.80 s); is the LiDAR running?"),
        (keys.ODOM_AGE_S, 0.31, "odometry 0.31 s old (limit 0.30 s); are arduino and odometry running?"),
        (keys.CAMERA_AGE_S, 1.5, "camera 1.50 s old (limit 1.00 s); are detector and camera running?"),
        (
            keys.CAMERA_AGE_S,
            math.nan,
            "camera has not come yet (limit 1.00 s); are detector and camera running?",
        ),
    ],
)
def test_a_stale_input_is_named_with_its_age_and_limit(
    board: ScriptedBoard, key: keys.Key, age_s: float, words: str
) -> None:
    board.write(key, age_s)
    leaf = InputsFresh("fresh")
    assert ticked(leaf) is Status.FAILURE
    assert leaf.feedback_message == words
    assert leaf.get_last_output("reason") == words


def test_a_mission_that_looks_for_nothing_needs_no_camera(board: ScriptedBoard) -> None:
    board.write(keys.CAMERA_AGE_S, math.inf)
    assert ticked(InputsFresh("fresh"), camera_needed=False) is Status.SUCCESS
    board.write(keys.SCAN_AGE_S, 5.0)
    assert ticked(InputsFresh("fresh"), camera_needed=False) is Status.FAILURE


def test_the_missions_limit_wins_over_the_configurations(board: ScriptedBoard) -> None:
    board.write(keys.CAMERA_AGE_S, 1.5)
    assert ticked(InputsFresh("fresh"), camera_max_age_s=2.0) is Status.SUCCESS


def test_set_target_writes_what_the_mission_looks_for(board: ScriptedBoard) -> None:
    leaf = SetTarget("target")
    assert ticked(leaf, **{"class": "cone", "height_m": 0.4, "width_m": 0.2}) is Status.SUCCESS
    assert board.read(keys.SPEC) == TargetSpec("cone", 0.4, 0.2)


def test_set_target_names_the_detector_in_the_label(board: ScriptedBoard) -> None:
    ports = {"class": "7", "height_m": 0.16, "width_m": 0.16, "detector": TargetDetector.apriltag}
    assert ticked(SetTarget("target"), **ports) is Status.SUCCESS
    assert board.read(keys.SPEC) == TargetSpec("apriltag:7", 0.16, 0.16)


def test_set_target_refuses_a_class_that_would_be_read_as_a_detector(board: ScriptedBoard) -> None:
    leaf = SetTarget("target")
    assert ticked(leaf, **{"class": "apriltag:7", "height_m": 0.16, "width_m": 0.16}) is Status.FAILURE
    assert "apriltag:7" in leaf.feedback_message


@pytest.mark.parametrize(
    ("track", "status"),
    [
        (None, Status.FAILURE),
        (track_at(1.0, 0.0, confirmed=False), Status.FAILURE),
        (track_at(1.0, 0.0, last_seen_s=-1.01), Status.FAILURE),
        (track_at(1.0, 0.0, last_seen_s=-0.99), Status.SUCCESS),
    ],
)
def test_target_tracked_wants_a_confirmed_track_that_was_seen_lately(
    board: ScriptedBoard, track: object, status: Status
) -> None:
    board.write(keys.TRACK, track)
    assert ticked(TargetTracked("tracked")) is status

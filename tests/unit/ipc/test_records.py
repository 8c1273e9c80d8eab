"""Dataclass -> bytes -> dataclass, and what is said of values that have no place there."""

from __future__ import annotations

import dataclasses
from typing import Any

import pytest
from hypothesis import given

from target_nav.errors import DeviceError
from target_nav.ipc.records import CUT, TEXT_BYTES, Record
from target_nav.state.snapshots import Calibration, NavSnapshot, NodeStatus, ProcessRow, TreeRow
from target_nav.state.types import (
    Command,
    CommandKind,
    Detection,
    NavState,
    Outcome,
    OutcomeKind,
    Pose2D,
    RawDetection,
    TargetSpec,
    Track,
    Twist2D,
)
from tests.unit.ipc.values import (
    calibrations,
    commands,
    detection,
    detections,
    navs,
    raw_detections,
    same,
    tracks,
)

NAV = NavSnapshot(
    *(
        1.0,
        20,
        NavState.NAVIGATING,
        None,
        "Navigate",
        "on the way",
        True,
        Pose2D(1.0, 2.0, 0.5),
        Twist2D(0.15),
    ),
    *("", None, TargetSpec(), 0.1, 0.02, 0.3, 20.0, 0.001, 0),
)


def through(value: Any) -> Any:
    record = Record(type(value))
    buffer = bytearray(b"\xff" * (record.size + 16))
    record.pack_into(buffer, 8, value)
    assert buffer[:8] == buffer[-8:] == b"\xff" * 8
    return record.unpack_from(buffer, 8)


@given(navs)
def test_a_nav_snapshot_comes_back_with_none_inf_and_nan(value: NavSnapshot) -> None:
    assert same(through(value), value)


@given(detections)
def test_a_detection_comes_back(value: Detection) -> None:
    assert same(through(value), value)


@given(raw_detections)
def test_a_raw_detection_comes_back(value: RawDetection) -> None:
    assert same(through(value), value)


@given(calibrations)
def test_a_calibration_comes_back(value: Calibration) -> None:
    assert same(through(value), value)


@given(commands)
def test_a_command_comes_back(value: Command) -> None:
    assert same(through(value), value)


@given(tracks)
def test_a_track_comes_back(value: Track) -> None:
    assert same(through(value), value)


def test_every_enum_member_comes_back_as_itself() -> None:
    for state in NavState:
        assert through(replaced(state=state)).state is state
    for kind in OutcomeKind:
        assert through(Outcome(kind, "")).kind is kind
    for command in CommandKind:
        assert through(Command(0.0, command)).kind is command


def replaced(**changes: Any) -> NavSnapshot:
    fields = {name: getattr(NAV, name) for name in NavSnapshot.__dataclass_fields__}
    return NavSnapshot(**{**fields, **changes})


CARRIERS = (NAV, TreeRow("", "", 0, NodeStatus.RUNNING, True, ""), ProcessRow("", "", 1, 0))


@pytest.mark.parametrize("field", sorted(CUT))
def test_a_text_for_people_is_cut_at_a_whole_character(field: str) -> None:
    limit = TEXT_BYTES[field] - 1
    carrier = next(value for value in CARRIERS if hasattr(value, field))
    for lead in range(3):
        text = "x" * lead + "\u20ac" * limit
        back = getattr(through(dataclasses.replace(carrier, **{field: text})), field)
        assert text.startswith(back)
        assert limit - 2 <= len(back.encode()) <= limit


def test_a_text_of_exactly_the_limit_is_kept_whole() -> None:
    text = "r" * (TEXT_BYTES["reason"] - 1)
    assert through(replaced(reason=text)).reason == text


def test_a_name_that_is_too_long_is_refused_for_a_cut_one_would_mean_another_thing() -> None:
    limit = TEXT_BYTES["class_name"] - 1
    assert through(TargetSpec("c" * limit)).class_name == "c" * limit
    with pytest.raises(DeviceError, match=f"class_name .* {limit + 1} bytes long \\(limit {limit}\\)"):
        through(TargetSpec("c" * (limit + 1)))


def test_a_nul_cannot_end_a_text_early_and_a_lone_surrogate_does_no_harm() -> None:
    assert through(replaced(reason="a\0b")).reason == "a b"
    assert through(replaced(reason="a\ud800b")).reason == "a?b"


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (
            replaced(tick=2**63),
            r"NavSnapshot.tick is 9223372036854775808; it must be a whole number in -2\^63",
        ),
        (replaced(tick=1.5), "NavSnapshot.tick is 1.5; it must be a whole number"),
        (replaced(rate_hz="fast"), "NavSnapshot.rate_hz is 'fast'; it must be a number"),
        (replaced(rate_hz=None), "NavSnapshot.rate_hz is None; it must be a number"),
        (replaced(pose_in_odom=None), "NavSnapshot.pose_in_odom is None; it must be a Pose2D"),
        (replaced(state=99), "NavSnapshot.state is 99"),
        (replaced(reason=7), "reason is 7; it must be text"),
        (
            Calibration(0.0, 1.0, 1.0, 1.0, 1.0, (0.0, 0.0), 0.5, "pin"),
            "distortion is .*; it must be 5 numbers",
        ),
    ],
)
def test_a_value_that_does_not_fit_is_named_with_its_limit(value: Any, message: str) -> None:
    with pytest.raises(DeviceError, match=message):
        through(value)


def test_a_number_no_enum_member_has_is_nonsense_from_the_writer() -> None:
    record = Record(Outcome)
    buffer = bytearray(record.size)
    record.pack_into(buffer, 0, Outcome(OutcomeKind.FAILED, "x"))
    buffer[0] = 77
    with pytest.raises(DeviceError, match="kind is 77 in shared memory; OutcomeKind knows"):
        record.unpack_from(buffer)


def test_a_type_without_a_place_in_memory_is_refused_when_the_layout_is_made() -> None:
    from dataclasses import make_dataclass

    with pytest.raises(TypeError, match="has no place in shared memory"):
        Record(make_dataclass("Odd", [("stamp_s", float), ("table", dict)]))
    with pytest.raises(TypeError, match="must be the last field"):
        Record(Detection, tail="score")


def test_numpy_scalars_are_numbers_too() -> None:
    import numpy as np

    value = detection(score=np.float32(0.5), track_id=np.int32(4))
    assert same(through(value), detection(score=0.5, track_id=4))

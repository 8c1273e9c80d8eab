"""What the odometry node takes from /arduino/odom_raw, and what a successor takes from it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from target_nav.app.odometry_node import parse_raw
from target_nav.app.odometry_state import PoseFile
from target_nav.app.ros_convert import BadMessageError
from target_nav.state.types import Odometry, Pose2D, Twist2D

NOW_S = 500.0


def raw(**changes: Any) -> str:
    return json.dumps({"stamp_s": 499.9, "vx_mm": 200, "vy_mm": -5, "wz_mrad": 300, **changes})


def test_millimetres_become_metres() -> None:
    assert parse_raw(raw(), NOW_S) == (499.9, Twist2D(0.2, -0.005, 0.3), None)
    assert parse_raw(raw(device_us=50_000), NOW_S)[2] == 50_000


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("", "raw.form"),
        ("null", "raw.form"),
        ("[1, 2]", "raw.form"),
        ("{", "raw.form"),
        (json.dumps({"vx_mm": 1, "vy_mm": 1, "wz_mrad": 1}), "raw.form"),
        (raw(vx_mm=None), "raw.form"),
        (raw(vx_mm="fast"), "raw.form"),
        (raw(device_us="now"), "raw.form"),
        (raw(device_us=float("inf")), "raw.form"),
        (raw(vx_mm=float("nan")), "raw.not_finite"),
        (raw(stamp_s=float("inf")), "raw.not_finite"),
        (raw(stamp_s=NOW_S + 2.0), "raw.stamp"),
        (raw(stamp_s=NOW_S - 11.0), "raw.stamp"),
    ],
)
def test_what_the_arduino_node_would_not_send_is_refused(text: str, kind: str) -> None:
    with pytest.raises(BadMessageError) as caught:
        parse_raw(text, NOW_S)
    assert caught.value.kind == kind


def test_a_pose_is_found_by_the_next_process(tmp_path: Path) -> None:
    first = PoseFile(tmp_path / "state")
    assert first.last(NOW_S) is None
    first.keep(Odometry(NOW_S - 2.0, Pose2D(9.0, 9.0, 0.0), Twist2D()))
    first.keep(Odometry(NOW_S - 1.0, Pose2D(1.0, 2.0, 3.0), Twist2D()))
    first.close()
    second = PoseFile(tmp_path / "state")
    assert second.last(NOW_S) == (NOW_S - 1.0, Pose2D(1.0, 2.0, 3.0))
    second.close()


@pytest.mark.parametrize("age_s", [-1.0, 11.0])
def test_a_pose_of_another_run_is_not_taken_up(tmp_path: Path, age_s: float) -> None:
    state = PoseFile(tmp_path / "state")
    state.keep(Odometry(NOW_S - age_s, Pose2D(1.0, 2.0, 3.0), Twist2D()))
    assert state.last(NOW_S) is None
    state.close()


@pytest.mark.parametrize("damage", [b"", b"short", b"\xff" * 36, b"\0" * 36])
def test_a_damaged_record_is_not_taken_up(tmp_path: Path, damage: bytes) -> None:
    (tmp_path / "state").write_bytes(damage)
    state = PoseFile(tmp_path / "state")
    assert state.last(NOW_S) is None
    state.close()

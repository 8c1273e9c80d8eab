"""What the odometry node takes from /arduino/odom_raw."""

from __future__ import annotations

import json
from typing import Any

import pytest

from target_nav.app.odometry_node import parse_raw
from target_nav.app.ros_convert import BadMessageError
from target_nav.state.types import Twist2D

NOW_S = 500.0


def raw(**changes: Any) -> str:
    return json.dumps({"stamp_s": 499.9, "vx_mm": 200, "vy_mm": -5, "wz_mrad": 300, **changes})


def test_millimetres_become_metres() -> None:
    assert parse_raw(raw(), NOW_S) == (499.9, Twist2D(0.2, -0.005, 0.3))


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

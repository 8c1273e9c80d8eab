"""Values for a person: short, and without the content of what is large."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from target_nav.config import Config
from target_nav.mission.values_text import MAX_TEXT, value_text
from target_nav.state.types import DetectionFrame, NavState, Pose2D


def test_an_array_is_its_shape() -> None:
    assert value_text(np.zeros((1440, 2))) == "array of shape (1440, 2), float64"
    assert value_text({"points": np.zeros(3)}) == "{points: array of shape (3,), float64}"


def test_an_object_is_its_fields() -> None:
    assert value_text(Pose2D(1.0, -0.5, 1 / 3)) == "Pose2D(x_m=1, y_m=-0.5, yaw_rad=0.333333)"
    assert value_text(NavState.ARRIVED) == "ARRIVED"
    assert value_text(DetectionFrame(1.5, 7)) == "DetectionFrame(stamp_s=1.5, frame_id=7, detections=[])"


def test_long_lists_are_counted() -> None:
    assert value_text(list(range(1000))) == "[0, 1, 2, 3, 4, 5, 6, 7, ... 1000 in all]"


VALUES = st.recursive(
    st.none() | st.text() | st.floats() | st.integers(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
)


@given(VALUES)
def test_every_value_has_a_text_that_is_not_long(value: object) -> None:
    assert len(value_text(value)) <= MAX_TEXT + 3


def test_what_holds_itself_has_a_text() -> None:
    ring: list[object] = []
    ring.append(ring)
    assert value_text(ring) == "[[[[...]]]]"


def test_the_whole_configuration_is_named_by_its_parts() -> None:
    assert value_text(Config()).startswith("Config(robot=RobotConfig(...), lidar=LidarConfig(...), ")
    assert len(value_text(Config())) <= MAX_TEXT + 3

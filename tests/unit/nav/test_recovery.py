"""Backing off, and keeping off the place where it stuck."""

from __future__ import annotations

import math

import pytest

from target_nav.config import Config
from target_nav.nav.recovery import Recovery
from target_nav.state.types import Pose2D
from tests.unit.nav.views import view, wall

CONFIG = Config()
AHEAD = wall(0.25, -0.5, 0.25, 0.5)


def test_it_backs_off_from_where_it_was_going_and_stops_when_it_has() -> None:
    recovery = Recovery(CONFIG, 3)
    assert recovery.step(view()) is None
    recovery.start(view(10.0, obstacles=AHEAD), (1.0, 0.0))
    twist = recovery.step(view(10.1, obstacles=AHEAD))
    assert twist is not None
    assert twist.vx_mps == pytest.approx(-0.08)
    assert recovery.step(view(11.0, pose=Pose2D(-0.26))) is None
    assert recovery.step(view(11.1, pose=Pose2D(-0.26))) is None


def test_it_keeps_its_direction_in_odom_while_the_body_turns() -> None:
    recovery = Recovery(CONFIG, 3)
    recovery.start(view(10.0, obstacles=AHEAD), (1.0, 0.0))
    twist = recovery.step(view(10.5, pose=Pose2D(yaw_rad=math.pi / 2)))
    assert twist is not None
    assert (twist.vx_mps, twist.vy_mps) == pytest.approx((0.0, 0.08), abs=1e-9)


def test_it_gives_up_backing_off_after_a_while() -> None:
    recovery = Recovery(CONFIG, 3)
    recovery.start(view(10.0), (1.0, 0.0))
    assert recovery.step(view(13.1)) is None


def test_the_place_where_it_stuck_is_kept_off_for_a_while() -> None:
    recovery = Recovery(CONFIG, 3)
    recovery.start(view(10.0), (1.0, 0.0))
    shunned = recovery.shunned(view(11.0, pose=Pose2D(-0.2)))
    assert shunned[0] == pytest.approx([0.15 + 0.15 + 0.2, 0.0])
    assert len(recovery.shunned(view(30.0))) == 0


def test_without_a_way_there_is_no_place_to_keep_off() -> None:
    recovery = Recovery(CONFIG, 3)
    recovery.start(view(10.0), None)
    assert len(recovery.shunned(view(10.1))) == 0


def test_attempts_are_bounded() -> None:
    recovery = Recovery(CONFIG, 2)
    recovery.start(view(), None)
    assert not recovery.is_used_up
    recovery.start(view(), None)
    assert recovery.is_used_up
    recovery.begin()
    assert not recovery.is_used_up


def test_a_differential_base_backs_off_straight() -> None:
    recovery = Recovery(CONFIG.override({"robot.drive": "differential"}), 1)
    recovery.start(view(10.0, obstacles=AHEAD), (1.0, 0.3))
    twist = recovery.step(view(10.1))
    assert twist is not None
    assert twist.vy_mps == 0.0
    assert twist.vx_mps < 0.0

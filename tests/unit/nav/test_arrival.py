"""Arrived is what several signals say for some time; a wall, a wrong start or a poster alone will not do."""

from __future__ import annotations

from dataclasses import replace

import pytest

from target_nav.config import Config
from target_nav.nav.arrival import ConfirmArrival
from target_nav.nav.skill import SkillStatus, SkillStep, View
from target_nav.state.types import STOP, Detection, DetectionFrame, Pose2D, Track, Twist2D
from tests.unit.nav.toy_world import ToyWorld
from tests.unit.nav.views import ORIGIN, track_at, view

CONFIG = Config()
STAND_OFF_M, RADIUS_M = 0.10, 0.04
THERE_M = CONFIG.robot.front_m + STAND_OFF_M + RADIUS_M
DT = 0.05
BOX = Detection("bowling_pin", 0.9, 1, 320.0, 240.0, 255.0, 480.0, 0.3, 0.1, 0.0, 0.01, True, True)
FAR_BOX = replace(BOX, width_px=22.0, height_px=78.0, clipped=False, range_m=2.0)


def skill(config: Config = CONFIG) -> ConfirmArrival:
    return ConfirmArrival(
        config, stand_off_m=STAND_OFF_M, confirm_s=0.3, target_radius_m=RADIUS_M, timeout_s=2.0
    )


def seen(
    now_s: float,
    *,
    track: Track | None = None,
    box: Detection | None = None,
    twist: Twist2D = STOP,
    pose: Pose2D = ORIGIN,
) -> View:
    frame = DetectionFrame(now_s - 0.1, 1, (box,)) if box is not None else None
    return view(now_s, track=track, detections=frame, twist=twist, pose=pose)


def lidar_track(now_s: float, away_m: float = THERE_M, left_m: float = 0.0) -> Track:
    return track_at(away_m, left_m, now_s)


def run(views: list[View], config: Config = CONFIG) -> tuple[SkillStep, int]:
    """The last step, and after how many."""
    confirming = skill(config)
    confirming.start(views[0])
    for count, each in enumerate(views):
        step = confirming.step(each)
        assert step.twist == STOP
        if step.status is not SkillStatus.RUNNING:
            return step, count
    return step, len(views)


def times(seconds: float = 3.0) -> list[float]:
    return [100.0 + DT * i for i in range(round(seconds / DT))]


def test_lidar_odometry_and_camera_together_confirm_after_a_moment() -> None:
    step, count = run([seen(t, track=lidar_track(t), box=BOX) for t in times()])
    assert step.status is SkillStatus.SUCCESS
    assert count == pytest.approx(0.3 / DT, abs=1.01)
    assert "lidar, odometry, camera" in step.reason


def test_two_signals_will_do() -> None:
    step, _ = run([seen(t, track=lidar_track(t)) for t in times()])
    assert step.status is SkillStatus.SUCCESS
    assert "2 of 3" in step.reason


def test_a_box_alone_is_not_enough() -> None:
    step, _ = run([seen(t, box=BOX) for t in times()])
    assert step.status is SkillStatus.FAILURE
    assert "1 of 3 signals (camera)" in step.reason


def test_dead_reckoning_alone_is_not_enough() -> None:
    old = track_at(THERE_M, 0.0, 100.0, ranged_ago_s=30.0)
    step, _ = run([seen(t, track=old) for t in times()])
    assert step.status is SkillStatus.FAILURE
    assert "1 of 3 signals (odometry)" in step.reason


def test_a_lidar_range_alone_is_not_enough() -> None:
    first = seen(100.0)
    step, _ = run([first, *(seen(t, track=lidar_track(t)) for t in times()[1:])])
    assert step.status is SkillStatus.FAILURE
    assert "1 of 3 signals (lidar)" in step.reason


@pytest.mark.parametrize(
    ("away_m", "left_m"), [(THERE_M + 0.06, 0.0), (THERE_M - 0.06, 0.0), (0.9, 0.0), (0.25, 0.15)]
)
def test_in_the_wrong_place_nothing_agrees(away_m: float, left_m: float) -> None:
    step, _ = run([seen(t, track=lidar_track(t, away_m, left_m), box=FAR_BOX) for t in times()])
    assert step.status is SkillStatus.FAILURE
    assert "0 of 3" in step.reason
    assert "expected 0.29 m" in step.reason


def test_a_small_box_far_ahead_does_not_count_nor_one_aside() -> None:
    for box in (FAR_BOX, replace(BOX, bearing_rad=0.4)):
        step, _ = run([seen(t, box=box) for t in times()])
        assert "0 of 3" in step.reason


def test_while_it_moves_odometry_does_not_agree() -> None:
    old = track_at(THERE_M, 0.0, 100.0, ranged_ago_s=30.0)
    step, _ = run([seen(t, track=old, box=BOX, twist=Twist2D(0.05, 0.0, 0.0)) for t in times()])
    assert step.status is SkillStatus.FAILURE


def test_agreement_must_last() -> None:
    views = [seen(t, track=lidar_track(t), box=BOX if i % 4 else None) for i, t in enumerate(times())]
    flickering = [seen(t, track=lidar_track(t) if i % 4 else None, box=None) for i, t in enumerate(times())]
    assert run(views)[0].status is SkillStatus.SUCCESS
    assert run(flickering)[0].status is SkillStatus.FAILURE


def test_a_signal_at_its_limit_does_not_flicker() -> None:
    edge = CONFIG.arrival.range_tolerance_m
    views = [
        seen(t, track=lidar_track(t, THERE_M + edge + (0.004 if i % 2 else -0.004)))
        for i, t in enumerate(times())
    ]
    assert run(views)[0].status is SkillStatus.SUCCESS


def test_never_one_signal_whatever_is_configured() -> None:
    config = CONFIG.override({"arrival.min_signals": 1})
    step, _ = run([seen(t, box=BOX) for t in times()], config)
    assert step.status is SkillStatus.FAILURE


def test_three_can_be_asked_for() -> None:
    config = CONFIG.override({"arrival.min_signals": 3})
    step, _ = run([seen(t, track=lidar_track(t)) for t in times()], config)
    assert step.status is SkillStatus.FAILURE
    assert "3 needed" in step.reason


def test_in_front_of_a_pin_it_confirms() -> None:
    world = ToyWorld(pin=(THERE_M, 0.0), start=Pose2D(), seed=4)
    assert world.run(skill(), 3.0, near_target=True).status is SkillStatus.SUCCESS


def test_in_front_of_a_wall_it_does_not() -> None:
    world = ToyWorld([(THERE_M, -2.0, THERE_M, 2.0)], pin=None, start=Pose2D(), seed=4)
    assert world.run(skill(), 3.0, near_target=True).status is SkillStatus.FAILURE

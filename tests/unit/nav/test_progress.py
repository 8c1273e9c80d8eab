"""When nothing comes of the driving."""

from __future__ import annotations

import math

from target_nav.nav.progress import Progress
from target_nav.state.types import Pose2D


def test_driving_nearer_is_progress() -> None:
    progress = Progress(standing_s=2.0, no_nearer_s=5.0)
    assert all(not progress.stalled(t, Pose2D(0.1 * t), 5.0 - 0.1 * t) for t in range(40))


def test_standing_is_noticed() -> None:
    progress = Progress(standing_s=2.0, no_nearer_s=50.0)
    told = [progress.stalled(0.1 * i, Pose2D(), 1.0) for i in range(30)]
    assert told[15] == ""
    assert told[-1].startswith("stood for")


def test_turning_on_the_spot_is_not_standing() -> None:
    progress = Progress(standing_s=2.0, no_nearer_s=50.0)
    assert all(not progress.stalled(0.1 * i, Pose2D(yaw_rad=0.03 * i), 1.0) for i in range(100))


def test_going_to_and_fro_is_noticed() -> None:
    progress = Progress(standing_s=2.0, no_nearer_s=5.0)
    told = [progress.stalled(0.1 * i, Pose2D(0.3 * math.sin(0.1 * i)), 2.0) for i in range(60)]
    assert told[-1].startswith("no nearer for")


def test_finding_out_that_the_way_is_longer_begins_anew_a_few_times_only() -> None:
    def told(surprises: int) -> str:
        progress = Progress(standing_s=99.0, no_nearer_s=5.0)
        cost = 1.0
        said = ""
        for step in range(surprises * 40):
            if step % 40 == 39:
                cost += 0.6
            said = progress.stalled(0.1 * step, Pose2D(), cost)
        return said

    assert told(3) == ""
    assert told(8).startswith("no nearer for")


def test_no_way_at_all_is_no_progress() -> None:
    progress = Progress(standing_s=99.0, no_nearer_s=5.0)
    told = [progress.stalled(0.1 * i, Pose2D(), math.inf) for i in range(60)]
    assert told[-1].startswith("no nearer for")


def test_restart_begins_the_count_anew_but_not_that_of_the_surprises() -> None:
    progress = Progress(standing_s=2.0, no_nearer_s=5.0)
    progress.stalled(0.0, Pose2D(), 1.0)
    progress.restart()
    assert progress.stalled(10.0, Pose2D(), 1.0) == ""

    progress = Progress(standing_s=99.0, no_nearer_s=5.0)
    cost = 1.0
    said = ""
    for step in range(8 * 40):
        if step % 40 == 39:
            cost += 0.6
        if step == 100:
            progress.restart()
        said = progress.stalled(0.1 * step, Pose2D(), cost)
    assert said.startswith("no nearer for")

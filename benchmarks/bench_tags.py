"""Missions to an AprilTag: how squarely the robot ends before it, and what telling its two poses apart is worth.

Peers: the first pose of each picture taken for the true one, and the short way without a look at the face.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from shutil import copytree
from statistics import median
from tempfile import TemporaryDirectory

from benchmarks import OURS, Row
from target_nav.app.paths import mission_path
from target_nav.app.virtual import run_virtual, with_overrides
from target_nav.nav import tracker_candidate
from target_nav.nav.facing import FaceEstimate, FaceLook, FacingBelief
from target_nav.sim.arena import Arena, load_arena
from target_nav.state.types import Pose2D
from target_nav.utils.frames import wrap_angle

SEEDS = range(201, 231)
PIXEL_SEEDS = range(201, 211)
LIMIT_DEG, BEARING_LIMIT_DEG = 6.0, 3.0
FAR_M, FAR_ASIDE_DEG = 3.8, 8.0
"""Where the two poses are hardest to tell apart: far off and nearly from straight ahead."""
WORSE = 3.0
"""Noise of corners, of that of a clean picture."""


class FirstPose:
    """Takes the better fitting pose of the newest picture for the true one."""

    def __init__(self) -> None:
        self.estimate: FaceEstimate | None = None

    def add(self, looks: Sequence[FaceLook], camera_yaw_in_odom_rad: float) -> None:
        if looks:
            self.estimate = FaceEstimate(wrap_angle(looks[0].facing_rad + camera_yaw_in_odom_rad), 0.1)


def run() -> list[Row]:
    near = load_arena("tag_on_wall")
    worse = with_overrides(_from_afar(near), {"camera.noise_scale": WORSE})
    rows = []
    for task, arena, seeds, pixels in (
        ("40 deg aside, 2.6 m", near, SEEDS, False),
        ("the same, rendered pictures", near, PIXEL_SEEDS, True),
        (f"{FAR_ASIDE_DEG:g} deg aside, {FAR_M:g} m, corners {WORSE:g} times as noisy", worse, SEEDS, False),
    ):
        mission = mission_path("apriltag")
        rows += _rows(task, OURS, arena, mission, seeds, pixels)
        with _belief(FirstPose):
            rows += _rows(task, "first pose", arena, mission, seeds, pixels)
    with TemporaryDirectory() as folder:
        rows += _rows("40 deg aside, 2.6 m", "short way", near, _short_way(Path(folder)), SEEDS, False)
    return rows


def _from_afar(arena: Arena) -> Arena:
    tag = arena.target
    assert tag is not None
    way_rad = tag.yaw_rad + math.radians(FAR_ASIDE_DEG)
    start = Pose2D(
        tag.x_m + FAR_M * math.cos(way_rad), tag.y_m + FAR_M * math.sin(way_rad), way_rad + math.pi
    )
    bounds = arena.bounds._replace(x_min_m=arena.bounds.x_min_m - FAR_M)
    return replace(arena, robot=start, bounds=bounds)


def _short_way(folder: Path) -> Path:
    """The mission without `from="face"`."""
    shipped = mission_path("apriltag")
    copytree(shipped.parent / "subtrees", folder / "subtrees")
    text = shipped.read_text(encoding="utf-8")
    assert ' from="face"' in text
    (folder / "short.xml").write_text(text.replace(' from="face"', ""), encoding="utf-8")
    return folder / "short.xml"


@contextmanager
def _belief(of: Callable[[], object]) -> Iterator[None]:
    vars(tracker_candidate)["FacingBelief"] = of
    try:
        yield
    finally:
        vars(tracker_candidate)["FacingBelief"] = FacingBelief


def _rows(task: str, name: str, arena: Arena, mission: Path, seeds: range, pixels: bool) -> list[Row]:
    tag = arena.target
    assert tag is not None
    offs, bearings, right = [], [], 0
    for seed in seeds:
        result = run_virtual(arena, mission, seed, pixels=pixels)
        assert result.bearing_error_rad is not None
        offs.append(math.degrees(abs(wrap_angle(result.trace[-1][3] - tag.yaw_rad - math.pi))))
        bearings.append(math.degrees(abs(result.bearing_error_rad)))
        right += (
            result.as_expected
            and not result.collided
            and offs[-1] <= LIMIT_DEG
            and bearings[-1] <= BEARING_LIMIT_DEG
        )
    return [
        Row(
            f"{task}: off square, largest", name, max(offs), "deg",
            f"median {median(offs):.1f}; bearing at most {max(bearings):.1f} deg; {right} of {len(seeds)} "
            f"arrived within {LIMIT_DEG:g} and {BEARING_LIMIT_DEG:g} deg",
        )
    ]  # fmt: skip

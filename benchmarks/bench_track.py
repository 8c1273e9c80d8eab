"""Is the track right, and does it know how wrong it is? Against the truth of the simulator, over generated arenas.

- Whole missions in generated arenas: error of range and bearing while the LiDAR has it, and ANEES, the average
  normalised estimation error squared, over the runs at the same time since the track was confirmed (Bar-Shalom, Li and
  Kirubarajan, "Estimation with Applications to Tracking and Navigation", 2001, section 5.4). Ticks of one run share
  their camera's constant errors, so runs are counted, not ticks.
- Camera alone: the robot stands, the LiDAR is off, and the error is that after one second of frames.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2

from benchmarks import OURS, Row
from target_nav.app.nav_core import NavCore
from target_nav.app.paths import mission_path
from target_nav.app.virtual import SimIo
from target_nav.config import Config
from target_nav.hardware import protocol
from target_nav.mission import load_mission
from target_nav.nav.poses import PoseHistory
from target_nav.nav.tracker import TargetTracker
from target_nav.sim.arena import load_arena
from target_nav.sim.arena_types import Arena
from target_nav.sim.generator import GeneratedName
from target_nav.sim.simulation import Simulation
from target_nav.state.snapshots import NavSnapshot
from target_nav.state.types import STOP, Inputs, Pose2D, TargetSpec, TickRecord
from target_nav.utils.frames import to_child, wrap_angle

SEED, ARENAS = 107700, 24
"""Not a seed that anything was tuned on."""
STANDING_RUNS = 60
TICK_S = 0.05
SAMPLE_S = 0.5
MOST_S = 20.0
FALSE_M = 0.6
"""A track this far from the pin is of something else: counted, not averaged."""
RANGED_S = 0.5


@dataclass(frozen=True)
class Sample:
    """One look at a confirmed track. Errors are the track's less the truth's, in base_link."""

    since_s: float
    range_m: float
    range_error_m: float
    bearing_error_rad: float
    nees: float
    ranged: bool
    is_false: bool


class WatchedIo(SimIo):
    """Remembers the pose that the nav loop went by."""

    pose_in_odom = Pose2D()

    def publish(self, snapshot: NavSnapshot, inputs: Inputs) -> None:
        self.pose_in_odom = snapshot.pose_in_odom
        super().publish(snapshot, inputs)


def run() -> list[Row]:
    runs = [
        list(samples_of(load_arena(str(GeneratedName(SEED, number))), SEED + number))
        for number in range(ARENAS)
    ]
    runs = [samples for samples in runs if samples]
    return [*mission_rows(runs), *nees_rows(runs), *camera_rows()]


def samples_of(arena: Arena, seed: int) -> Iterator[Sample]:
    """The track of one mission, every half second from when it was confirmed."""
    if arena.target is None:
        return
    simulation = Simulation(arena, seed)
    io = WatchedIo(simulation, arena.config)
    core = NavCore(arena.config, load_mission(mission_path("bowling_pin")).root, io, io)
    try:
        since_s: float | None = None
        next_s = 0.0
        for tick in range(1, int(arena.time_limit_s / TICK_S)):
            now_s = tick * TICK_S
            record = core.tick(now_s)
            if record.outcome is not None:
                return
            if record.track is None or not record.track.confirmed:
                since_s = None
                continue
            if since_s is None:
                since_s, next_s = now_s, now_s
            if now_s >= next_s - 1e-9:
                next_s += SAMPLE_S
                yield sample(record, simulation, arena, io, now_s - since_s)
    finally:
        core.close()


def sample(record: TickRecord, simulation: Simulation, arena: Arena, io: WatchedIo, since_s: float) -> Sample:
    track, target = record.track, arena.target
    assert track is not None
    assert target is not None
    true_x, true_y = to_child(simulation.true_pose, target.x_m, target.y_m)
    x, y = track.range_m * math.cos(track.bearing_rad), track.range_m * math.sin(track.bearing_rad)
    pose = io.pose_in_odom
    in_odom = (track.x_m - pose.x_m, track.y_m - pose.y_m)
    yaw_rad = math.atan2(in_odom[1], in_odom[0]) - track.bearing_rad
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)
    turn = np.array([[c, s], [-s, c]])
    covariance = turn @ np.array(track.covariance_m2).reshape(2, 2) @ turn.T
    error = np.array([x - true_x, y - true_y])
    true_range_m = math.hypot(true_x, true_y)
    return Sample(
        since_s,
        true_range_m,
        track.range_m - true_range_m,
        wrap_angle(track.bearing_rad - math.atan2(true_y, true_x)),
        float(error @ np.linalg.solve(covariance, error)),
        record.now_s - track.last_ranged_s <= RANGED_S,
        float(np.hypot(*error)) > max(FALSE_M, 0.2 * true_range_m),
    )


def mission_rows(runs: list[list[Sample]]) -> list[Row]:
    every = [each for samples in runs for each in samples]
    good = [each for each in every if not each.is_false]
    ranged = [each for each in good if each.ranged]
    note = f"{len(runs)} runs, generator's seed {SEED}"
    return [
        Row(
            "with LiDAR: error of range, rms", OURS, 1e3 * rms([e.range_error_m for e in ranged]), "mm", note
        ),
        Row("with LiDAR: error of range, p95", OURS, 1e3 * p95([e.range_error_m for e in ranged]), "mm"),
        Row(
            "with LiDAR: error of bearing, rms",
            OURS,
            math.degrees(rms([e.bearing_error_rad for e in ranged])),
            "deg",
        ),
        Row("share of the time on something else", OURS, 100.0 * (1.0 - len(good) / len(every)), "%"),
    ]


def nees_rows(runs: list[list[Sample]]) -> list[Row]:
    by_time: dict[int, list[float]] = defaultdict(list)
    for samples in runs:
        for each in samples:
            if not each.is_false and each.since_s <= MOST_S:
                by_time[round(each.since_s / SAMPLE_S)].append(each.nees)
    inside = means = 0
    for values in by_time.values():
        if len(values) >= 10:
            low, high = (chi2.ppf(q, 2 * len(values)) / len(values) for q in (0.025, 0.975))
            means += 1
            inside += int(low <= float(np.mean(values)) <= high)
    everything = [value for values in by_time.values() for value in values]
    whole_runs = [float(np.mean([e.nees for e in samples if not e.is_false] or [2.0])) for samples in runs]
    low, high = (chi2.ppf(q, 2 * len(runs)) / len(runs) for q in (0.025, 0.975))
    return [
        Row(
            "ANEES over all (2 is honest)",
            OURS,
            float(np.mean(whole_runs)),
            "1",
            f"95 % band {low:.2f} ... {high:.2f}",
        ),
        Row(
            "ANEES by time: inside the 95 % band", OURS, 100.0 * inside / max(means, 1), "%", f"{means} times"
        ),
        Row(
            "samples within their own 95 % ellipse",
            OURS,
            100.0 * float((np.array(everything) <= chi2.ppf(0.95, 2)).mean()),
            "%",
        ),
    ]


def camera_rows() -> list[Row]:
    rows = []
    for range_m in (1.0, 2.0, 3.0, 3.8):
        errors = np.array(
            [error for seed in range(STANDING_RUNS) if (error := standing(range_m, seed)) is not None]
        )
        task = f"camera alone, 1 s, {range_m:g} m"
        rows += [
            Row(
                f"{task}: range, 1 sigma",
                OURS,
                100.0 * rms(errors[:, 0] / range_m),
                "%",
                f"{len(errors)} runs",
            ),
            Row(f"{task}: bearing, 1 sigma", OURS, math.degrees(rms(errors[:, 1])), "deg"),
        ]
    return rows


def standing(range_m: float, seed: int) -> tuple[float, float] | None:
    """Errors of range and bearing one second after the first frame, the LiDAR off."""
    arena = load_arena("open_floor")
    assert arena.target is not None
    x_m, y_m, yaw_rad = arena.robot.x_m, arena.robot.y_m, 0.0
    bearing_rad = math.radians(-15.0 + 30.0 * (seed % 7) / 6.0)
    target = replace(
        arena.target, x_m=x_m + range_m * math.cos(bearing_rad), y_m=y_m + range_m * math.sin(bearing_rad)
    )
    arena = replace(arena, target=target, robot=replace(arena.robot, yaw_rad=yaw_rad), config=Config())
    simulation = Simulation(arena, 7000 + seed)
    io = SimIo(simulation, arena.config)
    tracker, poses = TargetTracker(arena.config), PoseHistory()
    first_s: float | None = None
    for tick in range(1, 60):
        now_s = tick * TICK_S
        inputs = io.read(now_s)
        simulation.serial_write(protocol.encode_velocity(STOP))
        for odometry in inputs.odometry_since:
            poses.add(odometry)
        track = tracker.update(now_s, poses, TargetSpec(), inputs.detections, None)
        if track is not None and first_s is None:
            first_s = now_s
        if track is not None and first_s is not None and now_s - first_s >= 1.0:
            true_x, true_y = to_child(simulation.true_pose, target.x_m, target.y_m)
            return track.range_m - math.hypot(true_x, true_y), wrap_angle(
                track.bearing_rad - math.atan2(true_y, true_x)
            )
    return None


def rms(values: object) -> float:
    return float(np.sqrt(np.mean(np.square(np.asarray(values, dtype=np.float64)))))


def p95(values: object) -> float:
    return float(np.percentile(np.abs(np.asarray(values, dtype=np.float64)), 95.0))

"""A recording as the same view models that a live stack gives: one tick is one look at a world that was.

What a recording does not hold (pictures, the loop's timing, the track's covariance) is told as not there.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from target_nav.config import Config
from target_nav.gui.plain import to_plain
from target_nav.gui.source import NAV_MAX_AGE_S, Link, World
from target_nav.gui.view_arrival import arrival_view
from target_nav.gui.view_camera import camera_view
from target_nav.gui.view_radar import radar_view
from target_nav.gui.view_status import status_view
from target_nav.gui.view_tree import tree_view
from target_nav.state.snapshots import LaserSnapshot, NavSnapshot, NodeStatus, TreeRow, TreeState
from target_nav.state.types import (
    FloatArray,
    Inputs,
    NavState,
    Outcome,
    OutcomeKind,
    Pose2D,
    Scan,
    TargetSpec,
    Track,
    Twist2D,
)
from target_nav.utils.frames import points_to_parent, to_child
from target_nav.web.encode import camera_section, dumps, joined, radar_section, tree_section
from target_nav.web.timeline import Mark

PERIOD_S = 0.095
"""Ten frames a second are kept, and every tick in which another leaf or state begins."""
NOT_RECORDED = "not in a recording"


@dataclass(frozen=True)
class TreeNode:
    """A behaviour of the recorded mission. `path` is the key of its status."""

    path: str
    name: str
    word: str
    depth: int


@dataclass(frozen=True)
class RecordedFrame:
    """`stamp_s` of the mark counts from the first tick."""

    mark: Mark
    pose: Pose2D
    text: str


def nodes_of_paths(paths: Iterable[str]) -> list[TreeNode]:
    """What can be told of a tree by the statuses alone: for a mission that cannot be loaded any more."""
    return [TreeNode(path, path.rsplit("/", 1)[-1], "", path.count("/") - 1) for path in sorted(set(paths))]


def frames(
    config: Config,
    mission: str,
    nodes: Sequence[TreeNode],
    spec: TargetSpec,
    ticks: Iterable[tuple[Inputs, Mapping[str, Any]]],
) -> Iterator[RecordedFrame]:
    """The frames of a run, in order."""
    begin_s, kept_s, kept_key = math.nan, -math.inf, ("", "")
    pose, laser = Pose2D(), _Laser(config)
    for number, (inputs, decision) in enumerate(ticks):
        now_s = inputs.now_s
        if number == 0:
            begin_s = now_s
        if inputs.odometry is not None:
            pose = inputs.odometry.pose_in_odom
        key = (str(decision["state"]), str(decision["leaf"]))
        if now_s - kept_s < PERIOD_S and key == kept_key:
            continue
        kept_s, kept_key = now_s, key
        nav = _nav(number, mission, spec, pose, inputs, decision)
        world = World(
            now_s,
            nav=Link("nav", nav, 0.0, NAV_MAX_AGE_S, True),
            laser=_link("laser", laser.of(inputs.scan, pose), now_s, config.loop.scan_max_age_s),
            avoid=Link("avoid", None, math.inf, 1.0, False, NOT_RECORDED),
            tree=Link("tree", _tree(number, now_s, nodes, decision["statuses"]), 0.0, 1.0, True),
            det=_link("det", inputs.detections, now_s, config.loop.camera_max_age_s),
            camera=Link("camera", None, math.inf, 1.0, False, NOT_RECORDED),
            processes=Link("processes", None, math.inf, 1.0, False, NOT_RECORDED),
        )
        yield RecordedFrame(_mark(world, config, now_s - begin_s), pose, _text(world, config, pose))


def _text(world: World, config: Config, pose: Pose2D) -> str:
    camera = config.camera
    sections = {
        "pose": dumps(to_plain(pose)),
        "status": dumps(to_plain(status_view(world, config))),
        "arrival": dumps(to_plain(arrival_view(world, config))),
        "camera": camera_section(camera_view(world, camera.width_px, camera.height_px)),
        "radar": radar_section(radar_view(world, config.robot)),
        "tree": tree_section(tree_view(world)),
    }
    return f"{{{joined(sections)}}}"


def _mark(world: World, config: Config, at_s: float) -> Mark:
    nav = world.nav.value
    assert nav is not None, "made of every tick"
    loop = config.loop
    stale = not (nav.scan_age_s <= loop.scan_max_age_s and nav.odom_age_s <= loop.odom_max_age_s)
    return Mark(at_s, nav.state.name, nav.running_leaf, stale)


def _nav(
    tick: int, mission: str, spec: TargetSpec, pose: Pose2D, inputs: Inputs, decision: Mapping[str, Any]
) -> NavSnapshot:
    outcome = None
    if decision.get("outcome"):
        outcome = Outcome(OutcomeKind(decision["outcome"]), str(decision.get("reason", "")))
    return NavSnapshot(
        stamp_s=inputs.now_s,
        tick=tick,
        state=NavState[decision["state"]],
        outcome=outcome,
        running_leaf=str(decision["leaf"]),
        reason=str(decision.get("reason", "")),
        requested=decision["state"] != NavState.IDLE.name,
        pose_in_odom=pose,
        twist_sent=Twist2D(*decision["sent"]),
        limited_by=str(decision.get("limited_by", "")),
        track=_track(inputs.now_s, pose, decision.get("track")),
        spec=spec,
        scan_age_s=_age_s(inputs.now_s, inputs.scan),
        odom_age_s=_age_s(inputs.now_s, inputs.odometry),
        camera_age_s=_age_s(inputs.now_s, inputs.detections),
        rate_hz=0.0,
        jitter_p99_s=0.0,
        overruns=0,
        mission=mission,
    )


def _track(now_s: float, pose: Pose2D, recorded: Sequence[Any] | None) -> Track | None:
    if not recorded:
        return None
    x_m, y_m, confirmed = recorded
    ahead_m, left_m = to_child(pose, x_m, y_m)
    return Track(
        stamp_s=now_s,
        x_m=x_m,
        y_m=y_m,
        covariance_m2=(0.0, 0.0, 0.0, 0.0),
        confirmed=bool(confirmed),
        hits=0,
        last_seen_s=-math.inf,
        last_ranged_s=-math.inf,
        range_m=math.hypot(ahead_m, left_m),
        bearing_rad=math.atan2(left_m, ahead_m),
    )


def _tree(tick: int, now_s: float, nodes: Sequence[TreeNode], statuses: Mapping[str, str]) -> TreeState:
    rows = tuple(
        TreeRow(
            node.name,
            node.word,
            node.depth,
            NodeStatus[statuses.get(node.path, NodeStatus.INVALID.name)],
            node.path in statuses,
            "",
        )
        for node in nodes
    )
    return TreeState(now_s, tick, len(rows), rows)


class _Laser:
    """Scans as points of base_link, each turned once, with the pose of the tick in which it came."""

    def __init__(self, config: Config) -> None:
        lidar = config.lidar
        self._mount = Pose2D(lidar.x_m, lidar.y_m, lidar.yaw_rad)
        self._scan: Scan | None = None
        self._snapshot: LaserSnapshot | None = None

    def of(self, scan: Scan | None, pose: Pose2D) -> LaserSnapshot | None:
        if scan is not self._scan and scan is not None:
            self._scan = scan
            self._snapshot = LaserSnapshot(scan.stamp_s, pose, points_to_parent(self._mount, _points(scan)))
        return self._snapshot


def _points(scan: Scan) -> FloatArray:
    ranges = scan.ranges_m
    good = np.isfinite(ranges) & (ranges >= scan.range_min_m) & (ranges <= scan.range_max_m)
    index = np.flatnonzero(good)
    angles = scan.angle_min_rad + index * scan.angle_increment_rad
    return ranges[index, None] * np.column_stack((np.cos(angles), np.sin(angles)))


def _link(name: str, value: Any, now_s: float, limit_s: float) -> Link[Any]:
    return Link(name, value, _age_s(now_s, value), limit_s, value is not None)


def _age_s(now_s: float, value: Any) -> float:
    return math.inf if value is None else now_s - value.stamp_s

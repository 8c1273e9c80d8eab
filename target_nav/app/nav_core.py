"""The nav loop's tick: six named calls, in this order, with no idea of ROS, shared memory or real time.

The robot, the simulator in virtual time and a replayed recording differ only in what is handed in as `InputSource`,
`OutputSink` and `Recorder`.
"""

from __future__ import annotations

import logging
import math
from dataclasses import dataclass
from typing import Protocol

import py_trees
from py_trees.common import Status

from target_nav.app.avoid_picture import avoid_snapshot
from target_nav.app.operator_desk import OperatorDesk
from target_nav.app.tree_probe import TreeProbe
from target_nav.app.world_board import WorldBoard
from target_nav.config import Config
from target_nav.nav.limiter import Limited, VelocityLimiter
from target_nav.nav.manual_drive import OWNER as MANUAL_OWNER
from target_nav.nav.obstacles import ObstacleMemory
from target_nav.nav.poses import PoseHistory
from target_nav.nav.tracker import TargetTracker
from target_nav.nav.visited import VISITED_RADIUS_M, without_visited
from target_nav.state import keys
from target_nav.state.dispatcher import CommandDispatcher
from target_nav.state.snapshots import AvoidSnapshot, NavSnapshot
from target_nav.state.types import (
    STOP,
    Command,
    CommandKind,
    Inputs,
    MotionRequest,
    NavState,
    Outcome,
    OutcomeKind,
    Pose2D,
    TargetSpec,
    TickRecord,
    Track,
)
from target_nav.utils.frames import to_child

log = logging.getLogger(__name__)

MAX_DT_S = 0.25
"""A longer gap between two ticks (a suspended process) is treated as this long, so that ramps do not jump."""


@dataclass(frozen=True)
class LoopStatistics:
    """How well the loop keeps its time; zeros in virtual time."""

    rate_hz: float = 0.0
    jitter_p50_s: float = 0.0
    jitter_p99_s: float = 0.0
    overruns: int = 0


class InputSource(Protocol):
    def read(self, now_s: float) -> Inputs: ...


class OutputSink(Protocol):
    def publish(self, snapshot: NavSnapshot, inputs: Inputs) -> None: ...

    def reset_odometry(self) -> None: ...


class Recorder(Protocol):
    def record(self, inputs: Inputs, record: TickRecord) -> None: ...


class NavCore:
    """Owns the tree and everything that lives from one tick to the next."""

    def __init__(
        self,
        config: Config,
        root: py_trees.behaviour.Behaviour,
        source: InputSource,
        sink: OutputSink,
        recorder: Recorder | None = None,
    ) -> None:
        self.config = config
        self.root = root
        self.probe = TreeProbe(root)
        self._source, self._sink, self._recorder = source, sink, recorder
        self._board = WorldBoard()
        self._board.write(keys.CONFIG, config)
        self._board.write(keys.SPEC, TargetSpec())
        self._poses = PoseHistory()
        self._camera_in_base = Pose2D(config.camera.x_m, config.camera.y_m, config.camera.yaw_rad)
        self._obstacles = ObstacleMemory(config)
        self._tracker = TargetTracker(config)
        self._limiter = VelocityLimiter(config)
        self._commands = CommandDispatcher(
            {
                CommandKind.GO: self._go,
                CommandKind.STOP: self._stop,
                CommandKind.RESET_ODOM: self._reset_odometry,
                CommandKind.PAUSE: self._pause,
                CommandKind.RESUME: self._resume,
                CommandKind.STEP: self._step,
                CommandKind.RELOAD: self._reload,
                CommandKind.MANUAL: self._by_operator,
                CommandKind.SETTING: self._by_operator,
                CommandKind.LOAD: self._by_operator,
                CommandKind.TARGET: self._by_operator,
                CommandKind.FIRMWARE: self._by_operator,
            }
        )
        self._requested = False
        self.held = False
        """A debugger holds the tree: it is not ticked, and the robot stands."""
        self._paused = False
        self._single_step = False
        self._reload_asked = False
        self.operator = OperatorDesk(
            config, self._board, lambda: self._requested, self._configure, self._begin_anew
        )
        self.mission_name = ""
        """For people; whoever loads a mission says it."""
        self._finished: Outcome | None = None
        self._last_now_s: float | None = None
        self._dt_s = 1.0 / config.loop.rate_hz
        self._pose = Pose2D()
        self._twist = STOP
        self._track: Track | None = None
        self._tick = 0

    def tick(self, now_s: float, loop: LoopStatistics = LoopStatistics()) -> TickRecord:
        inputs = self._read_inputs(now_s)
        self._update_track(inputs)
        self._tick_tree(inputs.now_s)
        limited = self._limit_velocity(inputs)
        record = self._publish(inputs, limited, loop)
        self._record(inputs, record)
        return record

    def replace_tree(self, root: py_trees.behaviour.Behaviour) -> None:
        """Halt the tree and tick another one from now on. It waits for GO: a new mission never moves by itself."""
        self.root.stop(Status.INVALID)
        self.root, self.probe = root, TreeProbe(root)
        self._requested, self._finished = False, None

    def take_reload(self) -> bool:
        """Whether RELOAD was said since the last call."""
        asked, self._reload_asked = self._reload_asked, False
        return asked

    def avoidance(self) -> AvoidSnapshot:
        """What VFH saw and chose in the last tick, for a screen."""
        request: MotionRequest | None = self._board.read(keys.REQUEST)
        return avoid_snapshot(
            self._last_now_s or 0.0,
            self._pose,
            request.avoidance if request is not None else None,
            self._board.read(keys.OBSTACLES),
        )

    def close(self) -> None:
        """Halt the tree and send zero."""
        self.root.stop(Status.INVALID)
        self._board.close()

    # -- the six calls -----------------------------------------------------------------------------------------------

    def _read_inputs(self, now_s: float) -> Inputs:
        if self._last_now_s is not None:
            self._dt_s = min(max(now_s - self._last_now_s, 0.0), MAX_DT_S)
        self._last_now_s = now_s
        inputs = self._source.read(now_s)
        for odometry in inputs.odometry_since:
            self._poses.add(odometry)
        self._commands.dispatch(inputs.commands)
        self._pose = self._poses.predict(now_s) or self._pose
        latest = self._poses.latest
        self._twist = latest.twist_in_base if latest is not None else STOP

        write = self._board.write
        write(keys.NOW_S, now_s)
        write(keys.DT_S, self._dt_s)
        write(keys.REQUESTED, self._requested)
        write(keys.SCAN_AGE_S, _age_s(now_s, inputs.scan))
        write(keys.ODOM_AGE_S, _age_s(now_s, inputs.odometry))
        write(keys.CAMERA_AGE_S, _age_s(now_s, inputs.detections))
        write(keys.POSE, self._pose)
        write(keys.TWIST, self._twist)
        write(keys.DETECTIONS, inputs.detections)
        return inputs

    def _update_track(self, inputs: Inputs) -> None:
        spec, visited = self._board.read(keys.SPEC), self._board.read(keys.VISITED) or ()
        self._obstacles.update(inputs.now_s, self._poses, inputs.scan)
        self._tracker.forget_near(visited, VISITED_RADIUS_M)
        detections = without_visited(inputs.detections, self._poses, self._camera_in_base, visited)
        self._track = self._tracker.update(inputs.now_s, self._poses, spec, detections, inputs.scan)
        self._board.write(keys.TRACK, self._track)
        self._board.write(keys.OBSTACLES, self._obstacles.points_in_base(self._pose, self._track, spec))

    def _tick_tree(self, now_s: float) -> None:
        if self._hand_drives:
            # a leaf that does not ask again must not inherit what a hand asked for
            self._board.write(keys.REQUEST, None)
        if self.held or (self._paused and not self._single_step) or self._finished is not None:
            self._board.write(keys.REQUEST, None)
        else:
            self._single_step = False
            self._tick_mission()
        by_hand = None if self._requested or self.held else self.operator.manual.request(now_s)
        if by_hand is not None:
            self._board.write(keys.REQUEST, by_hand)

    @property
    def _hand_drives(self) -> bool:
        request = self._board.read(keys.REQUEST)
        return request is not None and request.owner == MANUAL_OWNER

    def _tick_mission(self) -> None:
        self.root.tick_once()
        self._tick += 1
        if self.root.status in (Status.SUCCESS, Status.FAILURE):
            kind = OutcomeKind.SUCCEEDED if self.root.status is Status.SUCCESS else OutcomeKind.FAILED
            tip = self.root.tip()
            self._finished = Outcome(kind, (tip.feedback_message or tip.name) if tip is not None else "")

    def _limit_velocity(self, inputs: Inputs) -> Limited:
        track = self._track
        return self._limiter.limit(
            self._board.read(keys.REQUEST),
            dt_s=self._dt_s,
            scan_age_s=self._board.read(keys.SCAN_AGE_S),
            odom_age_s=self._board.read(keys.ODOM_AGE_S),
            camera_age_s=self._board.read(keys.CAMERA_AGE_S),
            obstacles_in_base_m=self._board.read(keys.OBSTACLES),
            target_in_base=to_child(self._pose, track.x_m, track.y_m) if track is not None else None,
            measured=self._twist,
        )

    def _publish(self, inputs: Inputs, limited: Limited, loop: LoopStatistics) -> TickRecord:
        request: MotionRequest | None = self._board.read(keys.REQUEST)
        outcome = self._board.read(keys.OUTCOME) or self._finished
        record = TickRecord(
            now_s=inputs.now_s,
            state=request.state if request is not None else NavState.IDLE,
            running_leaf=self.probe.running_leaf(),
            requested=request.twist if request is not None else STOP,
            sent=limited.twist,
            limited_by=limited.limited_by,
            track=self._track,
            outcome=outcome,
            reason=request.reason if request is not None else "",
            root_status=self.root.status.name,
            statuses=self.probe.statuses(),
        )
        self._sink.publish(self._snapshot(inputs, record, loop), inputs)
        return record

    def _record(self, inputs: Inputs, record: TickRecord) -> None:
        if self._recorder is not None:
            self._recorder.record(inputs, record)

    # -- commands ----------------------------------------------------------------------------------------------------

    def _go(self, command: Command) -> None:
        if self._finished is not None or self._board.read(keys.OUTCOME) is not None:
            # GO after an end begins anew
            self.root.stop(Status.INVALID)
            self._finished, self._requested = None, False
        if not self._requested:
            self._forget_places()
        self._requested, self._paused = True, False
        self.operator.end_by_hand()
        log.info("GO")

    def _stop(self, command: Command) -> None:
        self._requested, self._paused, self._finished = False, False, None
        self.operator.end_by_hand()
        log.info("STOP")

    def _reset_odometry(self, command: Command) -> None:
        self._sink.reset_odometry()
        self._poses.clear()
        self._tracker.reset()
        self._obstacles.clear()
        self._forget_places()
        log.info("odometry reset")

    def _forget_places(self) -> None:
        """What the mission has remembered of the floor, in odom."""
        self._board.write(keys.VISITED, None)
        self._board.write(keys.SEARCH, None)

    def _pause(self, command: Command) -> None:
        self._paused = True
        log.info("paused")

    def _resume(self, command: Command) -> None:
        self._paused = False
        log.info("resumed")

    def _step(self, command: Command) -> None:
        self._paused = self._single_step = True
        log.info("single step")

    def _reload(self, command: Command) -> None:
        self._reload_asked = True

    def _by_operator(self, command: Command) -> None:
        self.operator.obey(command)

    def _begin_anew(self) -> None:
        """The mission from its beginning, for what it did there (SetTarget) may come out otherwise now."""
        self.root.stop(Status.INVALID)
        self._finished = None
        self._tracker.reset()

    def _configure(self, config: Config) -> None:
        self.config = config
        self._board.write(keys.CONFIG, config)
        self._limiter.configure(config)

    # ----------------------------------------------------------------------------------------------------------------

    def _snapshot(self, inputs: Inputs, record: TickRecord, loop: LoopStatistics) -> NavSnapshot:
        return NavSnapshot(
            stamp_s=inputs.now_s,
            tick=self._tick,
            state=record.state,
            outcome=record.outcome,
            running_leaf=record.running_leaf,
            reason="held by a debugger" if self.held else "paused" if self._paused else record.reason,
            requested=self._requested,
            pose_in_odom=self._pose,
            twist_sent=record.sent,
            limited_by=record.limited_by,
            track=record.track,
            spec=self._board.read(keys.SPEC),
            scan_age_s=self._board.read(keys.SCAN_AGE_S),
            odom_age_s=self._board.read(keys.ODOM_AGE_S),
            camera_age_s=self._board.read(keys.CAMERA_AGE_S),
            rate_hz=loop.rate_hz,
            jitter_p99_s=loop.jitter_p99_s,
            overruns=loop.overruns,
            mission=self.mission_name,
            paused=self._paused or self.held,
            manual=self._hand_drives,
            settings_crc=self.operator.settings_crc,
            notice=self.operator.notice,
            notice_count=self.operator.notice_count,
        )


class _Stamped(Protocol):
    @property
    def stamp_s(self) -> float: ...


def _age_s(now_s: float, value: _Stamped | None) -> float:
    """Age of a value; infinite when there is none or its stamp is not a number."""
    if value is None or not math.isfinite(value.stamp_s):
        return math.inf
    return now_s - value.stamp_s

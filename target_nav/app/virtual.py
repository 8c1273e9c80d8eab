"""A whole mission in virtual time, in one process: the robot's own algorithms and tree against the simulator.

Everything between the wheels and the blackboard is what the robot runs: commands go out as the firmware's lines,
odometry comes back as lines and is integrated, boxes go through the camera process's pipeline. Only processes, DDS and
shared memory are left out. The same seed gives the same result to the byte.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from behaviours.approach import stand_off_of
from target_nav.app.nav_core import NavCore, Recorder
from target_nav.config import Config
from target_nav.detectors.detector import Detector
from target_nav.detectors.pipeline import DetectionPipeline
from target_nav.hardware import protocol
from target_nav.mission import load_mission
from target_nav.nav.odometry import OdometryIntegrator, OdometryScale
from target_nav.sim.arena import Arena
from target_nav.sim.pixels import ImageBgr
from target_nav.sim.simulation import Simulation
from target_nav.state.snapshots import NavSnapshot
from target_nav.state.types import (
    Command,
    CommandKind,
    DetectionFrame,
    Inputs,
    NavState,
    Odometry,
    OutcomeKind,
    RawDetection,
    Scan,
    TargetSpec,
    TickRecord,
)

SERIAL_POLL_S = 0.01
"""How often virtual time looks at the serial line: the resolution of odometry's stamps."""

SETTLE_S = 1.0
"""After the mission's outcome the run goes on so long, to see whether the robot really stays where it is."""


class SimIo:
    """Nav core's inputs and outputs, from and to a simulation. Sends GO with the first tick."""

    def __init__(self, simulation: Simulation, config: Config, eye: _Eye | None = None) -> None:
        self._simulation = simulation
        self._eye = eye
        self._lines = protocol.LineAssembler()
        calibration = config.odometry
        self._odometry = OdometryIntegrator(
            OdometryScale(calibration.forward_scale, calibration.lateral_scale, calibration.yaw_scale),
            calibration.max_gap_s,
        )
        self._pipeline = DetectionPipeline(config)
        self._spec = TargetSpec()
        self._scan: Scan | None = None
        self._detections: DetectionFrame | None = None
        self._latest: Odometry | None = None
        self._time_s = 0.0
        self._commands: tuple[Command, ...] = (Command(0.0, CommandKind.GO),)

    def read(self, now_s: float) -> Inputs:
        since: list[Odometry] = []
        while self._time_s < now_s - 1e-9:
            self._time_s = min(self._time_s + SERIAL_POLL_S, now_s)
            self._simulation.step_to(self._time_s)
            for line in self._lines.feed(self._simulation.serial_read()):
                message = protocol.parse_line(line)
                if isinstance(message, protocol.OdomLine):
                    odometry = self._odometry.add(self._time_s, message.to_twist(), message.device_us)
                    if odometry is not None:
                        since.append(odometry)
        if since:
            self._latest = since[-1]
        for scan in self._simulation.take_scans():
            self._scan = scan
        for boxes in self._simulation.take_boxes():
            self._detections = self._pipeline.process(boxes, self._spec)
        commands, self._commands = self._commands, ()
        return Inputs(now_s, self._scan, self._latest, tuple(since), self._detections, commands)

    def publish(self, snapshot: NavSnapshot, inputs: Inputs) -> None:
        self._spec = snapshot.spec
        if self._eye is not None:
            self._eye.look_for(self._spec.class_name)
        self._simulation.serial_write(protocol.encode_velocity(snapshot.twist_sent))

    def reset_odometry(self) -> None:
        self._odometry.reset()


@dataclass(frozen=True)
class RunResult:
    """One run, with the names of a campaign's JSON line first and what a person asks next after them."""

    arena: str
    seed: int
    mission: str
    success: bool
    collided: bool
    timeout: bool
    time_s: float
    path_m: float
    stop_error_m: float | None
    bearing_error_rad: float | None
    min_clearance_m: float
    states: tuple[str, ...]
    outcome: str
    reason: str
    as_expected: bool
    kind: str = ""
    level: int = 0
    state_changes: tuple[tuple[float, NavState], ...] = field(default=(), repr=False)
    trace: tuple[tuple[float, float, float, float], ...] = field(default=(), repr=False)

    def as_json(self, with_trace: bool = False) -> dict[str, Any]:
        data = asdict(self)
        del data["state_changes"]
        if not with_trace:
            del data["trace"]
        return data


def run_virtual(
    arena: Arena,
    mission_path: Path,
    seed: int,
    recorder: Recorder | None = None,
    pixels: bool = False,
) -> RunResult:
    """Tick the mission from GO to its outcome, or to the arena's time limit.

    With `pixels` every camera frame is rendered and looked at by the detector that the mission names; otherwise boxes
    are projected, with a detector's measured errors.

    Raises:
        DeviceError: `pixels`, and the network cannot be loaded.
        ConfigError: `pixels`, and the mission names a detector that cannot find its target.
        MissionError: the mission cannot be loaded.
    """
    config = arena.config
    mission = load_mission(mission_path)
    eye = _Eye(config) if pixels else None
    simulation = Simulation(arena, seed, detect=eye.detect if eye is not None else None)
    source = SimIo(simulation, config, eye)
    core = NavCore(config, mission.root, source, source, recorder)
    try:
        return _drive(core, simulation, arena, mission_path, seed)
    finally:
        core.close()


class _Eye:
    """Looks at rendered pictures with the detector that the mission names, as the detector process does."""

    def __init__(self, config: Config) -> None:
        self._config = config
        self._label = ""
        self._detector: Detector | None = None

    def look_for(self, label: str) -> None:
        if label != self._label:
            # Only a run with pictures loads OpenCV.
            from target_nav.app.model_file import cpu_model
            from target_nav.detectors.named import detector_for

            self._label, self._detector = label, detector_for(label, lambda: cpu_model(self._config))

    def detect(self, image_bgr: ImageBgr) -> tuple[RawDetection, ...]:
        return self._detector.detect(image_bgr) if self._detector is not None else ()


def _drive(core: NavCore, simulation: Simulation, arena: Arena, mission_path: Path, seed: int) -> RunResult:
    period_s = 1.0 / core.config.loop.rate_hz
    changes: list[tuple[float, NavState]] = []
    ended_s: float | None = None
    record: TickRecord | None = None
    tick = 0
    while True:
        tick += 1
        now_s = tick * period_s
        record = core.tick(now_s)
        if not changes or changes[-1][1] is not record.state:
            changes.append((now_s, record.state))
        if record.outcome is None:
            ended_s = None
        elif ended_s is None:
            ended_s = now_s
        if (ended_s is not None and now_s - ended_s >= SETTLE_S) or now_s >= arena.time_limit_s:
            break

    arrived = record.outcome is not None and record.outcome.kind is OutcomeKind.SUCCEEDED
    verdict = simulation.judge(stand_off_of(core.root, core.config), arrived)
    success = verdict.success and ended_s is not None
    return RunResult(
        arena=arena.name,
        seed=seed,
        mission=mission_path.stem,
        success=success,
        collided=verdict.collided,
        timeout=ended_s is None,
        time_s=ended_s if ended_s is not None else now_s,
        path_m=verdict.path_m,
        stop_error_m=verdict.stop_error_m,
        bearing_error_rad=verdict.bearing_error_rad,
        min_clearance_m=verdict.min_clearance_m,
        states=tuple(state.name for _, state in changes),
        outcome=record.outcome.kind.value if record.outcome is not None else "timeout",
        reason=record.outcome.reason if record.outcome is not None else record.reason,
        as_expected=success and not verdict.collided,
        kind=arena.kind,
        level=arena.level,
        state_changes=tuple(changes),
        trace=tuple((p[0], p[1], p[2], p[3]) for p in simulation.path),
    )


def with_overrides(arena: Arena, values: dict[str, object]) -> Arena:
    """The arena with its configuration changed once more, after its own profile."""
    return replace(arena, config=arena.config.override(values)) if values else arena

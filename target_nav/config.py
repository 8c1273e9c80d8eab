"""Every number somebody may want to change, once: with unit, limits, default and the reason for it.

A `Config` is frozen. YAML files, arenas and ROS parameters change it through `Config.override` with dotted keys
(`lidar.rate_hz`), and nothing else does. Defaults marked "reference" are the original robot's; those marked
"measured" come from logs of real parts.
"""

from __future__ import annotations

import dataclasses
import difflib
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from target_nav.config_fields import checked, choice, quantity
from target_nav.errors import ConfigError


@dataclass(frozen=True)
class RobotConfig:
    """The body and what the drivetrain can do. base_link is on the floor, midway between the wheels."""

    drive: str = choice(
        "mecanum", ("mecanum", "differential"), "kind of drivetrain; differential cannot strafe"
    )
    front_m: float = quantity(0.15, "m", 0.02, 2.0, "base_link to the front edge")
    rear_m: float = quantity(0.15, "m", 0.02, 2.0, "base_link to the rear edge")
    half_width_m: float = quantity(0.14, "m", 0.02, 2.0, "base_link to either side")
    wheel_radius_m: float = quantity(0.03, "m", 0.005, 0.5, "of a wheel over its rollers")
    wheel_width_m: float = quantity(0.03, "m", 0.005, 0.5, "of a wheel")
    wheelbase_m: float = quantity(0.21, "m", 0.02, 2.0, "front axle to rear axle, base_link midway")
    track_m: float = quantity(0.238, "m", 0.02, 2.0, "middle of a left wheel to middle of a right wheel")
    max_speed_mps: float = quantity(0.30, "m/s", 0.02, 5.0, "forward limit (reference)")
    max_lateral_speed_mps: float = quantity(0.25, "m/s", 0.0, 5.0, "sideways limit")
    max_yaw_rate_radps: float = quantity(1.0, "rad/s", 0.1, 10.0, "turning limit")
    max_accel_mps2: float = quantity(0.6, "m/s^2", 0.05, 20.0, "limit of linear acceleration")
    max_decel_mps2: float = quantity(1.2, "m/s^2", 0.05, 20.0, "limit of linear braking")
    max_yaw_accel_radps2: float = quantity(3.0, "rad/s^2", 0.1, 50.0, "limit of turning acceleration")
    max_jerk_mps3: float = quantity(
        6.0, "m/s^3", 0.5, 1000.0, "limit of change of acceleration, for comfort: never of a stop for safety"
    )
    max_yaw_jerk_radps3: float = quantity(30.0, "rad/s^3", 1.0, 5000.0, "the same for turning")
    min_speed_mps: float = quantity(0.03, "m/s", 0.0, 0.5, "below this the motors do not turn: dead-band")
    min_yaw_rate_radps: float = quantity(
        0.12, "rad/s", 0.0, 1.0, "below this the base does not turn: dead-band"
    )

    @property
    def circumscribed_radius_m(self) -> float:
        return math.hypot(max(self.front_m, self.rear_m), self.half_width_m)


@dataclass(frozen=True)
class LidarConfig:
    """RPLidar A1, 5.5 Hz, one beam a degree (datasheet; noise and drop-outs measured)."""

    x_m: float = quantity(0.0, "m", -2.0, 2.0, "laser in base_link")
    y_m: float = quantity(0.0, "m", -2.0, 2.0, "laser in base_link")
    yaw_rad: float = quantity(0.0, "rad", -math.pi, math.pi, "laser in base_link")
    z_m: float = quantity(0.18, "m", 0.0, 2.0, "laser over the floor")
    port: str = field(default="/dev/ttyUSB0", metadata={"doc": "serial port of the LiDAR"})
    baud: int = quantity(115200, "baud", 1200, 2000000, "serial speed (A1: 115200)")
    rate_hz: float = quantity(5.5, "Hz", 0.5, 100.0, "turns a second (measured: 182 ms a turn)")
    beams: int = quantity(360, "1", 8, 4000, "beams a turn")
    fov_rad: float = quantity(2.0 * math.pi, "rad", 0.2, 2.0 * math.pi, "field of view")
    range_min_m: float = quantity(0.15, "m", 0.0, 5.0, "blind zone (datasheet)")
    range_max_m: float = quantity(12.0, "m", 0.5, 100.0, "datasheet")
    noise_scale: float = quantity(1.0, "1", 0.0, 10.0, "simulator: factor on the measured noise")
    dropout_scale: float = quantity(1.0, "1", 0.0, 3.0, "simulator: factor on the measured drop-outs")
    lost_scan_probability: float = quantity(0.01, "1", 0.0, 1.0, "simulator: a whole turn is lost")
    true_profile: bool = field(
        default=True,
        metadata={
            "doc": "simulator: a pin is as thin as its shape is at the LiDAR's height, not as its belly"
        },
    )
    range_offset_m: float = quantity(0.0, "m", -0.1, 0.1, "simulator: every range is too long by this")


@dataclass(frozen=True)
class CameraConfig:
    """USB camera, 640x480, 60 degrees wide, level, looking forward."""

    x_m: float = quantity(0.12, "m", -2.0, 2.0, "camera in base_link")
    y_m: float = quantity(0.0, "m", -2.0, 2.0, "camera in base_link")
    z_m: float = quantity(0.14, "m", 0.0, 2.0, "camera over the floor")
    yaw_rad: float = quantity(0.0, "rad", -math.pi, math.pi, "camera in base_link")
    width_px: int = quantity(640, "px", 64, 4096, "picture")
    height_px: int = quantity(480, "px", 64, 4096, "picture")
    focal_px: float = quantity(554.0, "px", 20.0, 10000.0, "focal length (60 degrees over 640 px)")
    pixel_aspect: float = quantity(1.0, "1", 0.5, 2.0, "upright focal length over the sideways one")
    center_right_px: float = quantity(
        0.0, "px", -500.0, 500.0, "principal point right of the picture's middle"
    )
    center_down_px: float = quantity(0.0, "px", -500.0, 500.0, "principal point below the picture's middle")
    lens_k1: float = quantity(0.0, "1", -5.0, 5.0, "radial distortion, Brown's model as in OpenCV")
    lens_k2: float = quantity(0.0, "1", -20.0, 20.0, "radial distortion, fourth power")
    lens_p1: float = quantity(0.0, "1", -0.5, 0.5, "tangential distortion")
    lens_p2: float = quantity(0.0, "1", -0.5, 0.5, "tangential distortion")
    lens_k3: float = quantity(0.0, "1", -50.0, 50.0, "radial distortion, sixth power")
    rate_hz: float = quantity(10.0, "Hz", 0.5, 120.0, "detections a second (reference: about 10)")
    latency_s: float = quantity(0.10, "s", 0.0, 2.0, "simulator: exposure to detection")
    noise_scale: float = quantity(1.0, "1", 0.0, 10.0, "simulator: factor on box jitter")
    box_jitter: float = quantity(
        0.03, "1", 0.0, 0.5, "simulator: sigma of a box edge, of its height (measured 2-5 %)"
    )
    miss_probability: float = quantity(0.06, "1", 0.0, 1.0, "simulator: a visible target is missed")
    false_rate: float = quantity(0.02, "1/frame", 0.0, 1.0, "simulator: false boxes a frame")
    mount_error_rad: float = quantity(
        0.008, "rad", -0.2, 0.2, "simulator: constant bearing error (measured <= 0.8 deg)"
    )
    focal_error: float = quantity(
        0.0, "1", -0.2, 0.2, "simulator: the true focal length is longer by this share (measured <= 4.4 %)"
    )
    max_range_m: float = quantity(
        4.0, "m", 0.2, 50.0, "simulator: beyond it the target is too small to be found"
    )

    @property
    def focal_y_px(self) -> float:
        return self.focal_px * self.pixel_aspect

    @property
    def center_u_px(self) -> float:
        return 0.5 * self.width_px + self.center_right_px

    @property
    def center_v_px(self) -> float:
        return 0.5 * self.height_px + self.center_down_px

    @property
    def lens(self) -> tuple[float, float, float, float, float]:
        """Distortion in OpenCV's order: k1 k2 p1 p2 k3."""
        return self.lens_k1, self.lens_k2, self.lens_p1, self.lens_p2, self.lens_k3

    @property
    def half_fov_rad(self) -> float:
        return math.atan2(self.width_px / 2.0, self.focal_px)


@dataclass(frozen=True)
class DriveSimConfig:
    """Simulator: what the drivetrain does to a command (measured ranges; the signs are drawn from the seed)."""

    lag_s: float = quantity(0.08, "s", 0.0, 2.0, "first-order lag of wheel speed")
    deadband_mps: float = quantity(0.02, "m/s", 0.0, 0.5, "wheel speed below which a motor stands")
    forward_scale_error: float = quantity(
        0.02, "1", 0.0, 0.5, "odometry's forward scale is off by up to this"
    )
    lateral_over_report: float = quantity(
        0.08, "1", 0.0, 0.5, "odometry reports this much more than it strafes"
    )
    heading_drift_rad_per_m: float = quantity(0.008, "rad/m", 0.0, 0.2, "0.3 to 0.6 degrees a metre")
    slip_rate_per_m: float = quantity(0.05, "1/m", 0.0, 5.0, "slip events a metre")
    slip_heading_rad: float = quantity(0.02, "rad", 0.0, 0.5, "sigma of heading lost in one slip")
    time_offset_s: float = quantity(0.0, "s", 0.0, 1.0, "odometry arrives this much late")


@dataclass(frozen=True)
class LoopConfig:
    """The nav process's loop and how old its inputs may be before the wheels stop."""

    rate_hz: float = quantity(20.0, "Hz", 1.0, 200.0, "ticks a second (reference)")
    scan_max_age_s: float = quantity(
        0.8, "s", 0.05, 10.0, "measured: one turn 0.18 s, a lost one up to 0.7 s"
    )
    odom_max_age_s: float = quantity(0.3, "s", 0.05, 10.0, "odometry comes at 20 Hz")
    camera_max_age_s: float = quantity(1.0, "s", 0.05, 10.0, "detections come at about 10 Hz")


@dataclass(frozen=True)
class TrackConfig:
    lost_after_s: float = quantity(3.0, "s", 0.1, 60.0, "no detection for so long: lost (reference)")
    confirm_hits: int = quantity(4, "1", 1, 100, "detections before a track counts")
    gate_sigma: float = quantity(3.5, "1", 1.0, 10.0, "innovation gate")
    process_noise_mps2: float = quantity(0.012, "m/s^2", 0.0, 5.0, "how much a target may move by itself")
    lidar_range_gate_m: float = quantity(0.25, "m", 0.02, 2.0, "LiDAR cluster to track, at most")
    max_range_m: float = quantity(8.0, "m", 0.5, 50.0, "detections beyond are ignored")
    camera_scale_sigma: float = quantity(
        0.03, "1", 0.0, 0.5, "constant range error of the camera (measured 4.4 % at most)"
    )
    camera_yaw_sigma_rad: float = quantity(
        0.008, "rad", 0.0, 0.2, "constant bearing error (measured <= 0.8 deg)"
    )
    drift_sigma: float = quantity(
        0.04, "m/sqrt(m)", 0.0, 0.5, "odometry: position, growing with the way driven"
    )
    drift_yaw_sigma_rad: float = quantity(
        0.012, "rad/sqrt(m)", 0.0, 0.5, "odometry: heading (measured 0.3-0.6 deg/m)"
    )
    switch_margin_m: float = quantity(
        0.3, "m", 0.0, 5.0, "another target must be so much nearer to be preferred"
    )
    switch_after_s: float = quantity(1.0, "s", 0.0, 30.0, "and for so long")


@dataclass(frozen=True)
class AvoidConfig:
    """VFH: the vector field histogram and the speed that clearance allows."""

    sectors: int = quantity(72, "1", 16, 720, "sectors of the polar histogram (5 degrees)")
    margin_m: float = quantity(
        0.05, "m", 0.0, 0.5, "kept free round the body (reference: half width 0.18 m in all)"
    )
    look_ahead_m: float = quantity(1.2, "m", 0.2, 5.0, "obstacles farther off do not count")
    stop_clearance_m: float = quantity(0.03, "m", 0.0, 1.0, "body to obstacle: stop")
    slow_clearance_m: float = quantity(0.35, "m", 0.01, 2.0, "body to obstacle: start to slow down")
    memory_radius_m: float = quantity(
        4.0, "m", 0.5, 10.0, "obstacles are remembered out to here, for planning and search"
    )
    memory_s: float = quantity(3.0, "s", 0.0, 60.0, "how long an obstacle that is out of sight is remembered")
    cost_target: float = quantity(5.0, "1", 0.0, 100.0, "VFH+ weight: away from the target")
    cost_heading: float = quantity(2.0, "1", 0.0, 100.0, "VFH+ weight: away from the present motion")
    cost_previous: float = quantity(2.0, "1", 0.0, 100.0, "VFH+ weight: away from the last choice")


@dataclass(frozen=True)
class ApproachConfig:
    cruise_speed_mps: float = quantity(0.15, "m/s", 0.02, 2.0, "reference; missions may ask for more")
    blind_speed_mps: float = quantity(0.10, "m/s", 0.01, 1.0, "reference")
    slow_from_m: float = quantity(0.50, "m", 0.0, 5.0, "slow down from here (reference)")
    blind_from_m: float = quantity(
        0.80, "m", 0.1, 5.0, "base_link to target: blind approach begins (reference)"
    )
    blind_timeout_s: float = quantity(15.0, "s", 0.5, 120.0, "blind approach gives up")
    stand_off_m: float = quantity(0.10, "m", 0.0, 2.0, "front edge to the target's surface when arrived")


@dataclass(frozen=True)
class SearchConfig:
    time_limit_s: float = quantity(30.0, "s", 1.0, 600.0, "searching by turning gives up (reference)")
    yaw_rate_radps: float = quantity(0.8, "rad/s", 0.05, 3.0, "turning while searching: 13 frames a picture")
    spiral_time_limit_s: float = quantity(90.0, "s", 1.0, 3600.0, "spiral search gives up")
    spiral_spacing_m: float = quantity(0.8, "m", 0.1, 5.0, "distance of one turn of the spiral to the next")
    spiral_radius_m: float = quantity(4.0, "m", 0.2, 20.0, "how far out the spiral goes")
    spiral_speed_mps: float = quantity(0.25, "m/s", 0.02, 2.0, "speed along the spiral")


@dataclass(frozen=True)
class ManualConfig:
    """Driving by hand, from the panel or the console."""

    speed_mps: float = quantity(0.15, "m/s", 0.02, 2.0, "ahead and sideways while a key or the pad is held")
    yaw_rate_radps: float = quantity(0.6, "rad/s", 0.05, 3.0, "turning while a key or the pad is held")
    timeout_s: float = quantity(
        0.2, "s", 0.1, 1.0, "deadman: no word for so long that it is still held, and the wheels stop"
    )


@dataclass(frozen=True)
class ArrivalConfig:
    confirm_s: float = quantity(0.3, "s", 0.0, 5.0, "signals must agree for so long (reference)")
    range_tolerance_m: float = quantity(0.03, "m", 0.001, 0.5, "stand-off is met within this")
    bearing_tolerance_rad: float = quantity(0.15, "rad", 0.01, 1.0, "the target is ahead within this")
    min_signals: int = quantity(2, "1", 1, 4, "independent signals that must agree; never one alone")


@dataclass(frozen=True)
class DetectorConfig:
    program: str = choice(
        "auto",
        ("auto", "cpp", "python"),
        "what runs the network: cpp, a program to be built; python, which has every other detector too; "
        "auto: the first if it is built and its model is there",
    )
    backend: str = choice(
        "cpu", ("cpu", "drpai"), "what runs the network: OpenCV, or the board's accelerator"
    )
    model: str = field(
        default="",
        metadata={"doc": "network (cpu: ONNX file, drpai: folder); empty: the one in deploy/model"},
    )
    propose_score: float = quantity(
        0.3, "1", 0.0, 1.0, "the detector proposes boxes from here on; up to score_min they are only counted"
    )
    score_min: float = quantity(0.5, "1", 0.0, 1.0, "first layer: score")
    aspect_tolerance: float = quantity(
        0.45, "1", 0.05, 2.0, "second layer: |ln(measured / expected width:height)|"
    )
    confirm_frames: int = quantity(3, "1", 1, 30, "third layer: frames before an object counts")
    coast_frames: int = quantity(5, "1", 0, 60, "frames an object survives unseen")
    border_px: float = quantity(3.0, "px", 0.0, 50.0, "a box this near to the border is clipped")
    range_sigma: float = quantity(
        0.040, "1", 0.001, 0.5, "sigma of a range, of the range (measured 3.4-4.3 %)"
    )
    edge_sigma_px: float = quantity(0.35, "px", 0.0, 20.0, "sigma of a box's height in pixels, on top of it")
    bearing_sigma_rad: float = quantity(0.0096, "rad", 0.0, 0.2, "sigma of a bearing (measured 0.4-0.7 deg)")
    mount_sigma_rad: float = quantity(
        0.008, "rad", 0.0, 0.2, "what calibration leaves of the mount's yaw error"
    )


@dataclass(frozen=True)
class SerialConfig:
    port: str = field(default="/dev/ttyACM0", metadata={"doc": "serial port of the Arduino"})
    baud: int = quantity(115200, "baud", 1200, 2000000, "serial speed")
    cmd_vel_stale_s: float = quantity(
        0.2, "s", 0.05, 5.0, "arduino node: no /cmd_vel, zero velocity; with the firmware's step under 0.3 s"
    )
    cmd_vel_timeout_s: float = quantity(0.5, "s", 0.05, 5.0, "arduino node: no /cmd_vel, STOP (reference)")
    vel_watchdog_s: float = quantity(0.2, "s", 0.05, 5.0, "firmware: no VEL, stop (reference)")


@dataclass(frozen=True)
class OdometryConfig:
    """Calibration of the wheels' odometry: what one reported unit is worth."""

    forward_scale: float = quantity(1.0, "1", 0.5, 2.0, "true way over reported way, forward")
    lateral_scale: float = quantity(
        1.0, "1", 0.5, 2.0, "the same sideways; a mecanum base over-reports by 5-10 %"
    )
    yaw_scale: float = quantity(1.0, "1", 0.5, 2.0, "the same for turning")
    max_gap_s: float = quantity(0.25, "s", 0.05, 5.0, "of a longer silence only so much is integrated")


@dataclass(frozen=True)
class GoalConfig:
    """Where a mission goes that names no place of its own (trees/go_to_point.xml): in odom, home by default."""

    x_m: float = quantity(0.0, "m", -1000.0, 1000.0, "forward of where odometry began")
    y_m: float = quantity(0.0, "m", -1000.0, 1000.0, "to the left of where odometry began")
    within_m: float = quantity(0.10, "m", 0.03, 5.0, "base_link as near as this is there")


@dataclass(frozen=True)
class IpcConfig:
    prefix: str = field(default="v2n", metadata={"doc": "of the channels' names in /dev/shm"})


@dataclass(frozen=True)
class Config:
    """All of it. `Config()` is the reference robot."""

    robot: RobotConfig = RobotConfig()
    lidar: LidarConfig = LidarConfig()
    camera: CameraConfig = CameraConfig()
    drive_sim: DriveSimConfig = DriveSimConfig()
    loop: LoopConfig = LoopConfig()
    track: TrackConfig = TrackConfig()
    avoid: AvoidConfig = AvoidConfig()
    approach: ApproachConfig = ApproachConfig()
    search: SearchConfig = SearchConfig()
    arrival: ArrivalConfig = ArrivalConfig()
    manual: ManualConfig = ManualConfig()
    detector: DetectorConfig = DetectorConfig()
    serial: SerialConfig = SerialConfig()
    ipc: IpcConfig = IpcConfig()
    odometry: OdometryConfig = OdometryConfig()
    goal: GoalConfig = GoalConfig()

    def override(self, values: Mapping[str, object], source: str = "override") -> Config:
        """A copy with dotted keys replaced: `override({"lidar.rate_hz": 10.0})`.

        Raises:
            ConfigError: an unknown key (with the nearest right one), a wrong type, a value outside its limits. All
                problems are told at once.
        """
        sections: dict[str, dict[str, Any]] = {}
        problems: list[str] = []
        known = {key for key, _, _ in self.items()}
        for key, value in values.items():
            if key not in known:
                near = difflib.get_close_matches(key, known, n=1)
                hint = f"; did you mean {near[0]!r}?" if near else ""
                problems.append(f"{source}: unknown key {key!r}{hint}")
                continue
            section, name = key.split(".", 1)
            current = getattr(self, section)
            spec = next(f for f in dataclasses.fields(current) if f.name == name)
            try:
                sections.setdefault(section, {})[name] = checked(
                    key, value, getattr(current, name), spec.metadata
                )
            except ConfigError as error:
                problems.append(f"{source}: {error}")
        if problems:
            raise ConfigError("\n".join(problems))
        changed = {name: dataclasses.replace(getattr(self, name), **vals) for name, vals in sections.items()}
        return dataclasses.replace(self, **changed)

    def items(self) -> Iterator[tuple[str, Any, Mapping[str, Any]]]:
        """Every key as (dotted name, value, metadata: unit, low, high, options, doc)."""
        for section in dataclasses.fields(self):
            group = getattr(self, section.name)
            for spec in dataclasses.fields(group):
                yield f"{section.name}.{spec.name}", getattr(group, spec.name), spec.metadata

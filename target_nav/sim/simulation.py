"""The simulator: a robot in an arena, with a serial line, a LiDAR and a camera, driven by whoever calls `step_to`.

No clock, no thread: virtual time and real time differ only in who says what time it is. Inside, time goes in steps of
10 ms, so that the outcome depends on the seed and on what was written when, not on how often somebody asked.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import replace

from target_nav.config import Config
from target_nav.errors import ConfigError
from target_nav.sim.arena_types import Arena
from target_nav.sim.boxes import BoxCamera
from target_nav.sim.contact import ContactMonitor
from target_nav.sim.drive import Drive
from target_nav.sim.firmware_types import Firmware
from target_nav.sim.history import PoseHistory
from target_nav.sim.host_firmware import HostFirmware
from target_nav.sim.judge import Verdict, judge, target_gap_m
from target_nav.sim.lidar import Lidar
from target_nav.sim.moving import MovingTarget
from target_nav.sim.pixels import Detect, Draw, PixelCamera
from target_nav.sim.streams import stream
from target_nav.sim.world import World
from target_nav.state.types import Pose2D, RawDetectionFrame, Scan, TargetSpec, Twist2D

STEP_S = 0.01
"""At 0.3 m/s a step is 3 mm, about what the LiDAR can tell."""

PATH_STEPS = 5
"""The path is noted every so many steps: at 20 Hz."""

PATH_LIMIT = 20 * 3600 * 4
"""Points kept: four hours. A simulator that runs for days forgets the oldest."""

KEPT_MESSAGES = 64
"""Scans that nobody took; of the firmware's lines as many as that again in seconds."""

_EARLY_STEPS = 1e-6
_OFF = (0, 0, 0, 0)


class Simulation:
    """One robot in one arena. Stamps are on the caller's time axis, which begins at `start_s`.

    Args:
        firmware: makes the drivetrain's firmware for a robot and a start time.
        detect: finds the boxes in rendered pictures; without it they are projected.

    Raises:
        ValueError: the seed is negative.
        DeviceError, ConfigError: the firmware cannot be had, or cannot drive this robot.
    """

    def __init__(
        self,
        arena: Arena,
        seed: int,
        start_s: float = 0.0,
        firmware: Callable[[Config, float], Firmware] = HostFirmware,
        detect: Detect | None = None,
    ) -> None:
        config, start = arena.config, arena.robot
        self.arena = arena
        self._start_s = start_s
        self._steps = 0
        world = World(arena)
        self._target = MovingTarget(arena, world)
        self._contact = ContactMonitor(world, start.x_m, start.y_m, start.yaw_rad)
        self.drive = Drive(
            config.robot, config.drive_sim, start, self._contact, stream(seed, "drive"), STEP_S
        )
        self._firmware = firmware(config, start_s)
        self._history = PoseHistory(start_s, STEP_S, start.x_m, start.y_m, start.yaw_rad)
        beams = world.ray_caster(config.lidar.z_m, config.lidar.true_profile)
        self._lidar = Lidar(config.lidar, beams, stream(seed, "lidar"), start_s)
        target_class = arena.target.class_name if arena.target is not None else TargetSpec().class_name
        self._camera: BoxCamera | PixelCamera
        if detect is not None:
            if self._target.moves:
                raise ConfigError(
                    f"{arena.name}: its target moves, which is not drawn for the camera; leave out pixels"
                )
            self._camera = PixelCamera(
                config.camera, _drawing(arena, seed), detect, stream(seed, "camera"), start_s
            )
        else:
            self._camera = BoxCamera(
                config.camera,
                arena.objects,
                target_class,
                world.ray_caster(config.camera.z_m),
                stream(seed, "camera"),
                start_s,
            )
        self._scans: deque[Scan] = deque(maxlen=KEPT_MESSAGES)
        self._serial: deque[tuple[float, bytes]] = deque(maxlen=20 * KEPT_MESSAGES)
        self._driven_s = start_s
        self._odometry_delay_s = config.drive_sim.time_offset_s
        self.path: list[list[float]] = [[start_s, start.x_m, start.y_m, self.drive.pose.yaw_rad]]
        """True poses at 20 Hz: [t_s, x_m, y_m, yaw_rad]."""

    @property
    def now_s(self) -> float:
        """The time the simulation has come to: a whole number of steps."""
        return self._start_s + self._steps * STEP_S

    def step_to(self, now_s: float) -> None:
        """Advance to `now_s`, as far as whole steps go. A time that has passed already changes nothing."""
        steps = int((now_s - self._start_s) / STEP_S + _EARLY_STEPS)
        while self._steps < steps:
            self._step()

    def _step(self) -> None:
        self._steps += 1
        drive, history = self.drive, self._history
        now_s = self._start_s + self._steps * STEP_S
        pwm = self._firmware.pwm
        if pwm != _OFF:
            self._driven_s = now_s
        drive.step(pwm)
        if self._target.moves:
            self._move_target()
        history.append(drive.x_m, drive.y_m, drive.yaw_rad)
        self._firmware.step(now_s, drive.ticks)
        if self._firmware.has_output:
            self._serial.append((now_s + self._odometry_delay_s, self._firmware.take_output()))
        if now_s >= self._lidar.due_s:
            self._scans.extend(self._lidar.advance(now_s, history))
        if now_s >= self._camera.due_s:
            self._camera.advance(now_s, history)
        if self._steps % PATH_STEPS == 0:
            pose = drive.pose
            self.path.append([now_s, pose.x_m, pose.y_m, pose.yaw_rad])
            if len(self.path) > PATH_LIMIT:
                del self.path[: PATH_LIMIT // 2]

    def _move_target(self) -> None:
        way_m = self._target.step(STEP_S)
        if self._target.place is not None and isinstance(self._camera, BoxCamera):
            self._camera.move_target(self._target.place)
        self._contact.disturb(self.drive.x_m, self.drive.y_m, self.drive.yaw_rad, way_m)

    @property
    def arena_now(self) -> Arena:
        """The arena with the target where it is by now."""
        return replace(self.arena, target=self._target.place)

    def serial_write(self, data: bytes) -> None:
        """Bytes from the host to the firmware, now."""
        self._firmware.feed(data, self.now_s)

    def serial_read(self) -> bytes:
        """Bytes from the firmware that have arrived since the last call."""
        arrived = bytearray()
        now_s = self.now_s + 1e-9
        while self._serial and self._serial[0][0] <= now_s:
            arrived += self._serial.popleft()[1]
        return bytes(arrived)

    def take_scans(self) -> list[Scan]:
        """Scans completed since the last call, oldest first."""
        scans = list(self._scans)
        self._scans.clear()
        return scans

    def take_boxes(self) -> list[RawDetectionFrame]:
        """Frames delivered since the last call, oldest first; exposed `camera.latency_s` earlier."""
        return self._camera.take(self.now_s)

    @property
    def true_pose(self) -> Pose2D:
        return self.drive.pose

    @property
    def true_twist(self) -> Twist2D:
        """In base_link."""
        return Twist2D(self.drive.vx_mps, self.drive.vy_mps, self.drive.wz_radps)

    @property
    def driven_s(self) -> float:
        """Until when a motor was given power; the present while one is."""
        return self._driven_s

    def pose_at(self, stamp_s: float) -> Pose2D:
        """The true pose at a moment of the last three seconds, for whoever draws what a camera saw then."""
        return Pose2D(*self._history.at(stamp_s))

    @property
    def camera_mount_error_rad(self) -> float:
        """How far the camera really looks to the left of where the configuration says."""
        return self._camera.mount_error_rad

    @property
    def collided(self) -> bool:
        """The footprint touched something, at any time."""
        return self._contact.collided

    @property
    def min_clearance_m(self) -> float:
        """The least there was between the footprint and anything."""
        return self._contact.min_clearance_m

    @property
    def target_distance_m(self) -> float | None:
        """From the footprint's front edge to the target's surface; None without a target."""
        if self.arena.target is None:
            return None
        arena = self.arena_now
        assert arena.target is not None
        return target_gap_m(self.true_pose, arena, arena.target)

    def judge(self, stand_off_m: float, reported_arrived: bool) -> Verdict:
        """How the run stands now; see `target_nav.sim.judge`."""
        return judge(
            self.arena_now,
            self.true_pose,
            self.true_twist,
            stand_off_m=stand_off_m,
            reported_arrived=reported_arrived,
            collided=self.collided,
            min_clearance_m=self.min_clearance_m,
            path_m=self.drive.path_m,
        )


def _drawing(arena: Arena, seed: int) -> Callable[[float], Draw]:
    """Every seed paints the room anew."""

    def draw_with(mount_error_rad: float) -> Draw:
        # Only who wants pictures loads OpenCV.
        from target_nav.sim.render import Renderer
        from target_nav.sim.render_look import Look

        return Renderer(arena, arena.config, mount_error_rad, Look.of(seed)).draw

    return draw_with

"""Driving the legs of a calibration: over the serial port itself, or in the simulator in virtual time.

No ROS: the drivetrain alone is looked at, with nothing between the wheels and the person who measures. The firmware's
watchdog stops the wheels when this program ends, however it ends.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from target_nav.config import Config
from target_nav.errors import DeviceError
from target_nav.hardware import protocol
from target_nav.hardware.arduino_bridge import ArduinoBridge
from target_nav.hardware.firmware_check import FirmwareCheck
from target_nav.nav.odometry import OdometryIntegrator, OdometryScale
from target_nav.nav.odometry_calibration import Axis, Leg, LegDriver, LegPose, Unwrapped
from target_nav.sim.arena import Arena
from target_nav.sim.simulation import STEP_S, Simulation
from target_nav.state.types import STOP, Twist2D

PERIOD_S = 0.05
SILENCE_S = 0.5
"""Longer without odometry: it is not known any more what the robot does."""

STANDING_LINES = 5
"""So many reports of standing still in a row are a robot that stands."""

STAND_LIMIT_S = 5.0

Odom = tuple[float, Twist2D, int | None]
"""Stamp, velocity and the firmware's clock of one ODOM line."""


class Drivetrain(Protocol):
    """The wheels, one period at a time."""

    @property
    def now_s(self) -> float: ...

    def keep(self, twist: Twist2D) -> list[Odom]:
        """Drive so for one period of 50 ms; the odometry that came in it.

        Raises:
            DeviceError: the port is lost, or the firmware stopped by itself.
        """

    def stop(self) -> None:
        """Stand, now."""


class SerialDrivetrain:
    """The robot's own wheels, by its serial port.

    Raises:
        DeviceError: the port cannot be opened (the stack runs?), or no firmware of this protocol answers.
    """

    def __init__(self, port: str, baud: int) -> None:
        self._heard: deque[tuple[float, protocol.DeviceLine]] = deque()
        self._bridge = ArduinoBridge(port, baud, lambda line, stamp_s: self._heard.append((stamp_s, line)))
        self._bridge.open()
        self._due_s = time.monotonic()
        try:
            self._greet()
        except BaseException:
            self._bridge.close()
            raise

    @property
    def now_s(self) -> float:
        return time.monotonic()

    def keep(self, twist: Twist2D) -> list[Odom]:
        if not self._bridge.send_velocity(twist):
            raise DeviceError(f"{self._bridge.port} is lost; the firmware has stopped the wheels")
        self._wait()
        return [
            (stamp_s, line.to_twist(), line.device_us)
            for stamp_s, line in self._take()
            if isinstance(line, protocol.OdomLine)
        ]

    def stop(self) -> None:
        self._bridge.send_stop()

    def close(self) -> None:
        self._bridge.close()

    def _greet(self) -> None:
        check = FirmwareCheck()
        while not check.may_drive:
            question = check.poll(self.now_s)
            if question:
                self._bridge.send(question)
            self._wait()
            for _, line in self._take():
                if isinstance(line, protocol.VersionLine):
                    check.take(line, self._bridge.port)
        if check.silent:
            raise DeviceError(
                f"no firmware answers on {self._bridge.port}; is it flashed? (docs/firmware.md)"
            )

    def _take(self) -> list[tuple[float, protocol.DeviceLine]]:
        self._bridge.raise_failure()
        taken = [self._heard.popleft() for _ in range(len(self._heard))]
        for _, line in taken:
            if isinstance(line, protocol.ErrorLine):
                raise DeviceError(f"the firmware stopped: {line.code} {line.text}")
        return taken

    def _wait(self) -> None:
        # The time a person took is not made up for.
        self._due_s = max(self._due_s, time.monotonic() - PERIOD_S) + PERIOD_S
        time.sleep(max(self._due_s - time.monotonic(), 0.0))


class SimDrivetrain:
    """The simulator's wheels, in virtual time."""

    def __init__(self, arena: Arena, seed: int) -> None:
        self.simulation = Simulation(arena, seed)
        self._lines = protocol.LineAssembler()

    @property
    def now_s(self) -> float:
        return self.simulation.now_s

    def keep(self, twist: Twist2D) -> list[Odom]:
        simulation, odometry = self.simulation, []
        simulation.serial_write(protocol.encode_velocity(twist))
        for _ in range(round(PERIOD_S / STEP_S)):
            simulation.step_to(simulation.now_s + STEP_S)
            for raw in self._lines.feed(simulation.serial_read()):
                line = protocol.parse_line(raw)
                if isinstance(line, protocol.OdomLine):
                    odometry.append((simulation.now_s, line.to_twist(), line.device_us))
                elif isinstance(line, protocol.ErrorLine):
                    raise DeviceError(f"the firmware stopped: {line.code} {line.text}")
        if simulation.collided:
            raise DeviceError(
                f"the robot touched something in arena {simulation.arena.name}; take one with more room"
            )
        return odometry

    def stop(self) -> None:
        self.simulation.serial_write(protocol.encode_stop())

    @property
    def true_pose(self) -> LegPose:
        drive = self.simulation.drive
        return LegPose(drive.x_m, drive.y_m, drive.yaw_rad)


@dataclass(frozen=True)
class Driven:
    """What odometry says of some legs: from where to where, from standstill to standstill."""

    start: LegPose
    end: LegPose


class Driver:
    """Drives legs with odometry as `scale` makes it."""

    def __init__(self, drivetrain: Drivetrain, config: Config, scale: OdometryScale) -> None:
        self._drivetrain, self._robot = drivetrain, config.robot
        self._odometry = OdometryIntegrator(scale, config.odometry.max_gap_s)
        self._yaw = Unwrapped(self._odometry.pose_in_odom)
        self._heard_s = float("-inf")

    def drive(self, legs: Sequence[Leg]) -> Driven:
        """Drive them one after the other, each to a standstill.

        Raises:
            DeviceError: the wheels do not do it; they have been told to stop.
        """
        drivetrain = self._drivetrain
        try:
            self._heard_s = drivetrain.now_s
            self._stand()
            start = self._yaw.pose
            heading_rad = start.yaw_rad
            for leg in legs:
                heading_rad = self._drive_leg(leg, heading_rad)
            return Driven(start, self._yaw.pose)
        finally:
            drivetrain.stop()

    def _drive_leg(self, leg: Leg, heading_rad: float) -> float:
        """Returns the heading at which the leg is meant to end."""
        begin_s = self._drivetrain.now_s
        driver = LegDriver(leg, self._robot, self._yaw.pose, heading_rad, begin_s)
        while (twist := driver.twist(self._yaw.pose, self._drivetrain.now_s)) is not None:
            self._keep(twist)
            if self._drivetrain.now_s - begin_s > driver.limit_s:
                raise DeviceError(
                    f"after {driver.limit_s:.0f} s odometry has seen {driver.done(self._yaw.pose):.2f} of "
                    f"{abs(leg.amount):.2f} ({leg.axis.value}); do the wheels turn?"
                )
        self._stand()
        return heading_rad + (leg.amount if leg.axis is Axis.TURN else 0.0)

    def _stand(self) -> None:
        """Zero velocities, not STOP: odometry goes on with them, and sees how the wheels run out."""
        begin_s, standing = self._drivetrain.now_s, 0
        while standing < STANDING_LINES:
            for twist in self._keep(STOP):
                standing = standing + 1 if twist == STOP else 0
            if self._drivetrain.now_s - begin_s > STAND_LIMIT_S:
                raise DeviceError(f"the wheels still turn {STAND_LIMIT_S:g} s after they were told to stand")

    def _keep(self, twist: Twist2D) -> list[Twist2D]:
        heard = self._drivetrain.keep(twist)
        for stamp_s, reported, device_us in heard:
            self._odometry.add(stamp_s, reported, device_us)
            self._heard_s = stamp_s
        self._yaw.follow(self._odometry.pose_in_odom)
        silent_s = self._drivetrain.now_s - self._heard_s
        if silent_s > SILENCE_S:
            raise DeviceError(
                f"no odometry for {silent_s:.2f} s (limit {SILENCE_S:g} s); is the Arduino still there?"
            )
        return [reported for _, reported, _ in heard]

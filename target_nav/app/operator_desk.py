"""What an operator may say beyond GO and STOP: drive by hand, set a value, choose mission and target, test a motor.

All of it reaches the nav core as commands, which are inputs: recorded, and the same in a replay. What moves the robot
waits until no mission is wanted, so a mission and a person never pull at the same wheels.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable

from target_nav.app.world_board import WorldBoard
from target_nav.config import Config
from target_nav.errors import ConfigError
from target_nav.nav.manual_drive import ManualDrive, manual_twist
from target_nav.state import keys
from target_nav.state.live_settings import fingerprint, with_setting
from target_nav.state.types import Command, CommandKind, TargetSpec

log = logging.getLogger(__name__)

FIRMWARE_STOP = "STOP"
MOTOR_TEST = "TMOTOR,"
MOTOR_HOLD_S = 0.5
"""A motor test is said again while its key is held, as manual drive is; the firmware alone would go on for 30 s."""
_TARGET_LIMITS_M = (0.01, 5.0)


class OperatorDesk:
    """Obeys the commands that `obey` is given, and keeps what others fetch of them."""

    def __init__(
        self,
        config: Config,
        board: WorldBoard,
        mission_wanted: Callable[[], bool],
        configure: Callable[[Config], None],
        begin_anew: Callable[[], None],
    ) -> None:
        self.manual = ManualDrive(config.manual)
        self.notice, self.notice_count = "", 0
        self.settings_crc = fingerprint(config)
        self._config, self._board = config, board
        self._mission_wanted, self._configure, self._begin_anew = mission_wanted, configure, begin_anew
        self._load_asked = ""
        self._for_firmware: list[str] = []
        self._firmware_busy = False
        self._motor_line, self._motor_held_s = "", math.inf
        self._obey = {
            CommandKind.MANUAL: self._drive_by_hand,
            CommandKind.SETTING: self._change_setting,
            CommandKind.LOAD: self._load,
            CommandKind.TARGET: self._choose_target,
            CommandKind.FIRMWARE: self._to_firmware,
        }

    def obey(self, command: Command) -> None:
        self._obey[command.kind](command)

    def tell(self, notice: str) -> None:
        """A notice for the operator's screen; the same one again and again is one line of the log."""
        if notice != self.notice:
            log.info("%s", notice)
        self.notice, self.notice_count = notice, self.notice_count + 1

    def end_by_hand(self) -> None:
        """GO and STOP end what a person does with the wheels, a motor test included."""
        self.manual.stop()
        self._motor_line, self._motor_held_s = "", math.inf
        if self._firmware_busy:
            self._for_firmware.append(FIRMWARE_STOP)
            self._firmware_busy = False

    def take_load(self) -> str:
        """The mission that LOAD named since the last call, or nothing."""
        asked, self._load_asked = self._load_asked, ""
        return asked

    def take_firmware_lines(self, now_s: float) -> tuple[str, ...]:
        """Lines for the firmware that came since the last call; STOP once a motor test is not held any more."""
        if now_s - self._motor_held_s > MOTOR_HOLD_S:
            self._motor_line, self._motor_held_s = "", math.inf
            self._for_firmware.append(FIRMWARE_STOP)
            self._firmware_busy = False
        lines = tuple(self._for_firmware)
        self._for_firmware.clear()
        return lines

    def _may(self, what: str) -> bool:
        """Only while no mission is wanted; otherwise the operator is told."""
        wanted = self._mission_wanted()
        if wanted:
            self.tell(f"{what}: not while a mission runs; say STOP first")
        return not wanted

    def _drive_by_hand(self, command: Command) -> None:
        twist = manual_twist(command.argument)
        if twist is None:
            self.tell(f"{command.argument!r} is no velocity to drive by hand at")
        elif self._may("manual drive"):
            self.manual.hold(command.stamp_s, twist)

    def _change_setting(self, command: Command) -> None:
        try:
            config = with_setting(self._config, command.argument)
        except ConfigError as error:
            self.tell(str(error))
            return
        self._config = config
        self.settings_crc = fingerprint(config)
        self.manual.configure(config.manual)
        self._configure(config)
        self.tell(f"set {command.argument}")

    def _load(self, command: Command) -> None:
        if self._may("another mission"):
            self._load_asked = command.argument

    def _choose_target(self, command: Command) -> None:
        if not self._may("another target"):
            return
        try:
            self._board.write(keys.TARGET_CHOICE, target_of(command.argument))
        except ConfigError as error:
            self.tell(str(error))
            return
        self._begin_anew()
        self.tell(f"target: {command.argument or 'as the mission says'}")

    def _to_firmware(self, command: Command) -> None:
        line = command.argument.strip()
        if line == FIRMWARE_STOP:
            self._motor_line, self._motor_held_s = "", math.inf
            self._for_firmware.append(line)
            self._firmware_busy = False
        elif line.startswith(MOTOR_TEST) and line == self._motor_line and not self._mission_wanted():
            self._motor_held_s = command.stamp_s
        elif self._may(line):
            if line.startswith(MOTOR_TEST):
                self._motor_line, self._motor_held_s = line, command.stamp_s
            self.manual.release()
            self._for_firmware.append(line)
            self._firmware_busy = True
            self.tell(f"to the firmware: {line}")


def target_of(argument: str) -> TargetSpec | None:
    """The target of a TARGET command, `class,height_m,width_m[,lidar_width_m]`; None for that of the mission.

    Raises:
        ConfigError: another number of parts, or a size that is none.
    """
    if not argument:
        return None
    name, *sizes = argument.split(",")
    low, high = _TARGET_LIMITS_M
    try:
        height_m, width_m, *at_lidar = (float(size) for size in sizes)
        (lidar_width_m,) = at_lidar or (0.0,)
    except ValueError:
        name = ""
    if not name or not (low <= height_m <= high and low <= width_m <= high and 0.0 <= lidar_width_m <= high):
        raise ConfigError(
            f"target {argument!r} must be class,height_m,width_m,lidar_width_m, with sizes of {low:g} ... {high:g} m; "
            "the last may be 0 (as wide at the LiDAR's height as everywhere) or left out"
        )
    return TargetSpec(name, height_m, width_m, lidar_width_m)

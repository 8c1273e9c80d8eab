"""The operator's side of a screen: his words, the keys he holds, the settings he changes, each a line in the log."""

from __future__ import annotations

import logging
import math
from typing import Any

from target_nav.errors import ConfigError
from target_nav.gui.commands import CommandPort, Said
from target_nav.gui.events import BAD, WARN, EventLog
from target_nav.gui.manual import ManualPad
from target_nav.gui.model import Views
from target_nav.gui.settings import Change, Settings
from target_nav.state.types import CommandKind, TargetSpec

log = logging.getLogger(__name__)

MOTOR_PERIOD_S = 0.2


class Operator:
    """For one thread. `beat` has to be called at least every 25 ms: it is what holds a hold."""

    def __init__(self, port: CommandPort, events: EventLog, settings: Settings) -> None:
        self.port, self.events, self.settings = port, events, settings
        self.pad = ManualPad()
        self._motor_line = ""
        self._motor_next_s = -math.inf
        self._told: Said | None = None
        self._late_told_s = -math.inf

    def go(self) -> Said:
        self.pad.release_all()
        return self._say(CommandKind.GO)

    def stop(self) -> Said:
        """Lets go of everything that is held, too."""
        self.pad.release_all()
        self._motor_line = ""
        return self._say(CommandKind.STOP)

    def say(self, kind: CommandKind, argument: str = "") -> Said:
        return self._say(kind, argument)

    def load(self, mission: str) -> Said:
        return self._say(CommandKind.LOAD, mission)

    def target(self, spec: TargetSpec | None) -> Said:
        said = self.port.target(spec)
        self._note(said)
        return said

    def say_first_stop(self, views: Views | None) -> bool:
        """Whether driving by hand has to wait for STOP, because a mission runs; the log tells."""
        wanted = views is not None and views.status.requested
        if wanted:
            self.events.add("manual drive: not while a mission runs; STOP first", WARN)
        return wanted

    def hold_motor(self, motor: str, pwm: int) -> None:
        """Turn one motor for as long as it is held."""
        self._motor_line = f"TMOTOR,{motor},{pwm}"
        self._motor_next_s = -math.inf

    def release_motor(self) -> None:
        if self._motor_line:
            self._motor_line = ""
            self.port.firmware("STOP")

    def change(self, key: str, value: Any) -> Change:
        """Save a setting, and send it to the nav process if it takes it.

        Raises:
            ConfigError: as `Settings.change`.
        """
        try:
            change = self.settings.change(key, value)
        except ConfigError as error:
            self.events.add(str(error), BAD)
            raise
        self.events.add(f"setting {key} = {change.value}" + ("" if change.live else " (from the next start)"))
        log.info("setting %s = %s", key, change.value)
        if change.live:
            self._note(self.port.setting(key, change.value))
        return change

    def beat(self, now_s: float) -> Said | None:
        """Say again what is held, and see what was acknowledged. The last word, for a screen."""
        twist = self.pad.due(now_s, self.settings.config)
        if twist is not None:
            self.port.drive(twist)
        if self._motor_line and now_s >= self._motor_next_s:
            self._motor_next_s = now_s + MOTOR_PERIOD_S
            self.port.firmware(self._motor_line)
        last = self.port.poll()
        if last is not None and last is not self._told:
            self._tell(last, now_s)
        return last

    def close(self) -> None:
        self.pad.release_all()
        self.port.close()

    def _say(self, kind: CommandKind, argument: str = "") -> Said:
        said = self.port.say(kind, argument)
        self._note(said)
        return said

    def _note(self, said: Said) -> None:
        words = f"{said.name} {said.argument}".strip()
        log.info("said %s", words)
        self.events.add(f"you: {words}")

    def _tell(self, said: Said, now_s: float) -> None:
        """A word's fate, once: acknowledged, or late."""
        if said.acknowledged_s is None and not said.is_late(now_s):
            return
        if said.acknowledged_s is None:
            if said.said_s == self._late_told_s:
                return
            self._late_told_s = said.said_s
            self.events.add(said.text(now_s), BAD)
        else:
            self._told = said
        log.info("%s", said.text(now_s))

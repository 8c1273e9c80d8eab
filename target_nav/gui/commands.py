"""What the operator says, and whether the nav process has heard it.

The command ring has one live writer, and there may be several screens: each word claims it, is pushed, and lets it go.
A STOP that is not acknowledged is said again until it is.
"""

from __future__ import annotations

import contextlib
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace

from target_nav.errors import DeviceError
from target_nav.ipc import channels
from target_nav.nav.manual_drive import manual_text
from target_nav.state.live_settings import setting_text
from target_nav.state.types import Command, CommandKind, TargetSpec, Twist2D

ACK_LIMIT_S = 0.1
"""Two ticks of the nav process: later is told as not acknowledged, until it is."""
FORGET_S = 3.0
REPEAT_STOP_S = 0.25
HISTORY = 20


@dataclass(frozen=True)
class Said:
    """One word and what came of it. `acknowledged_s`: after so long the nav process had it; None: not yet.

    `problem` says why it was not even sent.
    """

    kind: CommandKind
    argument: str
    said_s: float
    sequence: int
    acknowledged_s: float | None = None
    problem: str = ""

    @property
    def name(self) -> str:
        return self.kind.name.replace("_", " ")

    def text(self, now_s: float) -> str:
        """For a screen: `STOP acknowledged (32 ms)`, `STOP NOT ACKNOWLEDGED`, `STOP sent`."""
        if self.acknowledged_s is not None:
            return f"{self.name} acknowledged ({1e3 * self.acknowledged_s:.0f} ms)"
        if self.problem:
            return f"{self.name} NOT SENT: {self.problem}"
        return f"{self.name} NOT ACKNOWLEDGED" if self.is_late(now_s) else f"{self.name} sent"

    def is_late(self, now_s: float) -> bool:
        return self.acknowledged_s is None and (bool(self.problem) or now_s - self.said_s > ACK_LIMIT_S)


class CommandPort:
    """Says words to the nav process of one prefix. For one thread; `poll` a few times in 100 ms while it is `waiting`.

    Args:
        clock: monotonic seconds
    """

    def __init__(self, prefix: str, clock: Callable[[], float] = time.monotonic) -> None:
        self._prefix, self._clock = prefix, clock
        self._ack = channels.open_command_ack_reader(prefix)
        self._said: deque[Said] = deque(maxlen=HISTORY)
        self._repeated_s = 0.0

    @property
    def last(self) -> Said | None:
        """The last word that a person has to know about; manual drive's repetitions are not among them."""
        return self._said[-1] if self._said else None

    @property
    def waiting(self) -> bool:
        """Whether some word is on its way, or a STOP has to be said again."""
        return any(
            said.acknowledged_s is None and (not said.problem or said.kind is CommandKind.STOP)
            for said in self._said
        )

    def go(self) -> Said:
        return self.say(CommandKind.GO)

    def stop(self) -> Said:
        return self.say(CommandKind.STOP)

    def load(self, mission: str) -> Said:
        """Another mission, by path or by its name in trees/."""
        return self.say(CommandKind.LOAD, mission)

    def target(self, spec: TargetSpec | None) -> Said:
        """Another target; None: that of the mission."""
        sizes_m = (spec.height_m, spec.width_m, spec.lidar_width_m) if spec is not None else ()
        text = ",".join((spec.class_name, *(f"{size:g}" for size in sizes_m))) if spec is not None else ""
        return self.say(CommandKind.TARGET, text)

    def setting(self, key: str, value: object) -> Said:
        return self.say(CommandKind.SETTING, setting_text(key, value))

    def firmware(self, line: str) -> Said:
        return self.say(CommandKind.FIRMWARE, line)

    def drive(self, twist: Twist2D) -> Said:
        """One word of a hold; say it again within the deadman's time or the wheels stop. Zero ends the hold at once."""
        return self._push(CommandKind.MANUAL, manual_text(twist))

    def say(self, kind: CommandKind, argument: str = "") -> Said:
        """Never raises: what went wrong stands in the answer."""
        said = self._push(kind, argument)
        self._said.append(said)
        self._repeated_s = said.said_s
        return said

    def poll(self) -> Said | None:
        """See what has been acknowledged since; `last` with that."""
        now_s = self._clock()
        if not self.waiting:
            return self.last
        consumed, stamp_s = self._consumed()
        for index, said in enumerate(self._said):
            if said.acknowledged_s is None and not said.problem and consumed >= said.sequence:
                took_s = max(min(now_s, stamp_s) - said.said_s, 0.0)
                self._said[index] = replace(said, acknowledged_s=took_s)
        last = self.last
        assert last is not None, "waiting says there is one"
        if last.kind is CommandKind.STOP and last.is_late(now_s) and now_s - last.said_s < FORGET_S:
            self._repeat_stop(last, now_s)
        self._said = deque(
            (
                s
                for s in self._said
                if s.acknowledged_s is not None or now_s - s.said_s < FORGET_S or s is last
            ),
            maxlen=HISTORY,
        )
        return self.last

    def poll_for(self, said: Said) -> Said:
        """As `poll`, for a word that need not be the last one."""
        self.poll()
        same = (s for s in self._said if (s.kind, s.said_s) == (said.kind, said.said_s))
        return next(same, said)

    def close(self) -> None:
        self._ack.close()

    def _repeat_stop(self, stop: Said, now_s: float) -> None:
        if now_s - self._repeated_s < REPEAT_STOP_S:
            return
        self._repeated_s = now_s
        again = self._push(CommandKind.STOP, "")
        if not again.problem:
            self._said[-1] = replace(stop, sequence=again.sequence, problem="")

    def _push(self, kind: CommandKind, argument: str) -> Said:
        now_s = self._clock()
        try:
            with contextlib.closing(channels.open_command_writer(self._prefix)) as writer:
                if writer.push(Command(now_s, kind, argument)):
                    return Said(kind, argument, now_s, writer.last_sequence)
                return Said(kind, argument, now_s, 0, problem="the nav process does not listen")
        except DeviceError as error:
            return Said(kind, argument, now_s, 0, problem=str(error))

    def _consumed(self) -> tuple[int, float]:
        try:
            ack = self._ack.latest()
        except DeviceError:
            return 0, 0.0
        return (ack.consumed, ack.stamp_s) if ack is not None else (0, 0.0)

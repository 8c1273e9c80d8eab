"""The operator's words on their way to the nav process: one at a time, in a thread of their own, with their answers.

A claim of the command ring may wait for another screen's, so none of it happens in the server's loop. Manual drive
keeps only the newest hold: one that could not be said in time is worth nothing. The server never repeats a hold by
itself; each one is a message of a person's browser, so whatever breaks on the way stops the robot.
"""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

from target_nav.config import Config
from target_nav.errors import ConfigError
from target_nav.gui.commands import CommandPort, Said
from target_nav.gui.manual import DIRECTIONS, ManualPad
from target_nav.state.types import STOP, CommandKind, Twist2D

POLL_S = 0.004
REPEAT_POLL_S = 0.05
LEASE_S = 0.5
"""So long after somebody's last hold nobody else may drive."""
HOLD_OLD_S = 0.15
"""A hold that took so much longer than the fastest one is from before a jam of the network: it is not driven."""
CLOCK_WINDOW_S = 30.0


class OperatorDesk:
    """
    Args:
        port: from here on only the desk's thread touches it
        config: asks for the present configuration
    """

    def __init__(self, port: CommandPort, config: Callable[[], Config]) -> None:
        self._port, self._config = port, config
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="desk")
        self._driver: object | None = None
        self._driven_s = -math.inf
        self._next_twist: Twist2D | None = None
        self._driving: asyncio.Task[None] | None = None
        self._repeating: asyncio.Task[None] | None = None
        self.last: Said | None = None
        """The newest word that people have to know about."""
        self.drive_problem = ""

    @property
    def driver(self) -> object | None:
        """Who drives by hand now."""
        return self._driver if time.monotonic() - self._driven_s < LEASE_S else None

    # -- words ---------------------------------------------------------------------------------------------------------

    async def say(self, kind: CommandKind, argument: str = "") -> dict[str, Any]:
        """Say it, wait for the acknowledgement as long as that may take, and tell what came of it."""
        said = await self._in_thread(lambda: self._port.say(kind, argument))
        self.last = said
        while said.acknowledged_s is None and not said.problem and not said.is_late(time.monotonic()):
            await asyncio.sleep(POLL_S)
            said = await self._in_thread(partial(self._port.poll_for, said))
        if self.last is not None and self.last.said_s <= said.said_s:
            self.last = said
        if self._port.waiting and (self._repeating is None or self._repeating.done()):
            self._repeating = asyncio.get_running_loop().create_task(self._repeat())
        return told(said)

    async def _repeat(self) -> None:
        """A STOP that nobody acknowledged is said again; and a late acknowledgement is seen."""
        while self._port.waiting:
            await asyncio.sleep(REPEAT_POLL_S)
            self.last = await self._in_thread(lambda: self._port.poll()) or self.last
            if self.last is None or time.monotonic() - self.last.said_s > 2 * LEASE_S + 3.0:
                return

    # -- driving by hand -----------------------------------------------------------------------------------------------

    def hold(self, who: object, directions: Iterable[str]) -> None:
        """One word of a hold by `who`; no directions: released.

        Raises:
            ConfigError: no such direction, or somebody else drives.
        """
        now_s = time.monotonic()
        pad = ManualPad()
        for direction in directions:
            if direction not in DIRECTIONS:
                raise ConfigError(f"{direction!r} is no direction; there are {', '.join(DIRECTIONS)}")
            pad.hold(direction)
        if not pad.held:
            if self._driver is who:
                self._driver = None
                self._drive(STOP)
            return
        if self._driver is not None and self._driver is not who and now_s - self._driven_s < LEASE_S:
            raise ConfigError("somebody else drives; wait until they let go")
        self._driver, self._driven_s = who, now_s
        self._drive(pad.twist(self._config()))

    def leave(self, who: object) -> None:
        """`who` has gone: what they held is released."""
        if self._driver is who:
            self._driver = None
            self._drive(STOP)

    def _drive(self, twist: Twist2D) -> None:
        self._next_twist = twist
        if self._driving is None or self._driving.done():
            self._driving = asyncio.get_running_loop().create_task(self._drive_on())

    async def _drive_on(self) -> None:
        while (twist := self._next_twist) is not None:
            self._next_twist = None
            said = await self._in_thread(partial(self._port.drive, twist))
            self.drive_problem = said.problem

    # ------------------------------------------------------------------------------------------------------------------

    async def close(self) -> None:
        for task in (self._driving, self._repeating):
            if task is not None and not task.done():
                task.cancel()
        if self._driver is not None:
            await self._in_thread(lambda: self._port.drive(STOP))
        await self._in_thread(self._port.close)
        self._thread.shutdown(wait=True)

    async def _in_thread(self, work: Callable[[], Any]) -> Any:
        return await asyncio.get_running_loop().run_in_executor(self._thread, work)


class FarClock:
    """How late a far clock's messages are, beyond the fastest of them. Both clocks may show any time."""

    def __init__(self) -> None:
        self._best: float = math.inf
        self._recent: float = math.inf
        self._since_s = -math.inf

    def lateness_s(self, here_s: float, there_s: float) -> float:
        """The fastest of the last minute counts, so that clocks may drift apart."""
        offset = here_s - there_s
        if here_s - self._since_s > CLOCK_WINDOW_S:
            self._best, self._recent, self._since_s = self._recent, math.inf, here_s
        self._recent = min(self._recent, offset)
        return offset - min(self._best, self._recent)


def told(said: Said) -> dict[str, Any]:
    """For a screen."""
    now_s = time.monotonic()
    return {
        "word": said.name,
        "argument": said.argument,
        "acknowledged": said.acknowledged_s is not None,
        "took_ms": None if said.acknowledged_s is None else round(1e3 * said.acknowledged_s),
        "late": said.is_late(now_s),
        "problem": said.problem,
        "text": said.text(now_s),
        "at_s": round(said.said_s, 3),
    }

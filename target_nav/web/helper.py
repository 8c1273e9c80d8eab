"""A helper process for what takes long or much memory: asked by a line of JSON, answering by one.

It is started when it is needed and ended when nobody has asked for a minute. One that does not answer in time is
killed; the next question gets a new one.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
from collections.abc import Sequence
from typing import Any

from target_nav.errors import DeviceError, TargetNavError

log = logging.getLogger(__name__)

IDLE_S = 60.0
ANSWER_LIMIT = 64 * 1024 * 1024


class HelperError(TargetNavError):
    """What the helper answered instead of a value: in words for the person who asked."""


class Helper:
    """
    Args:
        argv: the program; it ends by itself when its standard input is closed
        patience_s: how long one answer may take
    """

    def __init__(self, argv: Sequence[str], patience_s: float, idle_s: float = IDLE_S) -> None:
        self._argv, self._patience_s, self._idle_s = argv, patience_s, idle_s
        self._process: asyncio.subprocess.Process | None = None
        self._lock = asyncio.Lock()
        self._ender: asyncio.TimerHandle | None = None

    @property
    def running(self) -> bool:
        return self._process is not None

    async def ask(self, what: str, **arguments: Any) -> Any:
        """
        Raises:
            HelperError: the answer is an error.
            DeviceError: there is no answer.
        """
        async with self._lock:
            self._stay()
            try:
                process = await self._started()
                assert process.stdin is not None
                assert process.stdout is not None
                process.stdin.write(json.dumps({"what": what, **arguments}).encode() + b"\n")
                await process.stdin.drain()
                line = await asyncio.wait_for(process.stdout.readline(), self._patience_s)
            except asyncio.TimeoutError:
                await self._kill()
                raise DeviceError(
                    f"{what}: no answer within {self._patience_s:g} s; is the file very large?"
                ) from None
            except (OSError, ValueError) as error:
                await self._kill()
                raise DeviceError(f"{what}: the helper process failed: {error}") from error
            except asyncio.CancelledError:
                await self._kill()
                raise
            finally:
                self._leave_when_idle()
            if not line:
                await self._kill()
                raise DeviceError(f"{what}: the helper process died; its last words are on standard error")
            answer = json.loads(line)
            if "error" in answer:
                raise HelperError(answer["error"])
            return answer["value"]

    async def close(self) -> None:
        self._stay()
        await self._kill()

    async def _started(self) -> asyncio.subprocess.Process:
        if self._process is None or self._process.returncode is not None:
            self._process = await asyncio.create_subprocess_exec(
                *self._argv,
                stdin=asyncio.subprocess.PIPE,
                stdout=asyncio.subprocess.PIPE,
                limit=ANSWER_LIMIT,
                start_new_session=True,
            )
        return self._process

    async def _kill(self) -> None:
        process, self._process = self._process, None
        if process is None:
            return
        with contextlib.suppress(ProcessLookupError):
            process.kill()
        await process.wait()

    def _stay(self) -> None:
        if self._ender is not None:
            self._ender.cancel()
            self._ender = None

    def _leave_when_idle(self) -> None:
        self._stay()
        loop = asyncio.get_running_loop()
        self._ender = loop.call_later(self._idle_s, lambda: loop.create_task(self._end_idle()))

    async def _end_idle(self) -> None:
        async with self._lock:
            await self._kill()

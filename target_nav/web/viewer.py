"""One page that looks: it gets the newest there is as fast as it takes it, and never anything old.

Nothing is queued. A viewer has a credit of messages on their way; while it is used up new looks replace each other in
the feed, and when the page says it has drawn one, the newest sections that changed since then go out. Buffers of the
system hide a slow reader, therefore the page itself must say so.
"""

from __future__ import annotations

import asyncio
import json
import logging
import struct
import time
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from target_nav.errors import TargetNavError
from target_nav.web.access import Role
from target_nav.web.console import Console, RawJson
from target_nav.web.desk import HOLD_OLD_S, FarClock, told
from target_nav.web.encode import dumps, joined
from target_nav.web.feed import Look

log = logging.getLogger(__name__)

VIEWS_ON_THE_WAY = 2
PICTURES_ON_THE_WAY = 1
MARKS_AT_ONCE = 1500
ASKED_AT_ONCE = 8
HELLO_LIMIT_S = 5.0
SILENT_LIMIT_S, HIDDEN_LIMIT_S = 15.0, 150.0
"""A page says something every few seconds; one that does not is gone. Browsers let a hidden one run once a minute."""
PICTURE_HEAD = struct.Struct("<II")
"""Before the JPEG: its number, its age in milliseconds."""

WRONG_TOKEN, BAD_MESSAGE, TOO_SILENT, TOO_MANY = 4401, 4400, 4408, 4429


class Viewer:
    """One WebSocket, from hello to its end."""

    def __init__(self, socket: WebSocket, console: Console, peer: str) -> None:
        self._socket, self._console, self._peer = socket, console, peer
        self.role = Role.SPECTATOR
        self.wants_pictures = False
        self._wants_views = True
        self._wake = asyncio.Event()
        self._sending = asyncio.Lock()
        self._asked: set[asyncio.Task[None]] = set()
        self._sent_look = 0
        self._views_sent = self._views_seen = 0
        self._pictures_sent = self._pictures_seen = 0
        self._picture_number = 0
        self._next_mark = 0
        self._own_sent: dict[str, str] = {}
        self._clock = FarClock()
        self._heard_s = time.monotonic()

    def wake(self) -> None:
        self._wake.set()

    async def serve(self, crowded: bool) -> None:
        """Returns when the page has gone, for whatever reason. `crowded`: there is room for operators only."""
        role = await self._hello()
        if role is None:
            return
        if crowded and role is Role.SPECTATOR:
            await self._close(TOO_MANY, "too many spectators")
            return
        self.role = role
        sender = asyncio.create_task(self._send_on())
        try:
            await self._receive_on()
        except WebSocketDisconnect:
            pass
        finally:
            # before anything that waits: whatever this page held is let go
            self._console.desk.leave(self)
            sender.cancel()
            for task in tuple(self._asked):
                task.cancel()
            await asyncio.gather(sender, *self._asked, return_exceptions=True)

    # -- what the page says --------------------------------------------------------------------------------------------

    async def _hello(self) -> Role | None:
        try:
            message = await asyncio.wait_for(self._receive(), HELLO_LIMIT_S)
        except (asyncio.TimeoutError, WebSocketDisconnect, ValueError):
            await self._close(BAD_MESSAGE, "the first message must be a hello")
            return None
        token = message.get("token")
        role = self._console.access.role(token if isinstance(token, str) else None, self._peer)
        if message.get("t") != "hello" or role is None:
            await asyncio.sleep(0.3)
            await self._close(WRONG_TOKEN, "wrong token")
            return None
        await self._send(dumps({"t": "welcome", "role": role.value, "peer": self._peer}))
        return role

    async def _receive(self) -> dict[str, Any]:
        """
        Raises:
            ValueError: not a JSON object.
        """
        text = await self._socket.receive_text()
        self._heard_s = time.monotonic()
        message = json.loads(text)
        if not isinstance(message, dict):
            raise ValueError("a message must be a JSON object")
        return message

    async def _receive_on(self) -> None:
        while True:
            try:
                message = await self._receive()
            except (ValueError, KeyError, RecursionError):
                await self._close(BAD_MESSAGE, "a message must be a JSON object")
                return
            kind = message.get("t")
            if kind == "seen":
                self._views_seen = max(self._views_seen, _whole(message.get("views")))
                self._pictures_seen = max(self._pictures_seen, _whole(message.get("pictures")))
                self._wake.set()
            elif kind == "hold":
                await self._hold(message)
            elif kind == "want":
                self.wants_pictures = message.get("pictures") is True
                self._wants_views = message.get("views") is not False
                self._wake.set()
            elif kind == "ask":
                await self._ask(message)

    async def _hold(self, message: dict[str, Any]) -> None:
        """A word of a hold. One that was held up on its way is not driven: it says what was, not what is."""
        held, at_ms = message.get("held"), message.get("at")
        if (
            self.role is not Role.OPERATOR
            or not isinstance(held, list)
            or not isinstance(at_ms, (int, float))
        ):
            return
        late_s = self._clock.lateness_s(time.monotonic(), at_ms / 1e3)
        if held and late_s > HOLD_OLD_S:
            return
        try:
            self._console.desk.hold(self, [str(direction) for direction in held[:8]])
        except TargetNavError as error:
            await self._send(dumps({"t": "refused", "what": "drive", "why": str(error)}))

    async def _ask(self, message: dict[str, Any]) -> None:
        what, number = str(message.get("what")), message.get("id")
        if len(self._asked) >= ASKED_AT_ONCE and what != "stop":
            await self._send(dumps({"t": "answer", "id": number, "error": "too many questions at once"}))
            return
        task = asyncio.create_task(self._answer(what, number, message.get("args")))
        self._asked.add(task)
        task.add_done_callback(self._asked.discard)

    async def _answer(self, what: str, number: Any, arguments: Any) -> None:
        arguments = arguments if isinstance(arguments, dict) else {}
        try:
            value = await self._console.answer(what, arguments, self.role, self._peer)
            text = value.text if isinstance(value, RawJson) else dumps(value)
            reply = f'{{"t":"answer","id":{dumps(number)},"value":{text}}}'
        except TargetNavError as error:
            reply = dumps({"t": "answer", "id": number, "error": str(error)})
        except Exception:
            log.exception("question %s from %s", what, self._peer)
            reply = dumps({"t": "answer", "id": number, "error": "the console failed; its log says why"})
        await self._send(reply)

    # -- what the page gets --------------------------------------------------------------------------------------------

    async def _send_on(self) -> None:
        while True:
            await self._wake.wait()
            self._wake.clear()
            limit_s = SILENT_LIMIT_S if self._wants_views else HIDDEN_LIMIT_S
            if time.monotonic() - self._heard_s > limit_s:
                await self._close(TOO_SILENT, "nothing heard from this page")
                return
            try:
                await self._send_news(self._console.feed.latest)
            except (RuntimeError, WebSocketDisconnect):
                # it has been closed; the receiving side sees that too
                return

    async def _send_news(self, look: Look) -> None:
        if self._wants_views and self._views_sent - self._views_seen < VIEWS_ON_THE_WAY:
            news = self._news(look)
            if news:
                self._views_sent += 1
                await self._send(f'{{"t":"views","n":{self._views_sent},{joined(news)}}}')
        picture = look.picture
        if (
            self.wants_pictures
            and picture is not None
            and picture.number != self._picture_number
            and self._pictures_sent - self._pictures_seen < PICTURES_ON_THE_WAY
        ):
            self._picture_number = picture.number
            self._pictures_sent += 1
            age_ms = min(max(0, round(1e3 * (time.monotonic() - picture.stamp_s))), 0xFFFFFFFF)
            async with self._sending:
                await self._socket.send_bytes(PICTURE_HEAD.pack(self._pictures_sent, age_ms) + picture.data)

    def _news(self, look: Look) -> dict[str, str]:
        """Sections that changed since the last message to this page."""
        if look.number == self._sent_look:
            return {}
        news = {name: look.sections[name] for name, at in look.versions.items() if at > self._sent_look}
        self._sent_look = look.number
        console = self._console
        desk = console.desk
        own = {
            "said": dumps(told(desk.last) if desk.last is not None else None),
            "drive": dumps(
                {"mine": desk.driver is self, "taken": desk.driver is not None, "problem": desk.drive_problem}
            ),
            "versions": dumps({"settings": console.settings_version, "files": console.files_version}),
        }
        news.update({name: text for name, text in own.items() if self._own_sent.get(name) != text})
        self._own_sent = own
        with console.feed.lock:
            begin, end = console.feed.timeline.begin, console.feed.timeline.end
            marks = console.feed.timeline.marks(self._next_mark, MARKS_AT_ONCE)
        if marks:
            self._next_mark = marks[-1][0] + 1
            news["marks"] = dumps({"begin": begin, "end": end, "add": marks})
        return news

    async def _send(self, text: str) -> None:
        async with self._sending:
            await self._socket.send_text(text)

    async def _close(self, code: int, reason: str) -> None:
        try:
            async with self._sending:
                await self._socket.close(code, reason)
        except (RuntimeError, WebSocketDisconnect):
            pass


def _whole(value: Any) -> int:
    return value if isinstance(value, int) else 0

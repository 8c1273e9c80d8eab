"""A console that is really served, on a port of its own, and a page that talks to it: both of the libraries in use."""

from __future__ import annotations

import asyncio
import json
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from websockets.sync.client import ClientConnection, connect

from target_nav.app.commands.web import console_of
from target_nav.config import Config
from target_nav.gui.settings import Settings
from target_nav.ipc import channels
from target_nav.state.types import Command
from target_nav.web.access import Access
from target_nav.web.console import Console
from target_nav.web.server import Site, bind, make_server

TOKEN = "a-token-of-tests"
PATIENCE_S = 10.0


class Page:
    """One WebSocket, as a browser's page holds it; `answer` leaves out what is not the answer."""

    def __init__(self, socket: ClientConnection, token: str | None) -> None:
        self.socket = socket
        self._next = 0
        self.last: dict[str, Any] = {}
        self.say({"t": "hello", "token": token})

    def say(self, message: dict[str, Any]) -> None:
        self.socket.send(json.dumps(message))

    def receive(self, timeout_s: float = PATIENCE_S) -> Any:
        """The next message; a picture as bytes."""
        data = self.socket.recv(timeout=timeout_s)
        return data if isinstance(data, bytes) else json.loads(data)

    def until(self, wanted: Callable[[Any], bool], seeing: bool = True) -> Any:
        """The first message that is wanted; those before it are seen, as a page does."""
        deadline_s = time.monotonic() + PATIENCE_S
        while time.monotonic() < deadline_s:
            message = self.receive()
            if seeing and not isinstance(message, bytes) and message["t"] == "views":
                self.last = {**self.last, **message}
                self.say({"t": "seen", "views": message["n"], "pictures": 0})
            if wanted(message):
                return message
        raise AssertionError(f"not within {PATIENCE_S:g} s")

    def views(self) -> dict[str, Any]:
        found: dict[str, Any] = self.until(lambda m: isinstance(m, dict) and m["t"] == "views")
        return found

    def ask(self, what: str, **arguments: Any) -> dict[str, Any]:
        """The answer: with `value`, or with `error`."""
        self._next += 1
        number = self._next
        self.say({"t": "ask", "id": number, "what": what, "args": arguments})
        answer: dict[str, Any] = self.until(lambda m: isinstance(m, dict) and m.get("id") == number)
        return answer

    def hold(self, *directions: str, at_ms: float | None = None) -> None:
        at_ms = 1e3 * time.monotonic() if at_ms is None else at_ms
        self.say({"t": "hold", "at": at_ms, "held": list(directions)})


class Served:
    def __init__(self, prefix: str, folder: Path) -> None:
        self.prefix, self.folder = prefix, folder
        self.missions, self.runs = folder / "missions", folder / "runs"
        self.missions.mkdir(exist_ok=True)
        self.settings_file = folder / "settings.yaml"
        config = Config().override({"ipc.prefix": prefix})
        self.settings = Settings(config, self.settings_file, config)
        self.access = Access(TOKEN)
        self._listener = bind("127.0.0.1", 0)
        self.port: int = self._listener.getsockname()[1]
        self.site = Site(self._make)
        self._server = make_server(self.site)
        self._thread = threading.Thread(target=self._run)
        self._thread.start()
        deadline_s = time.monotonic() + PATIENCE_S
        while not self._server.started:
            assert time.monotonic() < deadline_s, "the server does not start"
            time.sleep(0.01)

    @property
    def console(self) -> Console:
        return self.site.console

    def close(self) -> None:
        self._server.should_exit = True
        self._thread.join(PATIENCE_S)
        self._listener.close()
        assert not self._thread.is_alive()

    @contextmanager
    def page(self, token: str | None = TOKEN, **options: Any) -> Iterator[Page]:
        with connect(f"ws://127.0.0.1:{self.port}/ws", compression=None, **options) as socket:
            yield Page(socket, token)

    def _make(self, wake: Callable[[], None]) -> Console:
        return console_of(self.settings, self.access, self.missions, self.runs, wake)

    def _run(self) -> None:
        asyncio.run(self._server.serve(sockets=[self._listener]))


class Ear:
    """Stands for the nav process at the command ring: takes what comes, and so acknowledges it, while `listening`."""

    def __init__(self, prefix: str) -> None:
        self.heard: list[Command] = []
        self.listening = True
        self._reader = channels.open_command_reader(prefix)
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def wait_for(self, wanted: Callable[[list[Command]], bool], what: str) -> list[Command]:
        deadline_s = time.monotonic() + PATIENCE_S
        while not wanted(list(self.heard)):
            assert time.monotonic() < deadline_s, f"in vain: {what}; heard {self.heard}"
            time.sleep(0.005)
        return list(self.heard)

    def close(self) -> None:
        self._end.set()
        self._thread.join()
        self._reader.close()

    def _run(self) -> None:
        while not self._end.wait(0.005):
            if self.listening:
                self.heard += self._reader.pop_all()

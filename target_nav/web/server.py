"""The server: a page, a WebSocket, and two addresses for programs. Loopback unless told otherwise."""

from __future__ import annotations

import asyncio
import contextlib
import ctypes
import errno
import json
import logging
import signal
import socket
from collections.abc import AsyncIterator, Callable, Iterator
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocket

from target_nav.errors import ConfigError, DeviceError, TargetNavError
from target_nav.web.access import Role
from target_nav.web.console import AccessRefused, Console
from target_nav.web.encode import joined
from target_nav.web.static_files import StaticTable
from target_nav.web.viewer import Viewer

log = logging.getLogger(__name__)

MOST_MESSAGE_BYTES = 2_000_000
MOST_BODY_BYTES = 100_000
MOST_SPECTATORS, MOST_VIEWERS = 24, 32
"""So that spectators never keep an operator out."""
_M_TRIM_THRESHOLD, _M_MMAP_THRESHOLD, _M_ARENA_MAX = -1, -3, -8
"""Of glibc's malloc.h."""
_LARGE_BLOCK_BYTES = 256 * 1024
_PUBLIC: tuple[str, ...] = ("status", "arrival", "tree")

HEADERS = {
    b"content-security-policy": b"default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
    b"connect-src 'self'; manifest-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    b"x-content-type-options": b"nosniff",
    b"referrer-policy": b"no-referrer",
    b"cross-origin-opener-policy": b"same-origin",
    b"cross-origin-resource-policy": b"same-origin",
    b"cache-control": b"no-cache",
}

ConsoleMaker = Callable[[Callable[[], None]], Console]


class Site:
    """The ASGI application around one console.

    Args:
        make: makes the console; it is handed what to call after every look
    """

    def __init__(self, make: ConsoleMaker) -> None:
        self._loop: asyncio.AbstractEventLoop | None = None
        self._viewers: set[Viewer] = set()
        self._files = StaticTable()
        self.console = make(self._look_is_there)
        routes = [
            Route("/", self._page),
            WebSocketRoute("/ws", self._socket),
            Route("/api/status", self._status),
            Route("/api/{what}", self._api, methods=["POST"]),
            Route("/static/{name:path}", self._static),
        ]
        self.app: ASGIApp = _Guard(Starlette(routes=routes, lifespan=self._lifespan), self.console)

    @property
    def viewers(self) -> int:
        return len(self._viewers)

    @contextlib.asynccontextmanager
    async def _lifespan(self, app: Starlette) -> AsyncIterator[None]:
        self._loop = asyncio.get_running_loop()
        self.console.feed.start()
        try:
            yield
        finally:
            await self.console.close()

    def _look_is_there(self) -> None:
        """In the feed's thread."""
        if self._loop is not None and not self._loop.is_closed():
            with contextlib.suppress(RuntimeError):
                self._loop.call_soon_threadsafe(self._wake)

    def _wake(self) -> None:
        self.console.feed.pictures_wanted = any(viewer.wants_pictures for viewer in self._viewers)
        for viewer in self._viewers:
            viewer.wake()

    async def _page(self, request: Request) -> Response:
        return self._files.answer("index.html", request)

    async def _static(self, request: Request) -> Response:
        return self._files.answer(request.path_params["name"], request)

    async def _socket(self, socket: WebSocket) -> None:
        headers = socket.headers
        peer = _peer(socket.client)
        if not self.console.access.origin_is_ours(headers.get("origin"), headers.get("host")):
            log.warning("refused a page of %s, opened by %s", headers.get("origin"), peer)
            await socket.close(1008)
            return
        if len(self._viewers) >= MOST_VIEWERS:
            await socket.close(1013)
            return
        await socket.accept()
        viewer = Viewer(socket, self.console, peer)
        self._viewers.add(viewer)
        try:
            await viewer.serve(crowded=len(self._viewers) > MOST_SPECTATORS)
        finally:
            self._viewers.discard(viewer)

    async def _status(self, request: Request) -> Response:
        """What everybody may see, for programs: status, arrival, tree."""
        if self._role(request) is None:
            return _error(401, "wrong token")
        sections = self.console.feed.latest.sections
        wanted: dict[str, str] = {name: sections[name] for name in _PUBLIC if name in sections}
        return Response(f"{{{joined(wanted)}}}", media_type="application/json")

    async def _api(self, request: Request) -> Response:
        """A question as the page asks it: `POST /api/go`, arguments as a JSON object in the body."""
        role = self._role(request)
        if role is None:
            return _error(401, "wrong token")
        try:
            arguments = await _arguments(request)
            value = await self.console.answer(
                request.path_params["what"], arguments, role, _peer(request.client)
            )
        except AccessRefused as error:
            return _error(401, str(error))
        except TargetNavError as error:
            return _error(400, str(error))
        return (
            JSONResponse(value)
            if not hasattr(value, "text")
            else Response(value.text, media_type="application/json")
        )

    def _role(self, request: Request) -> Role | None:
        return self.console.access.bearer_role(request.headers.get("authorization"), _peer(request.client))


async def _arguments(request: Request) -> dict[str, Any]:
    """
    Raises:
        ConfigError: too long, or no JSON object.
    """
    body = b""
    async for part in request.stream():
        body += part
        if len(body) > MOST_BODY_BYTES:
            raise ConfigError(f"more than {MOST_BODY_BYTES} bytes")
    if not body:
        return {}
    try:
        arguments = json.loads(body)
    except (ValueError, RecursionError):
        arguments = None
    if not isinstance(arguments, dict):
        raise ConfigError("the body must be a JSON object of arguments")
    return arguments


class _Guard:
    """Refuses requests for another host's name, and puts the security headers on every answer."""

    def __init__(self, app: ASGIApp, console: Console) -> None:
        self._app, self._console = app, console

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        host = next((value.decode("latin-1") for name, value in scope["headers"] if name == b"host"), None)
        if not self._console.access.host_is_ours(host):
            log.warning("refused a request for host %r; is it a name of this machine? (--name)", host)
            if scope["type"] == "websocket":
                await WebSocket(scope, receive, send).close(1008)
            else:
                await PlainTextResponse("unknown host; see --name", 421)(scope, receive, send)
            return

        async def with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                message["headers"] = [*message["headers"], *HEADERS.items()]
            await send(message)

        await self._app(scope, receive, with_headers)


def bind(host: str, port: int) -> socket.socket:
    """
    Raises:
        DeviceError: the address is taken, or is not of this machine.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    listener = socket.socket(family, socket.SOCK_STREAM)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((host, port))
    except OSError as error:
        listener.close()
        advice = (
            "is another console running? choose another --port"
            if error.errno == errno.EADDRINUSE
            else "see --host"
        )
        raise DeviceError(f"cannot listen on {host}:{port}: {error.strerror}; {advice}") from error
    return listener


def keep_small() -> None:
    """Two heaps for all threads, and large blocks (pictures) outside of them, so that what is freed is given back.

    Left alone, glibc gives each thread a heap of its own, puts pictures into them once some were freed, and a small
    block behind a large hole keeps the hole.
    """
    with contextlib.suppress(OSError, AttributeError):
        libc = ctypes.CDLL(None)
        libc.mallopt(_M_ARENA_MAX, 2)
        libc.mallopt(_M_MMAP_THRESHOLD, _LARGE_BLOCK_BYTES)
        libc.mallopt(_M_TRIM_THRESHOLD, _LARGE_BLOCK_BYTES)
        libc.malloc_trim(0)


def make_server(site: Site) -> Server:
    return Server(
        uvicorn.Config(
            site.app,
            log_level="warning",
            access_log=False,
            server_header=False,
            ws="websockets-sansio",
            ws_max_size=MOST_MESSAGE_BYTES,
            # on a robot's processor packing costs more than the wire
            ws_per_message_deflate=False,
            lifespan="on",
            timeout_graceful_shutdown=2,
            limit_concurrency=200,
        )
    )


async def serve(site: Site, listener: socket.socket) -> None:
    """Until SIGINT, SIGTERM or SIGHUP."""
    server = make_server(site)
    loop = asyncio.get_running_loop()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        loop.add_signal_handler(number, server.end)
    await server.serve(sockets=[listener])


class Server(uvicorn.Server):
    """Signals are this module's business: uvicorn's own handling raises them again at the end."""

    def end(self) -> None:
        self.should_exit = True

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        yield


def _peer(client: Any) -> str:
    return client.host if client is not None else "-"


def _error(code: int, text: str) -> JSONResponse:
    return JSONResponse({"error": text}, code)

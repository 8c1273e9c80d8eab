"""Groot2's live monitor: shows the running tree in Groot2, with statuses, blackboard, breakpoints and forced results.

    tree_executor --ros-args -p groot_port:=1667      off (0) by default; needs the extra `groot`

A thread answers Groot2's questions; the tick's thread takes notes while somebody asks. A breakpoint does not stop the
loop: the tree is held, nobody asks for motion, so the robot brakes and stands while /cmd_vel goes on. When Groot2 goes
away in the middle of it, the mission stays paused until the operator speaks.
"""

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import Any
from uuid import uuid4

from py_trees.behaviour import Behaviour
from py_trees.blackboard import Blackboard

from target_nav.app.groot_monitor_hooks import HookTable
from target_nav.app.groot_monitor_protocol import (
    IDLE_FROM,
    STATUS_OF,
    Kind,
    NodeStatus,
    ProtocolError,
    Request,
    parse_request,
    reply_header,
    request_header,
    status_bytes,
    transition_bytes,
)
from target_nav.app.groot_monitor_tree import GrootTree, groot_tree
from target_nav.errors import DeviceError
from target_nav.mission.nodes.ticking import SKIPPED_MESSAGE
from target_nav.mission.tree_note import TreeNote

POLL_MS = 20
HEARTBEAT_S = 5.0
"""BehaviorTree.CPP takes Groot2 for gone after so long without a question."""
MOST_TRANSITIONS = 1000

log = logging.getLogger(__name__)


class GrootMonitor:
    """Implements `tree_streams.NoteTaker`.

    Args:
        root: the running tree
        path: the mission's file
        port: Groot2 asks there; news go out on the next one
        hold: called with True when a breakpoint holds the tree, with False when it goes on
        pause: called when Groot2 is gone while a breakpoint holds the tree
        clock: monotonic seconds

    Raises:
        DeviceError: ZeroMQ is not installed, or a port is taken.
    """

    def __init__(
        self,
        root: Behaviour,
        path: Path | None,
        port: int,
        hold: Callable[[bool], None] = lambda held: None,
        pause: Callable[[], None] = lambda: None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        try:
            import msgpack
            import zmq
        except ImportError as error:
            raise DeviceError(
                f"Groot2's monitor needs ZeroMQ and MessagePack ({error}): pip install 'target_nav[groot]'"
            ) from error
        self._zmq, self._pack = zmq, msgpack.packb
        self._path, self._clock, self._pause = path, clock, pause
        self._hooks = HookTable(hold)
        self._asked_s: float | None = None
        self._recording_since_s: float | None = None
        self._transitions: deque[tuple[int, int, int]] = deque(maxlen=MOST_TRANSITIONS)
        self._closed = False
        self.watch(root)
        self._context = zmq.Context()
        self._server = self._bind(zmq.REP, port)
        self._news = self._bind(zmq.PUB, port + 1)
        self._thread = threading.Thread(target=self._serve, name="groot monitor", daemon=True)
        self._thread.start()
        log.info("Groot2 may connect to port %d", port)

    # -- in the tick's thread ------------------------------------------------------------------------------------------

    def watch(self, root: Behaviour) -> None:
        """Another tree from now on; Groot2 learns of it by the tree's new id."""
        self._hooks.remove_all()
        self._root = root
        self._tree: GrootTree | None = None
        self._tree_id = uuid4()
        self._codes: dict[Behaviour, int] = dict.fromkeys(root.iterate(), NodeStatus.IDLE)

    def wants_note(self) -> bool:
        return self._asked_s is not None

    def take(self, note: TreeNote) -> None:
        if note.root is not self._root:
            return
        codes = self._codes
        now_us = round(1e6 * (self._clock() - (self._recording_since_s or 0.0)))
        for node, status, message in zip(note.nodes, note.statuses, note.messages):
            before = codes[node]
            code: int = STATUS_OF[status]
            if code == NodeStatus.IDLE:
                if message == SKIPPED_MESSAGE:
                    code = NodeStatus.SKIPPED
                elif before:
                    # one that is idle shows what it was before
                    code = (
                        before if before >= IDLE_FROM or before == NodeStatus.SKIPPED else IDLE_FROM + before
                    )
            if code != before:
                codes[node] = code
                if self._recording_since_s is not None:
                    plain = NodeStatus.IDLE if code >= IDLE_FROM else code
                    uid = self._tree.uids.get(node) if self._tree is not None else None
                    if uid is not None:
                        self._transitions.append((now_us, uid, plain))

    # -- anywhere ------------------------------------------------------------------------------------------------------

    def close(self) -> None:
        self._closed = True
        self._thread.join(timeout=2.0)
        self._hooks.remove_all()

    def _bind(self, kind: Any, port: int) -> Any:
        socket = self._context.socket(kind)
        socket.setsockopt(self._zmq.LINGER, 0)
        try:
            socket.bind(f"tcp://*:{port}")
        except self._zmq.ZMQError as error:
            socket.close()
            raise DeviceError(
                f"port {port} for Groot2's monitor cannot be opened ({error}); does another executor use it? It takes "
                "two ports, this one and the next"
            ) from error
        return socket

    def _tree_now(self) -> GrootTree:
        tree = self._tree
        # the tick's thread may replace the tree while this one draws it
        while tree is None or self._root not in tree.uids:
            tree = self._tree = groot_tree(self._root, self._path)
        return tree

    # -- in the monitor's thread ---------------------------------------------------------------------------------------

    def _serve(self) -> None:
        poller = self._zmq.Poller()
        poller.register(self._server, self._zmq.POLLIN)
        try:
            while not self._closed:
                if poller.poll(POLL_MS):
                    self._server.send_multipart(self._answer_safely(self._server.recv_multipart()))
                for uid in self._hooks.take_reached():
                    header = request_header(Kind.BREAKPOINT_REACHED, uuid4().int & 0xFFFFFFFF)
                    self._news.send_multipart([header, str(uid).encode()])
                self._check_heartbeat()
        finally:
            self._server.close()
            self._news.close()
            self._context.term()

    def _answer_safely(self, parts: list[bytes]) -> list[bytes]:
        self._asked_s = self._clock()
        try:
            return self._answer(parse_request(parts))
        except ProtocolError as error:
            return [b"error", str(error).encode()]
        except Exception as error:
            # what a debugger asks must not end a mission
            log.exception("a question of Groot2 could not be answered")
            return [b"error", repr(error).encode()]

    def _answer(self, request: Request) -> list[bytes]:
        header = reply_header(request, self._tree_id)
        content = self._content(request)
        return [header] if content is None else [header, content]

    def _content(self, request: Request) -> bytes | None:
        tree = self._tree_now()
        if request.kind is Kind.FULL_TREE:
            return tree.xml.encode()
        if request.kind is Kind.STATUS:
            codes = dict(self._codes)
            return status_bytes({uid: codes.get(node, NodeStatus.IDLE) for node, uid in tree.uids.items()})
        if request.kind is Kind.BLACKBOARD:
            if request.content is None:
                raise ProtocolError("must be 2 parts message")
            wanted = request.content.decode("utf-8", errors="replace")
            packed: bytes = self._pack(tree.blackboards(wanted, dict(Blackboard.storage)))
            return packed
        if request.kind is Kind.TOGGLE_RECORDING:
            return self._toggle_recording(request)
        if request.kind is Kind.GET_TRANSITIONS:
            taken = [self._transitions.popleft() for _ in range(len(self._transitions))]
            return transition_bytes(taken)
        return self._hooks.answer(request, {uid: node for node, uid in tree.uids.items()})

    def _toggle_recording(self, request: Request) -> bytes | None:
        if request.content is None:
            raise ProtocolError("must be 2 parts message")
        if request.content == b"start":
            self._transitions.clear()
            self._recording_since_s = self._clock()
            return str(time.time_ns() // 1000).encode()
        self._recording_since_s = None
        return None

    def _check_heartbeat(self) -> None:
        if self._asked_s is None or self._clock() - self._asked_s < HEARTBEAT_S:
            return
        self._asked_s = self._recording_since_s = None
        if self._hooks.is_holding:
            log.warning(
                "Groot2 is gone while a breakpoint held the mission; it stays paused until the operator speaks"
            )
            self._pause()
        self._hooks.remove_all()

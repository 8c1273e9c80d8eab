"""Groot2's breakpoints and forced results on the nodes of the running tree."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from py_trees.behaviour import Behaviour

from target_nav.app.groot_monitor_protocol import (
    HookMode,
    HookState,
    Kind,
    NodeStatus,
    ProtocolError,
    Request,
    parse_hook,
    parse_json,
    status_named,
)
from target_nav.mission.hooks import Answer, NodeHook

ANSWER_OF = {NodeStatus.SUCCESS: Answer.SUCCESS, NodeStatus.FAILURE: Answer.FAILURE}


@dataclass(eq=False)
class _Placed:
    """A hook on its node. `released` is what a breakpoint was told to do, once."""

    state: HookState
    node_hook: NodeHook | None = None
    reached: bool = False
    released: Answer | None = None


@dataclass(eq=False)
class HookTable:
    """By node number. Questions come in the monitor's thread, `_ask` in the tick's."""

    hold: Callable[[bool], None]
    _hooks: dict[int, _Placed] = field(default_factory=dict)
    _news: list[int] = field(default_factory=list)
    _lock: threading.RLock = field(default_factory=threading.RLock)

    @property
    def is_holding(self) -> bool:
        with self._lock:
            return any(placed.reached for placed in self._hooks.values())

    def take_reached(self) -> list[int]:
        """The nodes at which a hook was reached since the last call."""
        if not self._news:
            return []
        with self._lock:
            news, self._news = self._news, []
            return news

    def remove_all(self) -> None:
        with self._lock:
            for uid in list(self._hooks):
                self._remove(uid)

    def answer(self, request: Request, nodes: Mapping[int, Behaviour]) -> bytes | None:
        """
        Raises:
            ProtocolError: it cannot be answered.
        """
        with self._lock:
            if request.kind is Kind.HOOK_INSERT:
                data = parse_json(request)
                for each in data if isinstance(data, list) else [data]:
                    self._insert(parse_hook(each), nodes)
            elif request.kind is Kind.HOOK_REMOVE:
                self._remove(self._uid(request))
            elif request.kind is Kind.BREAKPOINT_UNLOCK:
                self._unlock(request)
            elif request.kind is Kind.HOOKS_DUMP:
                return json.dumps([placed.state.as_json() for placed in self._hooks.values()]).encode()
            elif request.kind is Kind.REMOVE_ALL_HOOKS:
                self.remove_all()
            elif request.kind is Kind.DISABLE_ALL_HOOKS:
                for placed in self._hooks.values():
                    placed.state.enabled = False
                    self._let_go(placed)
            else:
                raise ProtocolError("Request not recognized")
        return None

    # ------------------------------------------------------------------------------------------------------------------

    def _uid(self, request: Request) -> int:
        data = parse_json(request)
        uid = data.get("uid") if isinstance(data, dict) else None
        if not isinstance(uid, int) or uid not in self._hooks:
            raise ProtocolError("Node ID not found")
        return uid

    def _insert(self, state: HookState, nodes: Mapping[int, Behaviour]) -> None:
        if state.uid not in nodes:
            raise ProtocolError("Node ID not found")
        placed = self._hooks.get(state.uid)
        if placed is None:
            placed = self._hooks[state.uid] = _Placed(state)
            placed.node_hook = NodeHook(nodes[state.uid], lambda: self._ask(placed))
            return
        placed.state = state
        if state.mode is HookMode.REPLACE or not state.enabled:
            self._let_go(placed)

    def _remove(self, uid: int) -> None:
        placed = self._hooks.pop(uid)
        if placed.node_hook is not None:
            placed.node_hook.remove()
        self._let_go(placed)

    def _unlock(self, request: Request) -> None:
        uid = self._uid(request)
        data = parse_json(request)
        try:
            status = status_named(data.get("desired_status"))
        except ValueError as error:
            raise ProtocolError(str(error)) from None
        placed = self._hooks[uid]
        placed.state.desired_status = status
        placed.state.once = placed.state.once or bool(data.get("remove_when_done", False))
        if placed.reached:
            placed.released = ANSWER_OF.get(status, Answer.GO_ON)
            self._let_go(placed)

    def _let_go(self, placed: _Placed) -> None:
        placed.reached = False
        if not self.is_holding:
            self.hold(False)

    def _ask(self, placed: _Placed) -> Answer:
        """In the tick's thread, before each tick of the node."""
        with self._lock:
            state = placed.state
            if not state.enabled:
                return Answer.GO_ON
            if state.mode is HookMode.REPLACE:
                self._news.append(state.uid)
                answer = ANSWER_OF.get(state.desired_status, Answer.GO_ON)
            elif placed.released is not None:
                answer, placed.released = placed.released, None
            else:
                if not placed.reached:
                    placed.reached = True
                    self._news.append(state.uid)
                    self.hold(True)
                return Answer.HOLD
            if state.once:
                self._remove(state.uid)
            return answer

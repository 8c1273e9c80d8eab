"""Operator commands, each to the one place that handles it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

from target_nav.state.types import Command, CommandKind

Handler = Callable[[Command], None]


class CommandDispatcher:
    """Calls a handler per command, in order of arrival, STOP first: nothing may overtake it.

    Raises:
        ValueError: at construction, when a kind of command has no handler.
    """

    def __init__(self, handlers: Mapping[CommandKind, Handler]) -> None:
        missing = [kind.name for kind in CommandKind if kind not in handlers]
        if missing:
            raise ValueError(f"no handler for {', '.join(missing)}")
        self._handlers = dict(handlers)

    def dispatch(self, commands: Iterable[Command]) -> None:
        waiting = list(commands)
        last_stop = max((i for i, c in enumerate(waiting) if c.kind is CommandKind.STOP), default=None)
        if last_stop is not None:
            # what was asked before a STOP is void, but for what moves nothing: bookkeeping and settings
            before, waiting = waiting[:last_stop], waiting[last_stop:]
            for command in before:
                if command.kind in (CommandKind.RESET_ODOM, CommandKind.SETTING):
                    self._handlers[command.kind](command)
        for command in waiting:
            self._handlers[command.kind](command)

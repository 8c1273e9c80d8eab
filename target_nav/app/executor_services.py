"""The executor's services for a person who debugs: pause, resume, single step, reload. All are std_srvs/Trigger.

    ros2 service call /tree_executor/step std_srvs/srv/Trigger

Each is the command of the same name (`target-nav say step`), in force in the next tick. `reload` answers with what is
wrong if the mission's file is, a line each; nothing changes then.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from target_nav.app.ros_support import RosNode
from target_nav.state.stores import QueueStore
from target_nav.state.types import Command, CommandKind

WAITING = 16


class ExecutorServices:
    """Answers in the executor's thread; the loop calls `take` before each tick."""

    def __init__(self, ros: RosNode, problems: Callable[[], list[str]]) -> None:
        from std_srvs.srv import Trigger

        self._ros, self._problems = ros, problems
        self._waiting: QueueStore[Command] = QueueStore(WAITING)
        for kind in (CommandKind.PAUSE, CommandKind.RESUME, CommandKind.STEP):
            ros.node.create_service(Trigger, f"~/{kind.name.lower()}", self._answer(kind))
        ros.node.create_service(Trigger, "~/reload", self._reload)

    def put(self, kind: CommandKind) -> None:
        """As if somebody had asked for it; from any thread."""
        self._waiting.put(Command(self._ros.clock.now_s(), kind))

    def take(self) -> tuple[Command, ...]:
        """What was asked for since the last call."""
        return self._waiting.take_all()

    def _answer(self, kind: CommandKind) -> Callable[[Any, Any], Any]:
        def answer(request: Any, response: Any) -> Any:
            self.put(kind)
            response.success, response.message = True, f"{kind.name} is in force with the next tick"
            return response

        return answer

    def _reload(self, request: Any, response: Any) -> Any:
        problems = self._problems()
        response.success = not problems
        if problems:
            response.message = "\n".join(problems)
            return response
        self.put(CommandKind.RELOAD)
        response.message = "the file is right, and taken in a moment; the mission then waits for GO"
        return response

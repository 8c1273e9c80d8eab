"""What the two watcher commands share: handing over to the real ones, a node, and finding services by type."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from typing import Any

from py_trees import console

from target_nav.app.ros_support import RosNode
from target_nav.errors import DeviceError

FIND_S = 5.0
"""py_trees_ros looks for services as long."""


def hand_over(program: str) -> None:
    """Where py_trees_ros is installed its own watcher runs, and does not return; otherwise nothing happens.

    So it does not matter whose command of that name comes first on the PATH.
    """
    if find_spec("py_trees_ros") is None:
        return
    main: Callable[[], object] = import_module(f"py_trees_ros.programs.{program}").main
    sys.exit(main())  # type: ignore[arg-type]


def find_service(ros: RosNode, service_type: str, namespace: str, patience_s: float = FIND_S) -> str:
    """The one service of that type whose name contains `namespace`.

    Raises:
        DeviceError: none within `patience_s`, or several.
    """
    deadline_s = time.monotonic() + patience_s
    while True:
        found = [
            name
            for name, types in ros.node.get_service_names_and_types()
            if service_type in types and namespace in name
        ]
        if len(found) > 1:
            raise DeviceError(
                f"{len(found)} executors run: {', '.join(sorted(found))}; choose one by its namespace"
            )
        if found:
            return found[0]
        if time.monotonic() > deadline_s:
            where = f" with {namespace!r} in its name" if namespace else ""
            raise DeviceError(
                f"no service of type {service_type}{where} within {patience_s:g} s; does tree_executor run, and in "
                "the same ROS_DOMAIN_ID?"
            )
        if ros.stop.wait(0.1):
            raise KeyboardInterrupt


def call(ros: RosNode, service_type: Any, name: str, request: Any, patience_s: float = FIND_S) -> Any:
    """The answer of a service.

    Raises:
        DeviceError: no answer within `patience_s`.
    """
    client = ros.node.create_client(service_type, name)
    try:
        deadline_s = time.monotonic() + patience_s
        future: Any = None
        while future is None or not future.done():
            if future is None and client.service_is_ready():
                future = client.call_async(request)
            if time.monotonic() > deadline_s:
                raise DeviceError(f"no answer from {name} within {patience_s:g} s; is the executor alive?")
            time.sleep(0.02)
        return future.result()
    finally:
        ros.node.destroy_client(client)


def title(text: str, colour: str) -> str:
    return f"{colour}{text}{console.reset}"

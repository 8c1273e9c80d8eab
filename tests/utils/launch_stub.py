"""The little of ROS 2's `launch` that the launch files use, for machines without it.

Names, modules and keywords are those of launch 3.4 (Jazzy); a keyword it does not have is a TypeError here too.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from types import ModuleType
from typing import Any


@dataclass
class LaunchContext:
    launch_configurations: dict[str, str] = field(default_factory=dict)
    is_shutdown: bool = False


@dataclass
class LaunchDescription:
    entities: list[Any]


@dataclass
class DeclareLaunchArgument:
    name: str
    default_value: str | None = field(default=None, kw_only=True)
    description: str | None = field(default=None, kw_only=True)


@dataclass
class OpaqueFunction:
    function: Callable[[LaunchContext], list[Any] | None] = field(kw_only=True)


@dataclass
class ExecuteProcess:
    cmd: list[str] = field(kw_only=True)
    name: str | None = field(default=None, kw_only=True)
    additional_env: dict[str, str] | None = field(default=None, kw_only=True)
    output: str = field(default="log", kw_only=True)
    on_exit: Callable[[Any, LaunchContext], list[Any] | None] | None = field(default=None, kw_only=True)


@dataclass
class LogInfo:
    msg: str = field(kw_only=True)


@dataclass
class Shutdown:
    reason: str = field(default="reason not given", kw_only=True)


@dataclass
class EmitEvent:
    event: Shutdown = field(kw_only=True)


@dataclass
class TimerAction:
    period: float = field(kw_only=True)
    actions: list[Any] = field(kw_only=True)


@dataclass
class ProcessExited:
    """What `on_exit` gets."""

    returncode: int


MODULES = {
    "launch": {"LaunchDescription": LaunchDescription},
    "launch.actions": {
        "DeclareLaunchArgument": DeclareLaunchArgument,
        "EmitEvent": EmitEvent,
        "ExecuteProcess": ExecuteProcess,
        "LogInfo": LogInfo,
        "OpaqueFunction": OpaqueFunction,
        "TimerAction": TimerAction,
    },
    "launch.events": {"Shutdown": Shutdown},
}

USERS = ("target_nav.app.launch_actions",)
"""Modules that hold on to these names, and must be imported anew."""


@contextmanager
def stubbed() -> Iterator[None]:
    """`import launch` gives these while the block runs."""
    names = (*MODULES, *USERS)
    before = {name: sys.modules.pop(name) for name in names if name in sys.modules}
    for name, members in MODULES.items():
        module = ModuleType(name)
        vars(module).update(members)
        sys.modules[name] = module
    try:
        yield
    finally:
        for name in names:
            sys.modules.pop(name, None)
        sys.modules.update(before)


def perform(description: LaunchDescription, given: dict[str, str]) -> tuple[list[Any], LaunchContext]:
    """The actions that `ros2 launch ... name:=value` would run, and their context."""
    context = LaunchContext()
    actions: list[Any] = []
    for entity in description.entities:
        if isinstance(entity, DeclareLaunchArgument):
            value = given.pop(entity.name, entity.default_value)
            assert value is not None, f"{entity.name} has to be given"
            context.launch_configurations[entity.name] = value
        elif isinstance(entity, OpaqueFunction):
            actions += entity.function(context) or []
        else:
            actions.append(entity)
    assert not given, f"not declared: {sorted(given)}"
    return actions, context

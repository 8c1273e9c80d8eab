"""Behaviours named by import path: any py_trees behaviour can be a leaf, its arguments written as attributes.

`<Action ID="py_trees.behaviours:TickCounter" duration="5" completion_status="SUCCESS"/>`. The module is imported when
the mission is checked. So a mission can run what is installed, as any program can: one from a stranger is to be read
before it is checked.
"""

from __future__ import annotations

import importlib
import inspect
import re
import typing
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from types import ModuleType
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.composites import Composite
from py_trees.decorators import Decorator
from py_trees.ports import PortInformation, PortsMixin

from target_nav.mission.nodes import MissionNode
from target_nav.mission.port_types import can_be_written, type_name
from target_nav.mission.problems import did_you_mean

_DOTTED = r"[A-Za-z_][A-Za-z0-9_]*(?:\.[A-Za-z_][A-Za-z0-9_]*)*"
_PATH = re.compile(rf"{_DOTTED}:{_DOTTED}|{_DOTTED}\.[A-Za-z_][A-Za-z0-9_]*")


class ImportPathError(Exception):
    """Why an import path leads to no leaf. The text continues a sentence that begins with the path."""


@dataclass(frozen=True)
class ConstructedLeaf:
    """A behaviour without ports. `arguments` are its constructor's, but for the name."""

    cls: type[Behaviour]
    arguments: Mapping[str, PortInformation]


def is_import_path(name: str) -> bool:
    """`package.module:Class` or `package.module.Class`."""
    return _PATH.fullmatch(name) is not None


def import_leaf(path: str) -> type[Behaviour] | ConstructedLeaf:
    """The class, if it has ports, or what its constructor takes.

    Raises:
        ImportPathError: there is no such module or class, it is no leaf, or it needs what a mission cannot write.
    """
    module_name, _, qualified = path.partition(":") if ":" in path else path.rpartition(".")
    module = _import(module_name)
    cls: Any = module
    for name in qualified.split("."):
        try:
            cls = getattr(cls, name)
        except Exception as error:
            near = did_you_mean(name, _behaviours_of(cls))
            raise ImportPathError(f"{module_name} has no {qualified}{near}") from error
    _check_class(cls, module_name, qualified)
    if issubclass(cls, PortsMixin):
        found: type[Behaviour] = cls
        return found
    return ConstructedLeaf(cls, _arguments(cls))


def _behaviours_of(owner: Any) -> list[str]:
    return [name for name, each in getattr(owner, "__dict__", {}).items() if _is_behaviour(each)]


def _is_behaviour(each: Any) -> bool:
    # Python 3.10 takes list[int] for an instance of `type`, but not for a class.
    return isinstance(each, type) and typing.get_origin(each) is None and issubclass(each, Behaviour)


def _import(name: str) -> ModuleType:
    try:
        return importlib.import_module(name)
    except (Exception, SystemExit) as error:
        # A module can raise anything while it is imported; a mission's check must go on.
        raise ImportPathError(
            f"module {name} cannot be imported ({type(error).__name__}: {error})"
        ) from error


def _check_class(cls: Any, module_name: str, qualified: str) -> None:
    if not _is_behaviour(cls):
        raise ImportPathError(f"{qualified} of {module_name} is not a py_trees behaviour")
    if issubclass(cls, MissionNode):
        raise ImportPathError(f"{qualified} is a built-in; write <{cls.__name__}>")
    if issubclass(cls, (Composite, Decorator)):
        raise ImportPathError(
            f"{qualified} is a py_trees composite or decorator; only leaves can be imported"
        )
    if inspect.isabstract(cls):
        missing = ", ".join(sorted(getattr(cls, "__abstractmethods__", ())))
        raise ImportPathError(f"{qualified} is abstract (without {missing}) and cannot be made")


def _arguments(cls: type[Behaviour]) -> dict[str, PortInformation]:
    try:
        parameters = list(inspect.signature(cls).parameters.values())
    except (TypeError, ValueError) as error:
        raise ImportPathError(f"the arguments of {cls.__name__} cannot be told ({error})") from error
    try:
        hints = typing.get_type_hints(cls.__init__)
    except Exception:
        # Annotations may name what is not there; then they say nothing.
        hints = {}
    arguments = {}
    for parameter in parameters:
        if parameter.name == "name" or parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
            continue
        required = parameter.default is parameter.empty
        data_type = _type_of(parameter, hints)
        writable = can_be_written(data_type) and not parameter.name.startswith("_") and parameter.name != "ID"
        if parameter.kind is parameter.POSITIONAL_ONLY:
            writable = False
        if required and not writable:
            raise ImportPathError(
                f"its argument {parameter.name} ({type_name(data_type)}) cannot be written in a mission; "
                "derive a leaf from it that needs none"
            )
        if writable:
            arguments[parameter.name] = PortInformation(
                data_type, required, "", _documented(parameter.default, data_type, required)
            )
    return arguments


def _type_of(parameter: inspect.Parameter, hints: Mapping[str, Any]) -> Any:
    if parameter.name in hints:
        return hints[parameter.name]
    default = parameter.default
    return str if default is parameter.empty or default is None else type(default)


def _documented(default: Any, data_type: Any, required: bool) -> Any:
    simple = not required and isinstance(default, (bool, int, float, str, Enum))
    return default if simple and type(default) is data_type else None

"""The second pass of the check: who writes and who reads which blackboard entry once the mission runs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

from target_nav.mission.expand import Instance, PortUse
from target_nav.mission.model import SUBTREE
from target_nav.mission.nodes.loops import Result
from target_nav.mission.port_types import UNKNOWN, accepts, type_name
from target_nav.mission.problems import Report, did_you_mean
from target_nav.mission.values import BadValue, check_limits, to_literal, to_port
from target_nav.state import keys


@dataclass
class Traffic:
    """All uses of one entry."""

    writers: list[tuple[Instance, PortUse]] = field(default_factory=list)
    readers: list[tuple[Instance, PortUse]] = field(default_factory=list)


def traffic_of(root: Instance) -> dict[str, Traffic]:
    """The mission's blackboard entries by path."""
    traffic: dict[str, Traffic] = {}
    for instance in root.walk():
        for use in (*instance.outputs, *instance.writes):
            traffic.setdefault(use.entry.path, Traffic()).writers.append((instance, use))
        for use in (*instance.inputs, *instance.reads):
            traffic.setdefault(use.entry.path, Traffic()).readers.append((instance, use))
    return traffic


def port_types(uses: Traffic) -> list[Any]:
    """The types of the ports bound to an entry, each once: those of leaves, or, if there are none, of built-ins."""
    ports = [
        use
        for _, use in (*uses.writers, *uses.readers)
        if use.kind == "port" and use.data_type not in UNKNOWN
    ]
    strict = [use.data_type for use in ports if use.strict]
    return _distinct(strict or [use.data_type for use in ports])


def _distinct(types: Iterable[Any]) -> list[Any]:
    # not every type can be hashed
    found: list[Any] = []
    for each in types:
        if each not in found:
            found.append(each)
    return found


def check_wiring(root: Instance, provided: frozenset[str], report: Report) -> None:
    traffic = traffic_of(root)
    table = {key.name: key for key in keys.ALL}
    provided |= {path for instance in root.walk() for path in instance.touched}
    for instance in root.walk():
        _fixed_stays(instance, traffic, report)
    for path, uses in traffic.items():
        _one_owner(path, uses, report)
        _scripts_fit(path, uses, report)
        if path not in table and path not in provided:
            _somebody_creates(path, uses, report)
        for instance, use in uses.writers:
            if path in table:
                report.error(
                    use.position,
                    f"{_id(instance)}: {use.port} writes {path}, which {table[path].writer} writes; "
                    "use another key",
                )
        readers = [(instance, use) for instance, use in uses.readers if not _constant(instance, use, report)]
        if not readers:
            continue
        types = [(table[path].type, "the table of keys")] if path in table else list(_written(uses.writers))
        if types:
            _types_fit(path, readers, types, report)
        elif path not in provided:
            _nobody_writes(path, readers, (*traffic, *table), traffic, report)
    _conditions_decide(root, report)


def _id(instance: Instance) -> str:
    definition = instance.definition
    return f"{SUBTREE} {definition.id}" if definition.is_subtree else definition.id


def _fixed_stays(instance: Instance, traffic: dict[str, Traffic], report: Report) -> None:
    for use in instance.fixed:
        uses = traffic.get(use.entry.path)
        if uses is not None and uses.writers:
            writer, write = uses.writers[0]
            report.error(
                use.position,
                f"{_id(instance)}: {use.port} is {use.text}, a constant that the mission is built with, but "
                f"{_id(writer)} writes it ({write.position})",
            )


def _scripts_fit(path: str, uses: Traffic, report: Report) -> None:
    """What scripts and built-ins write must become what ports read."""
    free = [(instance, use) for instance, use in uses.writers if use.kind != "port"]
    types = port_types(uses)
    if not free or not types:
        return
    if len(types) > 1:
        instance, use = free[0]
        names = " and ".join(map(type_name, types))
        report.error(
            use.position,
            f"{_id(instance)}: {use.port} writes {path}, which ports have as {names}; use two entries",
        )
        return
    limited = next((use for _, use in uses.readers if use.limits is not None), None)
    for instance, use in free:
        for value in _constants(instance, use):
            try:
                fitting = to_port(value, types[0])
                if limited is not None:
                    check_limits(fitting, limited.port, limited.limits)
            except BadValue as error:
                report.error(
                    use.position,
                    f"{_id(instance)}: {use.port} writes {value!r} to {path}; {error} ({_reader(uses)})",
                )


def _constants(instance: Instance, use: PortUse) -> list[Any]:
    if use.kind == "script":
        return [value for name, value in instance.scripts[use.port].constants_written if name == use.text]
    return [instance.literals["value"]] if "value" in instance.literals else []


def _reader(uses: Traffic) -> str:
    instance, use = next(each for each in (*uses.readers, *uses.writers) if each[1].kind == "port")
    return f"{use.port} of {_id(instance)} at {use.position}"


def _somebody_creates(path: str, uses: Traffic, report: Report) -> None:
    every = (*uses.writers, *uses.readers)
    if any(use.kind == "port" or use.entry.initial is not None for _, use in every):
        return
    if all(not use.creates for _, use in uses.writers):
        for instance, use in uses.writers:
            report.error(
                use.position,
                f"{_id(instance)}: {use.port} writes {use.text} ({path}), which nothing makes; write {use.text} := ...",
            )


def _one_owner(path: str, uses: Traffic, report: Report) -> None:
    """`{approach/x}` outside and `{x}` in subtree `approach` would be the same entry by accident."""
    every = (*uses.writers, *uses.readers)
    inner = max((use.owner for _, use in every), key=lambda owner: len(owner.path))
    for instance, use in every:
        if use.owner is not inner:
            report.error(
                use.position,
                f"{_id(instance)}: {use.port} means {path}, but that is a key of subtree {inner.path}; "
                "use another key",
            )


def _constant(instance: Instance, use: PortUse, report: Report) -> bool:
    """Whether a SubTree's attribute gives the value; if so, that it fits."""
    if use.entry.initial is None:
        return False
    initial = use.entry.initial
    try:
        to_literal(initial.text, use.port, use.data_type, use.limits)
    except BadValue as error:
        report.error(
            initial.position,
            f'"{initial.text}" goes to {use.port} of {_id(instance)} ({use.position}); {error}',
        )
    return True


def _written(writers: Iterable[tuple[Instance, PortUse]]) -> Iterator[tuple[Any, str]]:
    for instance, use in writers:
        yield use.data_type, f"{use.port} of {_id(instance)} at {use.position}"


def _types_fit(
    path: str, readers: list[tuple[Instance, PortUse]], types: list[tuple[Any, str]], report: Report
) -> None:
    for instance, use in readers:
        wanted = use.data_type
        for written, who in types:
            # BehaviorTree.CPP converts text when it is read; so do the built-ins, but not the leaves' ports.
            if not accepts(wanted, written) and not (not use.strict and written is str):
                report.error(
                    use.position,
                    f"{_id(instance)}: {use.port} must be {type_name(wanted)}, but {path} is "
                    f"{type_name(written)} ({who})",
                )


def _nobody_writes(
    path: str,
    readers: list[tuple[Instance, PortUse]],
    known: Iterable[str],
    traffic: dict[str, Traffic],
    report: Report,
) -> None:
    written = [each for each in known if each not in traffic or traffic[each].writers]
    near = did_you_mean(path, written)
    for instance, use in readers:
        verb = "reads" if use.kind != "key" else "names"
        report.error(
            use.position,
            f"{_id(instance)}: {use.port} {verb} {use.text.strip()} ({path}), which nobody writes{near}",
        )


def _conditions_decide(root: Instance, report: Report) -> None:
    for instance in root.walk():
        if instance.definition.id in ("IfThenElse", "WhileDoElse") and instance.spec and instance.children:
            condition = instance.children[0]
            if _may_skip(condition):
                report.error(
                    condition.definition.position,
                    f"{condition.definition.id} can be skipped, and {instance.definition.id} cannot decide on that; "
                    "its first child must end with SUCCESS or FAILURE",
                )


def _may_skip(instance: Instance) -> bool:
    """Whether a tick can end with SKIPPED: some nodes begin it, and it passes through what has no other child."""
    kind, children = instance.definition.id, instance.children
    if "_skipIf" in instance.scripts or "_while" in instance.scripts:
        return True
    if kind == "RunOnce":
        return instance.literals.get("then_skip") is not False
    if kind.startswith("Loop"):
        return instance.literals.get("if_empty", Result.SUCCESS) is Result.SKIPPED
    if kind == "SkipUnlessUpdated":
        return True
    if kind == "Precondition" and instance.literals.get("else", Result.FAILURE) is Result.SKIPPED:
        return True
    if kind == "KeepRunningUntilFailure" or not children:
        return False
    if kind in ("IfThenElse", "WhileDoElse"):
        return any(_may_skip(child) for child in children[1:])
    if kind.startswith("Switch"):
        return any(map(_may_skip, children))
    return all(map(_may_skip, children[:-1] if kind == "TryCatch" and len(children) > 1 else children))

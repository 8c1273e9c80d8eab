"""The second pass of the check: who writes and who reads which blackboard entry once the mission runs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

from target_nav.mission.expand import Instance, PortUse
from target_nav.mission.problems import Report, did_you_mean
from target_nav.mission.registry import NodeSpec
from target_nav.mission.values import BadValue, accepts, to_literal, type_name
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
        for use in instance.outputs:
            traffic.setdefault(use.entry.path, Traffic()).writers.append((instance, use))
        for use in instance.inputs:
            traffic.setdefault(use.entry.path, Traffic()).readers.append((instance, use))
    return traffic


def check_wiring(root: Instance, provided: frozenset[str], report: Report) -> None:
    traffic = traffic_of(root)
    table = {key.name: key for key in keys.ALL}
    provided |= {path for instance in root.walk() for path in instance.touched}
    for path, uses in traffic.items():
        _one_owner(path, uses, report)
        for instance, use in uses.writers:
            if path in table:
                report.error(
                    use.position,
                    f"{instance.definition.id}: {use.port} writes {path}, which {table[path].writer} writes; "
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


def _spec(instance: Instance) -> NodeSpec:
    assert instance.spec is not None, "only nodes that are known have bound ports"
    return instance.spec


def _one_owner(path: str, uses: Traffic, report: Report) -> None:
    """`{approach/x}` outside and `{x}` in subtree `approach` would be the same entry by accident."""
    every = (*uses.writers, *uses.readers)
    inner = max((use.owner for _, use in every), key=lambda owner: len(owner.path))
    for instance, use in every:
        if use.owner is not inner:
            report.error(
                use.position,
                f"{instance.definition.id}: {use.port} means {path}, but that is a key of subtree {inner.path}; "
                "use another key",
            )


def _constant(instance: Instance, use: PortUse, report: Report) -> bool:
    """Whether a SubTree's attribute gives the value; if so, that it fits."""
    if use.entry.initial is None:
        return False
    spec, initial = _spec(instance), use.entry.initial
    try:
        to_literal(initial.text, use.port, spec.inputs[use.port].data_type, spec.limits.get(use.port))
    except BadValue as error:
        report.error(
            initial.position,
            f'"{initial.text}" goes to {use.port} of {instance.definition.id} ({use.position}); {error}',
        )
    return True


def _written(writers: Iterable[tuple[Instance, PortUse]]) -> Iterator[tuple[Any, str]]:
    for instance, use in writers:
        spec = _spec(instance)
        yield spec.outputs[use.port].data_type, f"{use.port} of {instance.definition.id} at {use.position}"


def _types_fit(
    path: str, readers: list[tuple[Instance, PortUse]], types: list[tuple[Any, str]], report: Report
) -> None:
    for instance, use in readers:
        wanted = _spec(instance).inputs[use.port].data_type
        for written, who in types:
            # BehaviorTree.CPP converts text when it is read; so do the built-ins, but not the leaves' ports.
            if not accepts(wanted, written) and not (_spec(instance).built_in and written is str):
                report.error(
                    use.position,
                    f"{instance.definition.id}: {use.port} must be {type_name(wanted)}, but {path} is "
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
        report.error(
            use.position,
            f"{instance.definition.id}: {use.port} reads {use.text.strip()} ({path}), which nobody writes{near}",
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
    """Whether a tick can end with SKIPPED: only RunOnce begins it, and it passes through what has no other child."""
    if instance.definition.id == "RunOnce":
        return instance.literals.get("then_skip") is not False
    if instance.definition.id == "KeepRunningUntilFailure" or not instance.children:
        return False
    if instance.definition.id in ("IfThenElse", "WhileDoElse"):
        return any(_may_skip(child) for child in instance.children[1:])
    return all(_may_skip(child) for child in instance.children)

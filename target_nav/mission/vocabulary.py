"""The words of a mission for people and for editors: as data, as a Markdown page, as Groot2's palette.

Everything comes from the nodes' own declarations, so none of it can say what the loader does not do.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any
from xml.sax.saxutils import escape, quoteattr

from target_nav.mission.model import SUBTREE, Form
from target_nav.mission.port_types import type_name, unit_of
from target_nav.mission.registry import NodeKind, NodeRegistry, NodeSpec
from target_nav.state import keys


class Group(str, Enum):
    """What a page or a palette sorts nodes by. The value is its heading."""

    CONTROL = "Control nodes"
    DECORATOR = "Decorators"
    BUILT_IN = "Leaves of BehaviorTree.CPP"
    CONDITION = "Conditions"
    ACTION = "Actions"


@dataclass(frozen=True)
class PortEntry:
    """One port, in words. `default` is what holds when the mission says nothing, or why something must be said."""

    name: str
    is_output: bool
    type: str
    unit: str
    limits: str
    required: bool
    default: str
    doc: str
    data_type: Any


@dataclass(frozen=True)
class NodeEntry:
    """One word. `children` is how many there may be, in words; empty for a leaf."""

    name: str
    group: Group
    children: str
    doc: str
    ports: tuple[PortEntry, ...]

    @property
    def summary(self) -> str:
        """The first paragraph of the documentation, as one line."""
        return " ".join(self.doc.split("\n\n")[0].split())


_SUBTREE_DOC = """Ticks another tree of the mission, the one named by `ID`, with a blackboard of its own.

Its other attributes are that tree's parameters: a `{key}` of this tree, or a constant. `_autoremap` connects all
others."""


def vocabulary(registry: NodeRegistry) -> tuple[NodeEntry, ...]:
    """All words, by group, in the order in which they were registered."""
    entries = [_entry(spec) for spec in registry.specs()]
    subtree = NodeEntry(SUBTREE, Group.DECORATOR, "", _SUBTREE_DOC, ())
    order = list(Group)
    return tuple(sorted([*entries, subtree], key=lambda entry: order.index(entry.group)))


def is_condition(spec: NodeSpec) -> bool:
    """Whether a leaf only looks: it reads the robot's world and writes nothing of it."""
    return (
        spec.kind is NodeKind.LEAF
        and bool(getattr(spec.cls, "READS", ()))
        and not getattr(spec.cls, "WRITES", ())
    )


def form_of(spec: NodeSpec) -> Form:
    """How an editor writes the node explicitly."""
    if spec.kind is NodeKind.LEAF:
        return Form.CONDITION if is_condition(spec) else Form.ACTION
    return spec.kind.forms[0]


def children_text(spec: NodeSpec) -> str:
    """How many children a node has, in words; nothing for a leaf."""
    least, most = spec.children
    if most == 0:
        return ""
    if most is None:
        return f"{least} or more"
    return str(least) if least == most else f"{least} to {most}"


def _entry(spec: NodeSpec) -> NodeEntry:
    ports = [_port(name, spec, is_output=False) for name in spec.inputs]
    ports += [_port(name, spec, is_output=True) for name in spec.outputs]
    return NodeEntry(spec.name, _group(spec), children_text(spec), spec.doc, tuple(ports))


def _group(spec: NodeSpec) -> Group:
    if spec.kind is NodeKind.CONTROL:
        return Group.CONTROL
    if spec.kind is NodeKind.DECORATOR:
        return Group.DECORATOR
    if spec.built_in:
        return Group.BUILT_IN
    return Group.CONDITION if is_condition(spec) else Group.ACTION


def _port(name: str, spec: NodeSpec, is_output: bool) -> PortEntry:
    port = spec.port(name)
    limits = spec.limits.get(name)
    return PortEntry(
        name=name,
        is_output=is_output,
        type=port_type(name, spec),
        unit=unit_of(name),
        limits=f"{limits[0]:.12g} ... {limits[1]:.12g}" if limits else "",
        required=port.required and not port.has_default and not is_output,
        default="" if is_output else _default(spec, port.default_value, port.required),
        doc=port.description,
        data_type=port.data_type,
    )


def port_type(name: str, spec: NodeSpec) -> str:
    """A port's type in words a mission's author knows."""
    if name in spec.scripts:
        return "a script"
    if name in spec.keys:
        return "the name of an entry"
    return type_name(spec.port(name).data_type)


def _default(spec: NodeSpec, value: Any, required: bool) -> str:
    if value is not None:
        return value_text(value)
    if required:
        return "required"
    return "robot's configuration" if keys.CONFIG in getattr(spec.cls, "READS", ()) else ""


def value_text(value: Any) -> str:
    """A port's value as a mission writes it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return value.name if isinstance(value, Enum) else str(value)


# -- Markdown ----------------------------------------------------------------------------------------------------------

_HEAD = """\
# The words of a mission

Made by `target-nav nodes --markdown` out of the nodes' own declarations; do not edit. How they are put together is in
[mission-language.md](mission-language.md). Units are those that end a port's name (`_m` metres, `_s` seconds ...);
limits are inclusive. Any node may also have `name` and the pre- and postconditions.
"""


def markdown(entries: Sequence[NodeEntry]) -> str:
    """docs/nodes.md."""
    lines = [_HEAD.rstrip(), ""]
    for each in Group:
        links = [f"[{entry.name}](#{entry.name.lower()})" for entry in entries if entry.group is each]
        if links:
            lines.append(f"- {each.value}: {', '.join(links)}")
    group = None
    for entry in entries:
        if entry.group is not group:
            group = entry.group
            lines += ["", f"## {group.value}"]
        lines += ["", f"### {entry.name}", "", _prose(entry.doc)]
        if entry.children:
            lines += ["", f"Children: {entry.children}."]
        if entry.ports:
            lines += ["", "| port | | value | limits | default |", "|---|---|---|---|---|"]
            lines += [_row(port) for port in entry.ports]
    return "\n".join(lines) + "\n"


def _prose(doc: str) -> str:
    """Docstrings mark code with one backtick or none and may hold what Markdown takes for HTML."""
    return doc.replace("<", "&lt;")


def _row(port: PortEntry) -> str:
    what = f"{port.type} in {port.unit}" if port.unit else port.type
    cells = (
        f"`{port.name}`",
        f"{'**output** ' if port.is_output else ''}{port.doc}",
        what,
        port.limits,
        f"**{port.default}**" if port.required else port.default,
    )
    return f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"


# -- Groot2 ------------------------------------------------------------------------------------------------------------

_CPP_TYPES: dict[Any, str] = {bool: "bool", int: "int", float: "double", str: "std::string"}


def groot_model(registry: NodeRegistry) -> str:
    """The leaves as a file that Groot2 loads into its palette; its `TreeNodesModel` may also stand in a mission.

    BehaviorTree.CPP's own nodes are left out: Groot2 has them.
    """
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', '<root BTCPP_format="4">', "  <TreeNodesModel>"]
    for spec in registry.specs():
        if spec.built_in:
            continue
        form = form_of(spec).value
        lines.append(f"    <{form} ID={quoteattr(spec.name)}>")
        for name in spec.ports:
            lines.append(f"      {_groot_port(name, spec)}")
        doc = " ".join(spec.doc.split("\n\n")[0].split())
        if doc:
            lines += [
                "      <MetadataFields>",
                f"        <Metadata description={quoteattr(doc)}/>",
                "      </MetadataFields>",
            ]
        lines.append(f"    </{form}>")
    lines += ["  </TreeNodesModel>", "</root>"]
    return "\n".join(lines) + "\n"


def _groot_port(name: str, spec: NodeSpec) -> str:
    port = spec.port(name)
    tag = "input_port" if name in spec.inputs else "output_port"
    said = f'name={quoteattr(name)} type="{_CPP_TYPES.get(port.data_type, "BT::Any")}"'
    if port.has_default:
        said += f" default={quoteattr(value_text(port.default_value))}"
    return f"<{tag} {said}>{escape(port.description)}</{tag}>"

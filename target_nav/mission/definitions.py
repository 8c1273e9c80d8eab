"""The first pass of the check: every node of every tree as it is written, whether it is used or not."""

from __future__ import annotations

from collections.abc import Iterator

from target_nav.mission.btcpp import CONDITIONS, PRECONDITIONS
from target_nav.mission.document import METADATA
from target_nav.mission.expand import (
    AUTOREMAP,
    is_port_name,
    mandatory_ports,
    port_attributes,
    subtree_arguments,
)
from target_nav.mission.includes import Library
from target_nav.mission.model import SUBTREE, Attribute, Form, NodeDef, NodeModel, TreeDef
from target_nav.mission.port_types import type_name, unit_of
from target_nav.mission.problems import Report, did_you_mean, listed
from target_nav.mission.registry import NodeRegistry, NodeSpec
from target_nav.mission.script import ScriptError, check_kinds, parse_script
from target_nav.mission.values import BadValue, key_in, to_literal


class Definitions:
    def __init__(self, library: Library, registry: NodeRegistry, report: Report) -> None:
        self._library = library
        self._registry = registry
        self._report = report

    def check(self) -> None:
        for file in self._library.files:
            for tree in file.trees:
                self._tree(tree)
            for model in file.models:
                self._model(model)
        self._cycles()

    def _tree(self, tree: TreeDef) -> None:
        if self._registry.find(tree.id) is not None or tree.id == SUBTREE:
            self._report.error(tree.position, f'a tree cannot be called "{tree.id}", which is a node\'s name')
        for node in _walk(tree):
            self._conditions(node)
            if not node.id:
                continue
            if node.is_subtree:
                self._subtree(node)
                continue
            if node.id == SUBTREE:
                self._report.error(node.position, f"<{SUBTREE}> needs ID, the name of a tree")
                continue
            spec = self._registry.resolve(node.id)
            if spec is None:
                self._report.error(node.position, self._registry.explain_unknown(node.id))
                continue
            self._form(node, spec)
            self._children(node, spec)
            self._attributes(node, spec)
            self._one_async_child(node)

    # -- nodes -------------------------------------------------------------------------------------------------------

    def _conditions(self, node: NodeDef) -> None:
        for attribute in node.attributes:
            if attribute.name in CONDITIONS:
                try:
                    self._script(attribute.value, attribute.name in PRECONDITIONS)
                except ScriptError as error:
                    shown = f"{SUBTREE} {node.id}" if node.is_subtree else node.id
                    self._report.error(
                        attribute.position, f'{shown}: {attribute.name} is "{attribute.value}"; {error}'
                    )

    def _script(self, text: str, decides: bool) -> None:
        check_kinds(parse_script(text), self._registry.enums, decides)

    def _form(self, node: NodeDef, spec: NodeSpec) -> None:
        if node.form is not Form.COMPACT and node.form not in spec.kind.forms:
            right = " or ".join(f'<{form.value} ID="{node.id}">' for form in spec.kind.forms)
            self._report.error(
                node.position, f'<{node.form.value} ID="{node.id}">: write <{node.id}> or {right}'
            )

    def _children(self, node: NodeDef, spec: NodeSpec) -> None:
        least, most = spec.children
        count = len(node.children)
        if least <= count and (most is None or count <= most):
            return
        if most == 0:
            allowed = "it is a leaf and has none"
        elif most is None:
            allowed = f"it must have at least {least}"
        elif least == most:
            allowed = f"it must have exactly {least}"
        else:
            allowed = f"it must have {least} to {most}"
        self._report.error(
            node.position, f"{node.id} has {count} {'child' if count == 1 else 'children'}; {allowed}"
        )

    def _one_async_child(self, node: NodeDef) -> None:
        """BehaviorTree.CPP's rule: a second one, RUNNING between its children, would halt the first again and again."""
        found = [child for child in node.children if child.id == "AsyncSequence"]
        if node.id == "ReactiveSequence":
            for child in found[1:]:
                self._report.error(
                    child.position, "a ReactiveSequence has one AsyncSequence as a child at most"
                )

    def _attributes(self, node: NodeDef, spec: NodeSpec) -> None:
        for attribute in port_attributes(node):
            if attribute.name in spec.ports:
                self._value(attribute, node, spec)
            else:
                near = did_you_mean(attribute.name, (*spec.ports, "name", *CONDITIONS, *METADATA))
                self._report.error(
                    attribute.position,
                    f"{node.id} has no attribute {attribute.name}{near}; allowed: {listed((*spec.ports, 'name'))}",
                )
        for name, port in spec.inputs.items():
            if port.required and not port.has_default and node.attribute(name) is None:
                unit = unit_of(name)
                what = f"{type_name(port.data_type)}{f' in {unit}' if unit else ''}"
                about = f" ({port.description})" if port.description else ""
                self._report.error(node.position, f"{node.id} needs {name}: {what}{about}")

    def _value(self, attribute: Attribute, node: NodeDef, spec: NodeSpec) -> None:
        port = attribute.name
        try:
            if key_in(attribute.value, port) is not None:
                return
            if port in spec.outputs:
                raise BadValue("it is an output; give the {key} to write to")
            if port in spec.scripts:
                self._script(attribute.value, spec.scripts[port] == "decides")
                return
            if port in spec.keys:
                key_in(f"{{{attribute.value}}}", port)
                return
            value = to_literal(attribute.value, port, spec.inputs[port].data_type, spec.limits.get(port))
        except (BadValue, ScriptError) as error:
            self._report.error(attribute.position, f'{node.id}: {port} is "{attribute.value}"; {error}')
            return
        if node.id in ("Parallel", "ParallelAll") and value > len(node.children):
            self._report.error(
                attribute.position,
                f"{node.id}: {port} is {value}; it must lie in {-len(node.children)} ... {len(node.children)}, "
                "the number of children",
            )

    # -- subtrees ----------------------------------------------------------------------------------------------------

    def _subtree(self, node: NodeDef) -> None:
        if node.children:
            self._report.error(
                node.position, f'<{SUBTREE} ID="{node.id}"> has children; it stands for a whole tree'
            )
        if node.id not in self._library.trees:
            self._unknown_tree(node)
        for attribute in node.attributes:
            if attribute.name == AUTOREMAP:
                if attribute.value.strip() not in (
                    "true",
                    "True",
                    "TRUE",
                    "1",
                    "false",
                    "False",
                    "FALSE",
                    "0",
                ):
                    self._report.error(
                        attribute.position, f'{AUTOREMAP} is "{attribute.value}"; it must be true or false'
                    )
            elif not is_port_name(attribute.name) and attribute.name not in (*METADATA, *CONDITIONS):
                known = (AUTOREMAP, *CONDITIONS, *METADATA)
                near = did_you_mean(attribute.name, known)
                self._report.error(
                    attribute.position,
                    f"{SUBTREE} has no attribute {attribute.name}{near}; "
                    f"allowed: {AUTOREMAP}, name, and parameters, which begin with a letter",
                )
        for name, text, position in subtree_arguments(node, self._library):
            try:
                key_in(text, name)
            except BadValue as error:
                self._report.error(position, f'{SUBTREE} {node.id}: {name} is "{text}"; {error}')
        self._mandatory(node)

    def _unknown_tree(self, node: NodeDef) -> None:
        if self._registry.find(node.id) is not None:
            self._report.error(node.position, f"{node.id} is a node, not a tree; write <{node.id}>")
        elif self._library.complete:
            near = did_you_mean(node.id, self._library.trees)
            trees = listed(self._library.trees)
            self._report.error(node.position, f'there is no tree "{node.id}"{near}; the trees are: {trees}')

    def _mandatory(self, node: NodeDef) -> None:
        for port in mandatory_ports(node, self._library):
            where = f"<TreeNodesModel> at {port.position}"
            self._report.error(node.position, f"{SUBTREE} {node.id} needs {port.name} ({where})")

    def _cycles(self) -> None:
        """Depth-first over the trees, without recursion: a mission may have very many."""
        done: set[str] = set()
        for start in self._library.trees.values():
            # tree ID -> what is still to be looked at in it; the keys are the chain from `start`
            chain: dict[str, Iterator[NodeDef]] = {start.id: _subtrees(start)} if start.id not in done else {}
            while chain:
                current = next(reversed(chain))
                node = next(chain[current], None)
                if node is None:
                    done.add(current)
                    del chain[current]
                elif node.id in chain:
                    trees = list(chain)
                    circle = [*trees[trees.index(node.id) :], node.id]
                    self._report.error(node.position, f"a tree cannot contain itself: {' > '.join(circle)}")
                elif node.id in self._library.trees and node.id not in done:
                    chain[node.id] = _subtrees(self._library.trees[node.id])

    # -- <TreeNodesModel> --------------------------------------------------------------------------------------------

    def _model(self, model: NodeModel) -> None:
        """Lightly: what a palette says of a node we know must be true; nodes we do not know are nobody's business."""
        spec = self._registry.find(model.id)
        if spec is None or model.form is Form.SUBTREE:
            return
        for port in model.ports:
            if port.name not in spec.ports and port.name not in CONDITIONS:
                near = did_you_mean(port.name, spec.ports)
                self._report.warning(
                    port.position,
                    f"{model.id} has no port {port.name}{near}; its ports: {listed(spec.ports)}",
                )


def _subtrees(tree: TreeDef) -> Iterator[NodeDef]:
    return (node for node in _walk(tree) if node.is_subtree)


def _walk(tree: TreeDef) -> Iterator[NodeDef]:
    stack = [tree.root] if tree.root is not None else []
    while stack:
        node = stack.pop()
        yield node
        stack.extend(reversed(node.children))

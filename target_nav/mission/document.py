"""Elements into the document model: the frame of a mission file, its trees, includes and node models.

What a node may be called and which attributes it takes is not looked at here; see `check`.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from target_nav.mission.model import (
    Attribute,
    Form,
    IncludeDef,
    MissionFile,
    NodeDef,
    NodeModel,
    PortModel,
    TreeDef,
)
from target_nav.mission.parse import Element
from target_nav.mission.problems import Report, did_you_mean, listed

FORMAT = "4"
ROOT_CHILDREN = ("include", "BehaviorTree", "TreeNodesModel")
ROOT_ATTRIBUTES = ("BTCPP_format", "main_tree_to_execute", "project_name")
EXPLICIT_FORMS = tuple(form.value for form in Form if form is not Form.COMPACT)
PORT_TAGS = {"input_port": "input", "output_port": "output", "inout_port": "inout"}

METADATA = ("_description", "_favorite", "_fullpath", "_uid", "_collapsed")
"""Attributes that editors and BehaviorTree.CPP's own exporter leave behind; they change nothing."""


def read_document(root: Element, path: Path, shown: str, report: Report) -> MissionFile:
    """The model of one file. What is wrong is reported and left out."""
    if root.tag != "root":
        report.error(
            root.position,
            f'<{root.tag}> cannot be a mission\'s first tag; it must be <root BTCPP_format="4">',
        )
    else:
        _check_root(root, report)
    includes: list[IncludeDef] = []
    trees: list[TreeDef] = []
    models: list[NodeModel] = []
    model_lists: list[Element] = []
    for child in root.children if root.tag == "root" else ():
        if child.tag == "include":
            includes.extend(_include(child, report))
        elif child.tag == "BehaviorTree":
            trees.extend(_tree(child, len(root.children) == 1, report))
        elif child.tag == "TreeNodesModel":
            model_lists.append(child)
            models.extend(_models(child, report))
        else:
            near = did_you_mean(child.tag, ROOT_CHILDREN)
            report.error(
                child.position,
                f"<{child.tag}> cannot stand in <root>{near}; allowed: {listed(ROOT_CHILDREN)}",
            )
    for extra in model_lists[1:]:
        report.error(extra.position, "a second <TreeNodesModel>; a file has one at most")
    return MissionFile(
        path,
        shown,
        root.attribute("main_tree_to_execute"),
        tuple(includes),
        tuple(trees),
        tuple(models),
        root.position,
    )


def _check_root(root: Element, report: Report) -> None:
    _no_text(root, report)
    format_ = root.attribute("BTCPP_format")
    if format_ is None:
        report.error(root.position, f'BTCPP_format is missing; write <root BTCPP_format="{FORMAT}">')
    elif format_.value != FORMAT:
        report.error(
            format_.position,
            f'BTCPP_format is "{format_.value}"; only "{FORMAT}" (BehaviorTree.CPP 4) is understood',
        )
    # The XSD that an editor checks against is named by attributes of XML's own.
    own = [each for each in root.attributes if not each.name.startswith(("xmlns", "xsi:"))]
    _only(own, ROOT_ATTRIBUTES, "<root>", report)


def _include(element: Element, report: Report) -> list[IncludeDef]:
    _empty(element, report)
    _only(element.attributes, ("path", "ros_pkg"), "<include>", report)
    path = element.attribute("path")
    if path is None or not path.value.strip():
        report.error(path.position if path else element.position, "<include> needs path, the file to include")
        return []
    return [IncludeDef(path, element.attribute("ros_pkg"), element.position)]


def _tree(element: Element, alone: bool, report: Report) -> list[TreeDef]:
    _no_text(element, report)
    _only(element.attributes, ("ID", *METADATA), "<BehaviorTree>", report)
    roots = [_node(child, report) for child in element.children]
    identifier = element.attribute("ID")
    if len(element.children) != 1:
        report.error(
            element.position,
            f"<BehaviorTree{_id_text(identifier)}> has {len(element.children)} children; it must have exactly one",
        )
    if identifier is not None and identifier.value:
        name = identifier.value
    elif alone and identifier is None:
        # BehaviorTree.CPP lets the only tree of a file go without a name and calls it so.
        name = "BehaviorTree_0"
    else:
        report.error(element.position, '<BehaviorTree> needs ID, as in <BehaviorTree ID="Main">')
        return []
    return [TreeDef(name, roots[0] if roots else None, element.position)]


def _id_text(identifier: Attribute | None) -> str:
    return f' ID="{identifier.value}"' if identifier else ""


def _node(element: Element, report: Report) -> NodeDef:
    _no_text(element, report)
    children = tuple(_node(child, report) for child in element.children)
    identifier, name = element.attribute("ID"), element.attribute("name")
    form = Form(element.tag) if element.tag in EXPLICIT_FORMS else Form.COMPACT
    if form is Form.COMPACT:
        id_ = element.tag
        if identifier is not None:
            report.error(
                identifier.position,
                f'ID is not allowed in <{id_}>; it belongs to <Action ID="{id_}"> and the like',
            )
    elif identifier is None or not identifier.value:
        report.error(
            identifier.position if identifier else element.position,
            f"<{element.tag}> needs ID, the name of {'a tree' if form is Form.SUBTREE else 'the node'}",
        )
        id_ = ""
    else:
        id_ = identifier.value
    attributes = tuple(each for each in element.attributes if each.name not in ("ID", "name"))
    shown = name.value if name is not None and name.value else id_
    return NodeDef(id_, form, shown, name is not None, attributes, children, element.position)


def _models(element: Element, report: Report) -> list[NodeModel]:
    _no_text(element, report)
    found: list[NodeModel] = []
    for child in element.children:
        if child.tag not in EXPLICIT_FORMS:
            allowed = listed(EXPLICIT_FORMS)
            report.error(
                child.position, f"<{child.tag}> cannot stand in <TreeNodesModel>; allowed: {allowed}"
            )
            continue
        identifier = child.attribute("ID")
        if identifier is None or not identifier.value:
            report.error(child.position, f"<{child.tag}> needs ID, the name of the node")
            continue
        found.append(
            NodeModel(Form(child.tag), identifier.value, tuple(_ports(child, report)), child.position)
        )
    return found


def _ports(element: Element, report: Report) -> Iterable[PortModel]:
    for child in element.children:
        if child.tag == "MetadataFields":
            continue
        if child.tag not in PORT_TAGS:
            report.error(
                child.position,
                f"<{child.tag}> cannot stand here; allowed: {listed(PORT_TAGS)}, MetadataFields",
            )
            continue
        name = child.attribute("name")
        if name is None or not name.value:
            report.error(child.position, f"<{child.tag}> needs name")
            continue
        default = child.attribute("default")
        yield PortModel(name.value, PORT_TAGS[child.tag], default.value if default else None, child.position)


def _only(attributes: Iterable[Attribute], allowed: tuple[str, ...], where: str, report: Report) -> None:
    for attribute in attributes:
        if attribute.name not in allowed:
            shown = [name for name in allowed if name not in METADATA]
            near = did_you_mean(attribute.name, allowed)
            report.error(
                attribute.position,
                f"{where} has no attribute {attribute.name}{near}; allowed: {listed(shown)}",
            )


def _no_text(element: Element, report: Report) -> None:
    if element.text:
        text = element.text if len(element.text) <= 20 else f"{element.text[:20]}..."
        report.error(
            element.position, f'text "{text}" between the tags of <{element.tag}>; only tags may stand there'
        )


def _empty(element: Element, report: Report) -> None:
    _no_text(element, report)
    for child in element.children:
        report.error(child.position, f"<{child.tag}> cannot stand in <{element.tag}>, which has no children")

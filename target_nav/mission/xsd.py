"""An XML schema of mission files, for editors: they complete names, show documentation and underline what is wrong.

It says what a schema can say: names, types, units' limits, how many children. What goes to which key, and whether a
subtree exists, only `target-nav check` knows. XSD 1.0, which every editor understands.
"""

from __future__ import annotations

from collections.abc import Iterable
from enum import Enum
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from target_nav.mission.btcpp import CONDITIONS
from target_nav.mission.document import FORMAT, METADATA, PORT_TAGS, ROOT_ATTRIBUTES
from target_nav.mission.model import SUBTREE, Form
from target_nav.mission.port_types import unit_of
from target_nav.mission.registry import NodeKind, NodeRegistry, NodeSpec
from target_nav.mission.vocabulary import form_of, port_type, value_text

NAMESPACE = "http://www.w3.org/2001/XMLSchema"
REFERENCE_PATTERN = r" *(\{[^{}]+\}|=) *"
NUMBER_PATTERN = r"[+\-]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+\-]?[0-9]{1,4})?"
BOOLEANS = ("true", "True", "TRUE", "1", "false", "False", "FALSE", "0")
EXPLICIT = tuple(form.value for form in Form if form is not Form.COMPACT)
TEXT = "xs:string"


def write_xsd(registry: NodeRegistry) -> str:
    """The schema's text."""
    # types are named in attributes, with the prefix as a part of the text
    ElementTree.register_namespace("xs", NAMESPACE)
    schema = Element(f"{{{NAMESPACE}}}schema")
    specs = registry.specs()
    _frame(schema)
    _models(schema)
    _groups(schema, [spec.name for spec in specs])
    for spec in specs:
        _node(schema, spec)
    for form in (Form.ACTION, Form.CONDITION, Form.CONTROL, Form.DECORATOR):
        _explicit(schema, form, [spec for spec in specs if form in spec.kind.forms])
    _subtree(schema)
    ElementTree.indent(schema)
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(schema, encoding="unicode") + "\n"
    )


def _add(parent: Element, tag: str, **attributes: str) -> Element:
    return ElementTree.SubElement(parent, f"{{{NAMESPACE}}}{tag}", attributes)


def _document(parent: Element, text: str) -> None:
    if text:
        _add(_add(parent, "annotation"), "documentation").text = text


def _element(schema: Element, name: str, doc: str = "") -> Element:
    """A global element; returns its type, to be filled."""
    element = _add(schema, "element", name=name)
    _document(element, doc)
    return _add(element, "complexType")


def _texts(parent: Element, names: Iterable[str]) -> None:
    for name in names:
        _add(parent, "attribute", name=name, type=TEXT)


def _enumeration(parent: Element, values: Iterable[str]) -> None:
    restriction = _add(parent, "restriction", base=TEXT)
    for value in values:
        _add(restriction, "enumeration", value=value)


# -- what does not depend on the vocabulary ----------------------------------------------------------------------------


def _frame(schema: Element) -> None:
    root = _element(schema, "root")
    choice = _add(root, "choice", minOccurs="0", maxOccurs="unbounded")
    for name in ("include", "BehaviorTree", "TreeNodesModel"):
        _add(choice, "element", ref=name)
    _add(root, "attribute", name="BTCPP_format", type=TEXT, use="required", fixed=FORMAT)
    _texts(root, (name for name in ROOT_ATTRIBUTES if name != "BTCPP_format"))
    include = _element(schema, "include")
    _add(include, "attribute", name="path", type=TEXT, use="required")
    _texts(include, ["ros_pkg"])
    tree = _element(schema, "BehaviorTree")
    _add(tree, "group", ref="node")
    _texts(tree, ["ID"])
    _add(tree, "attributeGroup", ref="metadata")


def _models(schema: Element) -> None:
    """What Groot2 writes for its palette; lightly, as it is nobody's hand that writes it."""
    models = _add(_element(schema, "TreeNodesModel"), "choice", minOccurs="0", maxOccurs="unbounded")
    for form in EXPLICIT:
        _add(models, "element", name=form, type="model_entry")
    entry = _add(schema, "complexType", name="model_entry")
    choice = _add(entry, "choice", minOccurs="0", maxOccurs="unbounded")
    for tag in PORT_TAGS:
        port = _add(_add(choice, "element", name=tag), "complexType", mixed="true")
        _add(port, "attribute", name="name", type=TEXT, use="required")
        _add(port, "anyAttribute", processContents="skip")
    metadata = _add(_add(choice, "element", name="MetadataFields"), "complexType")
    _add(_add(metadata, "sequence"), "any", minOccurs="0", maxOccurs="unbounded", processContents="skip")
    _add(entry, "attribute", name="ID", type=TEXT, use="required")
    _add(entry, "anyAttribute", processContents="skip")


def _groups(schema: Element, names: list[str]) -> None:
    choice = _add(_add(schema, "group", name="node"), "choice")
    for name in (*names, *EXPLICIT):
        _add(choice, "element", ref=name)
    _texts(_add(schema, "attributeGroup", name="metadata"), METADATA)
    any_node = _add(schema, "attributeGroup", name="any_node")
    _texts(any_node, ("name", *CONDITIONS))
    _add(any_node, "attributeGroup", ref="metadata")
    reference = _add(schema, "simpleType", name="reference")
    _document(reference, "A key of the blackboard: {key}, {@key}, {=}")
    _add(_add(reference, "restriction", base=TEXT), "pattern", value=REFERENCE_PATTERN)


def _subtree(schema: Element) -> None:
    doc = "Another tree of the mission; its other attributes are that tree's parameters."
    subtree = _element(schema, SUBTREE, doc)
    _add(subtree, "attribute", name="ID", type=TEXT, use="required")
    _texts(subtree, ["_autoremap"])
    _add(subtree, "attributeGroup", ref="any_node")
    # a schema cannot know its parameters
    _add(subtree, "anyAttribute", processContents="skip")


# -- nodes -------------------------------------------------------------------------------------------------------------


def _node(schema: Element, spec: NodeSpec) -> None:
    node = _element(schema, spec.name, spec.doc)
    least, most = spec.children
    if most != 0:
        _add(
            node,
            "group",
            ref="node",
            minOccurs=str(least),
            maxOccurs="unbounded" if most is None else str(most),
        )
    for name in spec.ports:
        _port(node, name, spec)
    _add(node, "attributeGroup", ref="any_node")


def _explicit(schema: Element, form: Form, specs: list[NodeSpec]) -> None:
    """`<Action ID="Drive" .../>`: which attributes belong to which ID is more than a schema can say."""
    node = _element(schema, form.value, f"The explicit form of a {form.value.lower()}.")
    if form not in NodeKind.LEAF.forms:
        _add(node, "group", ref="node", minOccurs="1", maxOccurs="unbounded")
    identifier = _add(_add(node, "attribute", name="ID", use="required"), "simpleType")
    # an editor offers them in this order: first those that are meant
    _enumeration(
        identifier, (spec.name for spec in sorted(specs, key=lambda each: form_of(each) is not form))
    )
    _add(node, "attributeGroup", ref="any_node")
    _add(node, "anyAttribute", processContents="skip")


def _port(node: Element, name: str, spec: NodeSpec) -> None:
    port, is_output = spec.port(name), name in spec.outputs
    attribute = _add(node, "attribute", name=name)
    if port.required and not port.has_default and not is_output:
        attribute.set("use", "required")
    _document(attribute, _port_doc(name, spec))
    kind = _add(attribute, "simpleType")
    if is_output:
        _add(kind, "restriction", base="reference")
    elif _has_literals(port.data_type):
        union = _add(kind, "union", memberTypes="reference")
        _literal(_add(union, "simpleType"), port.data_type, spec.limits.get(name))
    else:
        _add(kind, "restriction", base=TEXT)


def _port_doc(name: str, spec: NodeSpec) -> str:
    port = spec.port(name)
    unit = unit_of(name)
    words = [f"{port_type(name, spec)}{f' in {unit}' if unit else ''}"]
    if name in spec.limits:
        words.append(f"{spec.limits[name][0]:.12g} ... {spec.limits[name][1]:.12g}")
    if port.has_default:
        words.append(f"default {value_text(port.default_value)}")
    role = "Output" if name in spec.outputs else "Input"
    return f"{role}: {port.description} ({'; '.join(words)})"


def _is_enum(data_type: Any) -> bool:
    return isinstance(data_type, type) and issubclass(data_type, Enum)


def _has_literals(data_type: Any) -> bool:
    """Whether a literal of the type is more than any text."""
    return data_type in (bool, int, float) or _is_enum(data_type)


def _literal(parent: Element, data_type: Any, limits: tuple[float, float] | None) -> None:
    if data_type is bool:
        _enumeration(parent, BOOLEANS)
    elif _is_enum(data_type):
        _enumeration(parent, data_type.__members__)
    else:
        restriction = _add(parent, "restriction", base="xs:integer" if data_type is int else "xs:double")
        if data_type is float:
            # xs:double also has INF and NaN, which a mission has not
            _add(restriction, "pattern", value=NUMBER_PATTERN)
        if limits is not None:
            _add(restriction, "minInclusive", value=f"{limits[0]:.12g}")
            _add(restriction, "maxInclusive", value=f"{limits[1]:.12g}")

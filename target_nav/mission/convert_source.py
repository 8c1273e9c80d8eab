"""A mission file as a person wrote it: elements with their comments, read from either notation.

Comments are no part of a mission, so the loader's readers drop them; who rewrites a file must keep them. They hang on
the element they stand before, beside (on the same line) or at the end of.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from target_nav.mission.parse import Element
from target_nav.mission.problems import Position

ONLY_TREE = "BehaviorTree_0"
"""What BehaviorTree.CPP calls the only tree of a file when it has no ID."""


@dataclass
class Part:
    """One element. A comment is its text, lines separated by newlines, indentation and marks taken off."""

    tag: str
    attributes: list[tuple[str, str]]
    text: str
    position: Position
    children: list[Part] = field(default_factory=list)
    before: list[str] = field(default_factory=list)
    beside: str = ""
    end: list[str] = field(default_factory=list)
    """After the last child."""

    def walk(self) -> Iterator[Part]:
        yield self
        for child in self.children:
            yield from child.walk()

    def get(self, name: str) -> str | None:
        return next((value for each, value in self.attributes if each == name), None)


def end_of(part: Part) -> list[str]:
    """Where comments behind a part's last child go; before a part that has no children."""
    if part.tag == "BehaviorTree" and part.children and part.children[0].children:
        # behind a tree's only node is a place that YAML does not have
        return part.children[0].end
    return part.end if part.children else part.before


@dataclass
class Source:
    """A whole file. `footer` are the comments after everything."""

    root: Part
    footer: list[str] = field(default_factory=list)


def parts_of(root: Element) -> tuple[Part, dict[int, Part]]:
    """The elements as parts without comments, and each part by the id() of its element."""
    by_element: dict[int, Part] = {}

    def part(element: Element) -> Part:
        attributes = [(each.name, each.value) for each in element.attributes]
        made = Part(element.tag, attributes, element.text, element.position)
        by_element[id(element)] = made
        made.children = [part(child) for child in element.children]
        return made

    made = part(root)
    trees = [child for child in made.children if child.tag == "BehaviorTree"]
    if len(made.children) == 1 and trees and trees[0].get("ID") is None:
        trees[0].attributes.insert(0, ("ID", ONLY_TREE))
    return made, by_element


def same_mission(one: Part, other: Part) -> bool:
    """Whether two files say the same, comments and the order of the file's sections apart."""
    return _plain(one) == _plain(other)


def _plain(part: Part) -> object:
    children = part.children
    if part.tag == "root":
        order = {"include": 0, "BehaviorTree": 1}
        children = sorted(children, key=lambda child: order.get(child.tag, 2))
    return (part.tag, part.attributes, part.text, [_plain(child) for child in children])


def tidy_comment(lines: list[str]) -> str:
    """Lines of a comment, brought to one form: no common indentation, nothing blank at either end."""
    stripped = [line.expandtabs().rstrip() for line in lines]
    while stripped and not stripped[0]:
        stripped.pop(0)
    while stripped and not stripped[-1]:
        stripped.pop()
    indents = [len(line) - len(line.lstrip()) for line in stripped if line]
    common = min(indents, default=0)
    stripped = [line[common:] for line in stripped]
    if stripped:
        stripped[0] = stripped[0].lstrip()
    return "\n".join(stripped)

"""A tree for a terminal: a line a node, with its ports, and with its status where one was recorded."""

from __future__ import annotations

import io

from py_trees.common import Status
from rich.console import Console
from rich.text import Text
from rich.tree import Tree

from target_nav.mission.draw_nodes import DrawNode, Kind
from target_nav.mission.draw_scene import STATUS_MARKS

_KIND_COLOURS = {
    Kind.CONTROL: "blue",
    Kind.DECORATOR: "magenta",
    Kind.SUBTREE: "bright_black",
    Kind.CONDITION: "yellow",
    Kind.ACTION: "green",
}
_STATUS_COLOURS = {
    Status.RUNNING: "bold cyan",
    Status.SUCCESS: "green",
    Status.FAILURE: "red",
    Status.INVALID: "dim",
}


def text_of(root: DrawNode) -> Tree:
    """Something that a rich console prints, with colours where it has any."""
    tree = Tree(_line(root), guide_style="dim")
    _add(tree, root)
    return tree


def plain_text_of(root: DrawNode) -> str:
    """The same without colours, lines of any length."""
    stream = io.StringIO()
    Console(file=stream, width=10_000, color_system=None, highlight=False).print(text_of(root))
    return "".join(f"{line.rstrip()}\n" for line in stream.getvalue().splitlines())


def _add(tree: Tree, node: DrawNode) -> None:
    for child in node.children:
        _add(tree.add(_line(child)), child)


def _line(node: DrawNode) -> Text:
    line = Text()
    style = _KIND_COLOURS[node.kind]
    if node.status is not None:
        style = _STATUS_COLOURS[node.status]
        line.append(f"{STATUS_MARKS[node.status] or '·'} ", style=style)
    if node.symbol:
        line.append(f"{node.symbol} ", style=style)
    line.append(node.title, style=f"bold {style}" if node.status is None else style)
    if node.word:
        line.append(f" ({node.word})", style="dim")
    if node.ports:
        line.append(f"  {', '.join(node.ports)}", style="dim")
    return line

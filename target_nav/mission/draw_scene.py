"""A placed tree as shapes with colours, the same for every kind of picture."""

from __future__ import annotations

from dataclasses import dataclass, field

from py_trees.common import Status

from target_nav.mission.draw_layout import (
    LINE_PX,
    PAD_X,
    PAD_Y,
    SMALL_PX,
    TITLE_PX,
    Box,
    Pile,
    small_lines,
    text_width,
)
from target_nav.mission.draw_nodes import Kind

MARGIN_PX = 16.0
CAPTION_PX = 14.0
INK, FAINT, EDGE = "#1b1f24", "#57606a", "#8c959f"
PALE = "#9aa2ab"


@dataclass(frozen=True)
class Style:
    fill: str
    stroke: str
    width: float = 1.2
    dashed: bool = False


KIND_STYLES = {
    Kind.CONTROL: Style("#e7eefb", "#4a6fb5"),
    Kind.DECORATOR: Style("#f1eafa", "#8a63b5"),
    Kind.SUBTREE: Style("#f3f4f6", "#6b7280", dashed=True),
    Kind.CONDITION: Style("#fdf4dc", "#b58a2b"),
    Kind.ACTION: Style("#e6f4ea", "#4b9460"),
}
# Okabe and Ito's palette, told apart by colour-blind eyes; the marks say the same without colour
STATUS_STYLES = {
    Status.RUNNING: Style("#d6ecfa", "#0072b2", 2.6),
    Status.SUCCESS: Style("#d3efe4", "#009e73", 1.8),
    Status.FAILURE: Style("#fbdccb", "#d55e00", 1.8),
    Status.INVALID: Style("#ffffff", "#c9ced6"),
}
STATUS_MARKS = {Status.RUNNING: "▶", Status.SUCCESS: "✔", Status.FAILURE: "✘", Status.INVALID: ""}


@dataclass(frozen=True)
class Rectangle:
    x: float
    y: float
    width: float
    height: float
    radius: float
    style: Style


@dataclass(frozen=True)
class Curve:
    """From the right edge of a parent to the left edge of a child, level at both ends."""

    x0: float
    y0: float
    x1: float
    y1: float
    colour: str
    width: float

    @property
    def bend_x(self) -> float:
        return (self.x0 + self.x1) / 2.0


@dataclass(frozen=True)
class Text:
    """`x`, `y` is the left end of its base line."""

    x: float
    y: float
    text: str
    size_px: float
    colour: str
    bold: bool = False


@dataclass
class Scene:
    """Shapes in the order in which they are painted; sizes in pixels, y downwards."""

    title: str
    width: float = 0.0
    height: float = 0.0
    shapes: list[Rectangle | Curve | Text] = field(default_factory=list)


def scene_of(root: Pile, caption: str) -> Scene:
    """The picture of a placed tree, with a line of text above it, and a legend if it shows statuses."""
    scene = Scene(caption)
    left, top = MARGIN_PX, MARGIN_PX + (2 * CAPTION_PX if caption else 0.0)
    piles = list(root.walk())
    right = left + max(pile.boxes[0].x + pile.width for pile in piles)
    bottom = top + max(pile.bottom for pile in piles)
    if caption:
        scene.shapes.append(Text(left, MARGIN_PX + CAPTION_PX, caption, CAPTION_PX, INK, bold=True))
        right = max(right, left + text_width(caption, CAPTION_PX, bold=True))
    for pile in piles:
        for child in pile.children:
            scene.shapes.append(_edge(pile.boxes[-1], child.boxes[0], left, top))
    for pile in piles:
        for box in pile.boxes:
            _draw_box(scene, box, left + box.x, top + box.y)
    if root.boxes[0].node.status is not None:
        right = max(right, _legend(scene, left, bottom + MARGIN_PX))
        bottom += MARGIN_PX + LINE_PX + 2 * PAD_Y
    scene.width, scene.height = right + MARGIN_PX, bottom + MARGIN_PX
    return scene


def _edge(parent: Box, child: Box, left: float, top: float) -> Curve:
    ticked = child.node.status in (None, Status.RUNNING, Status.SUCCESS, Status.FAILURE)
    running = child.node.status is Status.RUNNING
    colour = STATUS_STYLES[Status.RUNNING].stroke if running else EDGE if ticked else "#d5d9df"
    return Curve(
        left + parent.x + parent.width,
        top + parent.middle_y,
        left + child.x,
        top + child.middle_y,
        colour,
        2.4 if running else 1.3,
    )


def _draw_box(scene: Scene, box: Box, x: float, y: float) -> None:
    node = box.node
    style = KIND_STYLES[node.kind] if node.status is None else STATUS_STYLES[node.status]
    if node.status is not None and node.kind is Kind.SUBTREE:
        style = Style(style.fill, style.stroke, style.width, dashed=True)
    # conditions are rounder, so that they are told from actions without colour
    radius = min(box.height / 2.0, 14.0) if node.kind is Kind.CONDITION else 4.0
    scene.shapes.append(Rectangle(x, y, box.width, box.height, radius, style))
    pale = node.status is Status.INVALID
    baseline = y + PAD_Y + LINE_PX - 4.0
    text_x = x + PAD_X
    if node.symbol:
        scene.shapes.append(
            Text(
                text_x,
                baseline,
                node.symbol,
                TITLE_PX,
                PALE if pale else KIND_STYLES[Kind.CONTROL].stroke,
                bold=True,
            )
        )
        text_x += text_width(f"{node.symbol} ", TITLE_PX, bold=True)
    scene.shapes.append(Text(text_x, baseline, node.title, TITLE_PX, PALE if pale else INK, bold=True))
    for number, line in enumerate(small_lines(node), start=1):
        scene.shapes.append(
            Text(x + PAD_X, baseline + number * LINE_PX, line, SMALL_PX, PALE if pale else FAINT)
        )
    if node.status is not None and STATUS_MARKS[node.status]:
        mark = STATUS_MARKS[node.status]
        scene.shapes.append(
            Text(
                x + box.width - PAD_X - TITLE_PX,
                baseline,
                mark,
                TITLE_PX,
                STATUS_STYLES[node.status].stroke,
                bold=True,
            )
        )


def _legend(scene: Scene, x: float, y: float) -> float:
    """A row of samples; returns where it ends."""
    names = {
        Status.RUNNING: "running",
        Status.SUCCESS: "success",
        Status.FAILURE: "failure",
        Status.INVALID: "not ticked",
    }
    for status, name in names.items():
        label = f"{STATUS_MARKS[status]} {name}".strip()
        width = text_width(label, SMALL_PX) + 2 * PAD_X
        scene.shapes.append(Rectangle(x, y, width, LINE_PX + PAD_Y, 4.0, STATUS_STYLES[status]))
        scene.shapes.append(Text(x + PAD_X, y + LINE_PX, label, SMALL_PX, FAINT))
        x += width + PAD_X
    return x

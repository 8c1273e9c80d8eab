"""Where the boxes of a tree go: the root at the left, children at the right of their parent, nothing overlaps.

A node with one child, a decorator or a SubTree, is piled on that child: it says something about it, and a tree of a
dozen levels still fits on a screen.

Each subtree is packed against the one above it along its real outline, so short branches do not keep the room of long
ones free. After Reingold and Tilford, "Tidier Drawings of Trees" (1981), with boxes of any size in place of points.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from target_nav.mission.draw_nodes import DrawNode, Kind

TITLE_PX, SMALL_PX = 13.0, 11.0
LINE_PX = 15.0
PAD_X, PAD_Y = 9.0, 6.0
GAP_X, GAP_Y, PILE_GAP_Y = 34.0, 10.0, 2.0
MARK_PX = 21.0
"""Kept free at the right for the mark of a status."""

_STEP_PX = 8.0
"""Outlines are kept in steps of so many pixels."""

# Advance widths of DejaVu Sans in percent of its size, U+0020 to U+007E; most other fonts are narrower.
# fmt: off
_WIDTHS = (
    32, 40, 46, 84, 64, 95, 78, 27, 39, 39, 50, 84, 32, 36, 32, 34, 64, 64, 64, 64, 64, 64, 64, 64,
    64, 64, 34, 34, 84, 84, 84, 53, 100, 68, 69, 70, 77, 63, 58, 77, 75, 29, 29, 66, 56, 86, 75, 79,
    60, 79, 69, 63, 61, 73, 68, 99, 69, 61, 69, 39, 34, 39, 84, 50, 50, 61, 63, 55, 63, 62, 35, 63,
    63, 28, 28, 58, 28, 97, 63, 61, 63, 63, 41, 52, 39, 63, 59, 82, 59, 59, 52, 64, 34, 64, 84,
)
# fmt: on
_OTHER_WIDTH = 100
_BOLD = 1.14
"""Bold letters are wider by up to so much, averaged over a word."""


def text_width(text: str, size_px: float, bold: bool = False) -> float:
    """In pixels, on the safe side."""
    percent = sum(_WIDTHS[ord(c) - 32] if " " <= c <= "~" else _OTHER_WIDTH for c in text)
    return percent / 100.0 * size_px * (_BOLD if bold else 1.0)


@dataclass
class Box:
    """One node's rectangle; `x`, `y` is its upper left corner, y downwards."""

    node: DrawNode
    height: float
    width: float = 0.0
    x: float = 0.0
    y: float = 0.0

    @property
    def middle_y(self) -> float:
        return self.y + self.height / 2.0


@dataclass
class Pile:
    """Boxes on each other, as wide as the widest: the last is a leaf or has the children, the others wrap it."""

    boxes: list[Box]
    children: list[Pile]

    def walk(self) -> Iterator[Pile]:
        yield self
        for child in self.children:
            yield from child.walk()

    @property
    def width(self) -> float:
        return self.boxes[0].width

    @property
    def bottom(self) -> float:
        return self.boxes[-1].y + self.boxes[-1].height

    def move(self, dy: float) -> None:
        for box in self.boxes:
            box.y += dy


def small_lines(node: DrawNode) -> list[str]:
    """What stands under the title."""
    return [*([node.word] if node.word else []), *node.ports]


def place(root: DrawNode) -> Pile:
    """The tree with its places; the upper left corner of all of it is at 0, 0."""
    pile = _pile(root)
    _pack(pile, 0.0)
    top = min(each.boxes[0].y for each in pile.walk())
    for each in pile.walk():
        each.move(-top)
    return pile


def _pile(node: DrawNode) -> Pile:
    boxes = [_box(node)]
    while len(node.children) == 1 and node.kind in (Kind.DECORATOR, Kind.SUBTREE):
        node = node.children[0]
        boxes.append(_box(node))
    width = max(box.width for box in boxes)
    y = 0.0
    for box in boxes:
        box.width, box.y = width, y
        y += box.height + PILE_GAP_Y
    return Pile(boxes, [_pile(child) for child in node.children])


def _box(node: DrawNode) -> Box:
    symbol = text_width(f"{node.symbol} ", TITLE_PX, bold=True) if node.symbol else 0.0
    widths = [
        symbol + text_width(node.title, TITLE_PX, bold=True) + (MARK_PX if node.status is not None else 0.0)
    ]
    small = small_lines(node)
    widths += [text_width(line, SMALL_PX) for line in small]
    return Box(node, 2 * PAD_Y + LINE_PX * (1 + len(small)), max(widths) + 2 * PAD_X)


@dataclass
class _Outline:
    """The upper and the lower edge of a subtree, by step along x."""

    upper: dict[int, float] = field(default_factory=dict)
    lower: dict[int, float] = field(default_factory=dict)

    def cover(self, x: float, width: float, top: float, bottom: float) -> None:
        for step in range(int(x // _STEP_PX), int((x + width) // _STEP_PX) + 1):
            self.upper[step] = min(top, self.upper.get(step, top))
            self.lower[step] = max(bottom, self.lower.get(step, bottom))

    def distance_below(self, other: _Outline) -> float:
        """How far this one must be moved down to lie below `other` with a gap."""
        steps = self.upper.keys() & other.lower.keys()
        return max((other.lower[step] + GAP_Y - self.upper[step] for step in steps), default=0.0)

    def add(self, other: _Outline, shift: float) -> None:
        for step, top in other.upper.items():
            self.upper[step] = min(top + shift, self.upper.get(step, top + shift))
        for step, bottom in other.lower.items():
            self.lower[step] = max(bottom + shift, self.lower.get(step, bottom + shift))


def _pack(pile: Pile, x: float) -> _Outline:
    """Places a subtree at `x`, and at whatever height its first box comes to lie."""
    for box in pile.boxes:
        box.x = x
    children_x = x + pile.width + GAP_X
    together = _Outline()
    for child in pile.children:
        outline = _pack(child, children_x)
        shift = outline.distance_below(together)
        for each in child.walk():
            each.move(shift)
        together.add(outline, shift)
    if pile.children:
        first, last = pile.children[0].boxes[0].middle_y, pile.children[-1].boxes[0].middle_y
        pile.move((first + last) / 2.0 - pile.boxes[-1].middle_y)
        # edges run here
        middle = pile.boxes[-1].middle_y
        together.cover(x + pile.width, GAP_X, min(first, middle) - GAP_Y, max(last, middle))
    together.cover(x, pile.width, pile.boxes[0].y, pile.bottom)
    return together

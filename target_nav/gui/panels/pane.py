"""What all panes share: a drawing area that shows the newest view, text that fits, and the veil over what is stale."""

from __future__ import annotations

import math
from typing import Any

from target_nav.gui.gtk import Gtk, cairo
from target_nav.gui.model import Views
from target_nav.gui.panels.style import BACKGROUND, FONT, GREY, LINE, ORANGE, PANE, TEXT, Colour

Context = Any
"""A cairo context; pycairo has no types."""


class Pane(Gtk.DrawingArea):
    """Draws one part of `Views`. Subclasses write `paint`."""

    def __init__(self, width: int = -1, height: int = -1) -> None:
        super().__init__()
        self.set_size_request(width, height)
        self.views: Views | None = None
        self.connect("draw", self._draw)

    def show_views(self, views: Views) -> None:
        self.views = views
        self.queue_draw()

    def paint(self, cr: Context, views: Views, width: float, height: float) -> None:
        raise NotImplementedError

    def _draw(self, widget: Any, cr: Context) -> bool:
        size = self.get_allocation()
        cr.set_source_rgb(*PANE)
        cr.paint()
        if self.views is not None:
            self.paint(cr, self.views, float(size.width), float(size.height))
        cr.set_source_rgb(*BACKGROUND)
        cr.set_line_width(2.0)
        cr.rectangle(0, 0, size.width, size.height)
        cr.stroke()
        return False


def text(
    cr: Context,
    x: float,
    y: float,
    words: str,
    size: float = 15.0,
    colour: Colour = TEXT,
    bold: bool = False,
    width: float = math.inf,
    align: float = 0.0,
) -> float:
    """One line with its baseline at `y`, cut with an ellipsis to `width`; `align` 0.5 centres it at x. Its width."""
    cr.select_font_face(
        FONT, cairo.FONT_SLANT_NORMAL, cairo.FONT_WEIGHT_BOLD if bold else cairo.FONT_WEIGHT_NORMAL
    )
    cr.set_font_size(size)
    advance = cr.text_extents(words).x_advance
    if advance > width:
        # every letter is about as wide as the next: one guess, then a letter at a time
        words = words[: max(int(len(words) * width / advance), 1)]
        while words and cr.text_extents(words + "…").x_advance > width:
            words = words[:-1]
        words += "…"
        advance = cr.text_extents(words).x_advance
    cr.set_source_rgb(*colour)
    cr.move_to(x - align * advance, y)
    cr.show_text(words)
    cr.new_path()
    return float(advance)


def veil(cr: Context, width: float, height: float, message: str, age: str = "") -> None:
    """Greys out what is stale, with hatching and words, so that it is seen without colour."""
    cr.save()
    cr.rectangle(0, 0, width, height)
    cr.clip()
    cr.set_source_rgba(0.25, 0.27, 0.30, 0.72)
    cr.paint()
    cr.set_source_rgba(0.05, 0.06, 0.08, 0.55)
    cr.set_line_width(5.0)
    step = 22.0
    for i in range(int((width + height) / step) + 1):
        cr.move_to(i * step, 0)
        cr.line_to(i * step - height, height)
    cr.stroke()
    cr.restore()
    lines = wrapped(message, int(width / 8.2)) or ["no data"]
    if age:
        lines = [f"STALE  {age}", *lines]
    top = height / 2.0 - 10.0 * len(lines)
    cr.set_source_rgba(0.05, 0.06, 0.08, 0.85)
    cr.rectangle(4, top - 6, width - 8, 20.0 * len(lines) + 12)
    cr.fill()
    for i, line in enumerate(lines):
        text(cr, width / 2.0, top + 14 + 20 * i, line, 14.0, ORANGE, bold=i == 0, width=width - 12, align=0.5)


def wrapped(words: str, most: int, lines: int = 3) -> list[str]:
    """Words in lines of at most `most` letters, at most so many lines."""
    rows: list[str] = []
    for word in words.split():
        if rows and len(rows[-1]) + len(word) + 1 <= most:
            rows[-1] += f" {word}"
        else:
            rows.append(word)
    if len(rows) > lines:
        rows = [*rows[: lines - 1], rows[lines - 1] + " …"]
    return rows


def grid_line(cr: Context, x0: float, y0: float, x1: float, y1: float, colour: Colour = LINE) -> None:
    cr.set_source_rgb(*colour)
    cr.set_line_width(1.0)
    cr.move_to(x0, y0)
    cr.line_to(x1, y1)
    cr.stroke()


def caption(cr: Context, words: str, colour: Colour = GREY) -> None:
    """The pane's name in its corner."""
    text(cr, 8, 17, words, 13.0, colour, bold=True)

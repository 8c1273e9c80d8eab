"""The mission's tree: all of it on its own page, the running path in a corner of the first one."""

from __future__ import annotations

from target_nav.gui.model import Views
from target_nav.gui.panels.pane import Context, Pane, caption, text, veil
from target_nav.gui.panels.style import GREY, LINE, STATUS_COLOUR, TEXT
from target_nav.gui.source import age_text
from target_nav.gui.view_tree import TreeRowView, path_to, shown_rows

ROW_HEIGHT = 24


class TreePane(Pane):
    """Shows as many rows as there is room for: the running path first. `lift` shifts the window by rows."""

    def __init__(self, width: int = -1, height: int = -1, compact: bool = False) -> None:
        super().__init__(width, height)
        self._compact = compact
        self.lift = 0

    def paint(self, cr: Context, views: Views, width: float, height: float) -> None:
        view = views.tree
        most = max(int((height - 24) / ROW_HEIGHT), 1)
        if self._compact:
            path = path_to(view, view.current)
            rows = tuple(view.rows[i] for i in path[-most:]) or shown_rows(view, most)
            base = rows[0].depth if rows else 0
        else:
            first = min(max(self._first(view.current, most) + self.lift, 0), max(len(view.rows) - most, 0))
            rows, base = view.rows[first : first + most], 0
        for i, row in enumerate(rows):
            _row(cr, row, 20 + ROW_HEIGHT * (i + 1) - 7, width, base)
        caption(cr, f"TREE  tick {view.tick}" + ("  PAUSED" if view.paused else ""))
        if not view.fresh:
            veil(cr, width, height, view.message, age_text(view.age_s) if view.rows else "")

    @staticmethod
    def _first(current: int, most: int) -> int:
        return max(current - most // 2, 0)


def _row(cr: Context, row: TreeRowView, y: float, width: float, base: int) -> None:
    x = 8.0 + 14.0 * (row.depth - base)
    colour = STATUS_COLOUR.get(row.status, TEXT) if row.active else GREY
    if row.active and row.status == "RUNNING":
        cr.set_source_rgb(*LINE)
        cr.rectangle(2, y - 17, width - 4, ROW_HEIGHT - 2)
        cr.fill()
    text(cr, x, y, row.mark, 15.0, colour, bold=True)
    used = text(cr, x + 19, y, row.name, 15.0, colour, bold=row.active, width=width - x - 24)
    if row.feedback:
        text(
            cr,
            x + 29 + used,
            y,
            row.feedback,
            13.0,
            TEXT if row.active else GREY,
            width=width - x - used - 36,
        )

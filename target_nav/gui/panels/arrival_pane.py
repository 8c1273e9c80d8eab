"""How near the end is: the gap in large letters, a bar up to the stand-off, and how it ended."""

from __future__ import annotations

import math

from target_nav.gui.model import Views
from target_nav.gui.panels.pane import Context, Pane, caption, text
from target_nav.gui.panels.style import BLUE, GREEN, GREY, LINE, ORANGE, TEXT, YELLOW
from target_nav.gui.source import age_text


class ArrivalPane(Pane):
    def paint(self, cr: Context, views: Views, width: float, height: float) -> None:
        view = views.arrival
        caption(cr, "ARRIVAL")
        if math.isfinite(view.gap_m):
            colour = TEXT if view.fresh else GREY
            text(cr, width / 2.0, 54, f"{view.gap_m:.2f} m", 34.0, colour, bold=True, align=0.5)
            text(
                cr,
                width / 2.0,
                74,
                f"to the target, stops at {view.stand_off_m:.2f} m",
                13.0,
                GREY,
                align=0.5,
            )
            seen = f"seen {age_text(view.seen_s)}, LiDAR {age_text(view.ranged_s)} ago"
            text(cr, width / 2.0, 92, seen, 13.0, GREY, align=0.5, width=width - 12)
        else:
            text(cr, width / 2.0, 60, "no target", 22.0, GREY, bold=True, align=0.5)
        top = 102.0
        cr.set_source_rgb(*LINE)
        cr.rectangle(12, top, width - 24, 14)
        cr.fill()
        cr.set_source_rgb(*(GREEN if view.succeeded else BLUE))
        cr.rectangle(12, top, (width - 24) * view.progress, 14)
        cr.fill()
        if view.done:
            mark, colour = ("✔", GREEN) if view.succeeded else ("!", ORANGE)
            text(cr, width / 2.0, top + 40, f"{mark} {view.title}", 22.0, colour, bold=True, align=0.5)
            text(cr, width / 2.0, top + 60, view.reason, 13.0, YELLOW, align=0.5, width=width - 12)

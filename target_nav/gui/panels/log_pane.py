"""What happened, the newest line at the bottom."""

from __future__ import annotations

from target_nav.gui.model import Views
from target_nav.gui.panels.pane import Context, Pane, caption, text
from target_nav.gui.panels.style import GREY, LEVEL_COLOUR, LEVEL_MARK, TEXT

ROW_HEIGHT = 23


class LogPane(Pane):
    """`lift` goes back in time, by lines."""

    lift = 0

    def paint(self, cr: Context, views: Views, width: float, height: float) -> None:
        most = max(int((height - 28) / ROW_HEIGHT), 1)
        events = views.events
        end = max(len(events) - max(self.lift, 0), min(most, len(events)))
        for i, event in enumerate(events[max(end - most, 0) : end]):
            y = 26 + ROW_HEIGHT * (i + 1) - 6
            text(cr, 8, y, event.clock_text, 14.0, GREY)
            colour = LEVEL_COLOUR.get(event.level, TEXT)
            text(cr, 84, y, f"{LEVEL_MARK.get(event.level, '')} {event.text}", 15.0, colour, width=width - 92)
        caption(cr, f"LOG  {len(events)} lines")

"""The bar at the top and the strip below it: state in large letters, sources with their ages, what is wrong."""

from __future__ import annotations

from target_nav.gui.commands import Said
from target_nav.gui.model import Views
from target_nav.gui.panels.pane import Context, Pane, text
from target_nav.gui.panels.style import (
    BACKGROUND,
    GREEN,
    GREY,
    LINE,
    ORANGE,
    SKY,
    TEXT,
    VERMILION,
    YELLOW,
)
from target_nav.gui.view_status import LinkView

_CHIP_WIDTH = 68.0


class StatusBar(Pane):
    def paint(self, cr: Context, views: Views, width: float, height: float) -> None:
        view = views.status
        room = width - _CHIP_WIDTH * len(view.links) - 16
        colour = GREY if not view.fresh else GREEN if view.state == "ARRIVED" else TEXT
        headline = view.headline if view.fresh or not view.state else f"? {view.headline}"
        text(cr, 10, 31, headline, 27.0, colour, bold=True, width=room)
        sub = (
            f"{view.mission or '-'} → {view.target or '-'}   {view.speed_mps:.2f} m/s   {view.rate_hz:.1f} Hz"
        )
        text(cr, 10, 50, sub, 13.0, TEXT if view.fresh else GREY, width=room)
        for i, link in enumerate(view.links):
            _chip(cr, width - _CHIP_WIDTH * (len(view.links) - i), link, height)


def _chip(cr: Context, x: float, link: LinkView, height: float) -> None:
    fine = link.fresh or link.quiet
    cr.set_source_rgb(*(LINE if fine else ORANGE))
    cr.rectangle(x + 2, 4, _CHIP_WIDTH - 5, height - 9)
    if fine:
        cr.set_line_width(2.0)
        cr.stroke()
    else:
        cr.fill()
    colour = TEXT if link.fresh else GREY if fine else BACKGROUND
    mark = "✔" if link.fresh else "–" if fine else "✘"
    middle = x + _CHIP_WIDTH / 2.0 - 0.5
    text(cr, middle, 23, f"{mark} {link.label}", 12.0, colour, bold=True, width=_CHIP_WIDTH - 8, align=0.5)
    text(cr, middle, 44, link.text, 14.0, colour, width=_CHIP_WIDTH - 8, align=0.5)


class Strip(Pane):
    """One line: what is wrong or what the robot says, and on the right what became of the operator's last word."""

    def __init__(self, width: int = -1, height: int = -1) -> None:
        super().__init__(width, height)
        self.said: Said | None = None
        self.panel_problem = ""
        self.now_s = 0.0

    def paint(self, cr: Context, views: Views, width: float, height: float) -> None:
        view = views.status
        told = 0.0
        if self.said is not None and (self.now_s - self.said.said_s < 6.0 or self.said.is_late(self.now_s)):
            told = self._tell_said(cr, self.said, width, height)
        banner = self.panel_problem or view.banner
        room = width - told - 24
        if banner:
            cr.set_source_rgb(*VERMILION)
            cr.rectangle(2, 2, width - told - 6, height - 4)
            cr.fill()
            text(cr, 10, height - 8, f"✘ {banner}", 18.0, TEXT, bold=True, width=room)
        elif view.outcome:
            good = view.outcome == "succeeded"
            words = f"{'✔' if good else '!'} {view.outcome}: {view.outcome_reason}"
            text(cr, 10, height - 8, words, 18.0, GREEN if good else YELLOW, bold=True, width=room)
        else:
            drives = (view.requested and not view.outcome) or view.manual
            limited = f"   (slowed: {view.limited_by})" if view.limited_by and drives else ""
            leaf = "" if view.manual else f"{view.leaf or '-'}: "
            words = f"{leaf}{view.reason}{limited}" if view.leaf or view.reason else ""
            text(cr, 10, height - 8, words, 18.0, SKY, width=room)

    def _tell_said(self, cr: Context, said: Said, width: float, height: float) -> float:
        words = said.text(self.now_s)
        late = said.is_late(self.now_s)
        if late:
            words, colour, mark = words.split(":")[0], BACKGROUND, "✘"
            cr.set_source_rgb(*ORANGE)
            cr.rectangle(0.5 * width, 2, 0.5 * width - 2, height - 4)
            cr.fill()
        elif said.acknowledged_s is not None:
            colour, mark = GREEN, "✔"
        else:
            colour, mark = TEXT, "…"
        used = text(
            cr, width - 8, height - 8, f"{mark} {words}", 17.0, colour, True, 0.5 * width - 16, align=1.0
        )
        return 0.5 * width if late else used + 16.0

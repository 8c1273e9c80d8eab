"""Driving by hand: fields to hold, with the radar beside them. Arrow keys and WASD do the same on this page."""

from __future__ import annotations

from functools import partial

from target_nav.gui.gtk import Gtk
from target_nav.gui.model import Views
from target_nav.gui.operator import Operator
from target_nav.gui.panels.hold_field import HoldField
from target_nav.gui.panels.radar_pane import RadarPane
from target_nav.gui.panels.widgets import column, label

_FIELDS = (
    ("turn_left", "⟲", "turn  Q"), ("forward", "▲", "ahead  W"), ("turn_right", "⟳", "turn  E"),
    ("left", "◀", "strafe  A"), ("back", "▼", "back  S"), ("right", "▶", "strafe  D"),
)  # fmt: skip


class DrivePage(Gtk.Box):
    def __init__(self, operator: Operator) -> None:
        super().__init__(orientation=Gtk.Orientation.HORIZONTAL, spacing=4)
        self._operator = operator
        self._fields: dict[str, HoldField] = {}
        grid = Gtk.Grid(row_homogeneous=True, column_homogeneous=True)
        for index, (direction, sign, words) in enumerate(_FIELDS):
            field = HoldField(sign, words, partial(self._hold, direction), partial(self._release, direction))
            field.set_size_request(112, 116)
            self._fields[direction] = field
            grid.attach(field, index % 3, index // 3, 1, 1)
        self._why = label("", wrap=True)
        self._speed = label("", "dim")
        # the radar is nearer here: what matters is what may be touched
        self.radar = RadarPane(reach_m=1.6)
        self.pack_start(column(self._why, grid, self._speed, spacing=6), False, False, 4)
        self.pack_start(self.radar, True, True, 0)

    def update(self, views: Views) -> None:
        status = views.status
        free = status.fresh and not status.requested
        if not status.fresh:
            words = "The nav process does not answer."
        elif status.requested:
            words = "A mission runs: STOP first, then drive by hand."
        else:
            words = "Hold a field or a key: the robot moves. Let go: it stops."
        self._why.set_text(words)
        if not free:
            self._operator.pad.release_all()
        held = self._operator.pad.held
        for direction, field in self._fields.items():
            if field.get_sensitive() != free or field.lit != (direction in held):
                field.lit = direction in held
                field.set_sensitive(free)
                field.queue_draw()
        manual = self._operator.settings.config.manual
        limited = f", slowed by {status.limited_by}" if status.limited_by else ""
        self._speed.set_text(f"{manual.speed_mps:.2f} m/s, {manual.yaw_rate_radps:.1f} rad/s{limited}")

    def _hold(self, direction: str) -> None:
        self._operator.pad.hold(direction, "pad")

    def _release(self, direction: str) -> None:
        self._operator.pad.release(direction, "pad")

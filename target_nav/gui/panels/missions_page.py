"""Which mission, which target; reset of odometry. Nothing here moves the robot: what is chosen waits for GO."""

from __future__ import annotations

from functools import partial
from typing import Any

from target_nav.gui.gtk import Gtk
from target_nav.gui.missions import MissionChoice
from target_nav.gui.model import Views
from target_nav.gui.operator import Operator
from target_nav.gui.panels.widgets import button, column, label, scrolled, set_class
from target_nav.state.types import CommandKind, TargetSpec


class MissionsPage(Gtk.Box):
    def __init__(
        self, operator: Operator, missions: tuple[MissionChoice, ...], targets: tuple[TargetSpec, ...]
    ) -> None:
        super().__init__(orientation=Gtk.Orientation.HORIZONTAL, spacing=8)
        self._operator = operator
        self._missions: dict[str, Any] = {}
        self._targets: list[tuple[TargetSpec | None, Any]] = []
        self._chosen: TargetSpec | None = None
        left = column(label("Mission", "big"))
        for mission in missions:
            made = button(mission.name.replace("_", " "), partial(operator.load, mission.path))
            self._missions[mission.name] = made
            left.pack_start(made, False, False, 0)
        if not missions:
            left.pack_start(label("no mission files found", "wrong"), False, False, 0)
        right = column(label("Target", "big"))
        for spec in (None, *targets):
            words = "as the mission says" if spec is None else _words(spec)
            made = button(words, partial(self._choose, spec))
            self._targets.append((spec, made))
            right.pack_start(made, False, False, 0)
        right.pack_start(label("Odometry", "big"), False, False, 6)
        reset = button("Reset: here is the origin", partial(operator.say, CommandKind.RESET_ODOM))
        right.pack_start(reset, False, False, 0)
        self._why = label("", "dim", wrap=True)
        right.pack_start(self._why, False, False, 4)
        self.pack_start(scrolled(left), True, True, 6)
        self.pack_start(scrolled(right), True, True, 6)
        self.reset = reset

    def update(self, views: Views) -> None:
        status = views.status
        free = status.fresh and not status.requested
        for name, made in self._missions.items():
            set_class(made, "chosen", name == status.mission)
            made.set_sensitive(free)
        for spec, made in self._targets:
            set_class(made, "chosen", spec == self._chosen)
            made.set_sensitive(free)
        self.reset.set_sensitive(free)
        self._why.set_text(
            "" if free else "STOP first: a mission runs." if status.fresh else "No nav process."
        )

    def _choose(self, spec: TargetSpec | None) -> None:
        self._chosen = spec
        self._operator.target(spec)


def _words(spec: TargetSpec) -> str:
    return f"{spec.class_name.replace('_', ' ')} {100 * spec.height_m:.0f} x {100 * spec.width_m:.0f} cm"

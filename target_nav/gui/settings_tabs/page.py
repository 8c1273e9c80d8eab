"""The settings page: sections on the left, their parameters in the middle, the editor on the right."""

from __future__ import annotations

from functools import partial
from typing import Any

from target_nav.gui.gtk import Gtk
from target_nav.gui.model import Views
from target_nav.gui.operator import Operator
from target_nav.gui.panels.widgets import button, column, label, row, scrolled, set_class
from target_nav.gui.settings import Setting
from target_nav.gui.settings_tabs.calibration_tab import CalibrationTab
from target_nav.gui.settings_tabs.editor import Editor
from target_nav.gui.settings_tabs.motor_tab import MotorTab
from target_nav.gui.source import World

MOTORS, CALIBRATION = "motor test", "calibrate"


class SettingsPage(Gtk.Box):
    def __init__(self, operator: Operator) -> None:
        super().__init__(orientation=Gtk.Orientation.HORIZONTAL, spacing=4)
        self._operator = operator
        self._sections: dict[str, Any] = {}
        self._chosen = ""
        names = column(spacing=3)
        for name in (MOTORS, CALIBRATION, *(s.name for s in operator.settings.sections())):
            made = button(name.replace("_", " "), partial(self.choose, name))
            self._sections[name] = made
            names.pack_start(made, False, False, 0)
        self._list = column(spacing=2)
        self.editor = Editor(operator, lambda: self._fill(self._chosen))
        self.motors, self.calibration = MotorTab(operator), CalibrationTab(operator)
        middle = scrolled(self._list)
        parameters = row(spacing=6)
        parameters.pack_start(middle, True, True, 0)
        parameters.pack_start(self.editor, False, False, 0)
        self.editor.set_size_request(266, -1)
        self._stack = Gtk.Stack()
        self._stack.set_vhomogeneous(False)
        self._stack.set_hhomogeneous(False)
        for name, child in (
            ("parameters", parameters),
            (MOTORS, self.motors),
            (CALIBRATION, self.calibration),
        ):
            self._stack.add_named(child, name)
        self.pack_start(scrolled(names, 138), False, False, 0)
        self.pack_start(self._stack, True, True, 0)

    def choose(self, name: str) -> None:
        """Show a section, the motor test or the calibration."""
        self._chosen = name
        for other, made in self._sections.items():
            set_class(made, "chosen", other == name)
        if name in (MOTORS, CALIBRATION):
            self._stack.set_visible_child_name(name)
            return
        self._stack.set_visible_child_name("parameters")
        self._fill(name)

    def update(self, views: Views, world: World | None) -> None:
        if not self._chosen:
            self.choose(MOTORS)
        if self._chosen == MOTORS:
            self.motors.update(views)
        elif self._chosen == CALIBRATION:
            self.calibration.update(views, world)

    def _fill(self, name: str) -> None:
        for child in self._list.get_children():
            self._list.remove(child)
        for setting in next(s for s in self._operator.settings.sections() if s.name == name).settings:
            self._list.pack_start(self._row(setting), False, False, 0)
        self._list.show_all()

    def _row(self, setting: Setting) -> Any:
        made = button("", partial(self.editor.choose, setting), "row")
        value = f"{setting.value:g}" if isinstance(setting.value, float) else str(setting.value)
        mark = "" if setting.live else " ↻"
        inside = row()
        inside.pack_start(label(setting.name.replace("_", " ") + mark), True, True, 0)
        words = f"{'● ' if setting.changed else ''}{value} {setting.unit}"
        inside.pack_end(label(words), False, False, 0)
        made.remove(made.get_child())
        made.add(inside)
        return made

"""Changes one parameter with a thumb: its limits and help, and a key pad, or a key for each choice."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from target_nav.errors import ConfigError
from target_nav.gui.gtk import Gtk
from target_nav.gui.operator import Operator
from target_nav.gui.panels.widgets import button, column, label, row
from target_nav.gui.settings import CHOICE, SWITCH, TEXT, Setting

_KEYS = ("7", "8", "9", "⌫", "C", "4", "5", "6", ".", "-", "1", "2", "3", "0")
_COLUMNS = 5


class Editor(Gtk.Box):
    def __init__(self, operator: Operator, on_change: Callable[[], None]) -> None:
        super().__init__(orientation=Gtk.Orientation.VERTICAL, spacing=2)
        self._operator, self._on_change = operator, on_change
        self._setting: Setting | None = None
        self._fresh = True
        self._name = label("", wrap=True)
        self._help = label("Choose a parameter on the left.", "dim", wrap=True)
        self._entry = Gtk.Entry(xalign=1.0, width_chars=9)
        self._entry.connect("activate", lambda _: self.take())
        self._unit = label("", "dim")
        self._told = label("", "dim", wrap=True)
        self._field = row(self._entry, self._unit)
        self._pad = Gtk.Grid(row_homogeneous=True, column_homogeneous=True, row_spacing=2, column_spacing=2)
        edits = {"⌫": self._rub_out, "C": self._clear}
        for index, key in enumerate(_KEYS):
            made = button(key, edits.get(key) or partial(self._type, key), "key")
            self._pad.attach(made, index % _COLUMNS, index // _COLUMNS, 1, 1)
        self._set = button("Set", self.take)
        self._pad.attach(self._set, 4, 2, 1, 1)
        self._choices = column()
        self._default = button("Default", self._reset)
        self._field.pack_end(self._default, False, False, 0)
        for child in (self._name, self._help, self._field, self._told, self._pad, self._choices):
            self.pack_start(child, False, False, 0)
        for child in (self._field, self._pad):
            child.set_no_show_all(True)

    def choose(self, setting: Setting) -> None:
        self._setting = setting
        number = setting.kind not in (SWITCH, CHOICE, TEXT)
        limits = f"  {setting.low:g} … {setting.high:g} {setting.unit}" if number else ""
        self._name.set_text(setting.key)
        when = "at once" if setting.live else "from the next start"
        self._help.set_text(f"{setting.help}{limits}\ncounts {when}")
        self._entry.set_text(_text(setting.value))
        self._unit.set_text(setting.unit)
        self._told.set_text("")
        self._fresh = True
        for child in self._choices.get_children():
            self._choices.remove(child)
        options = ("true", "false") if setting.kind == SWITCH else setting.options
        for option in options:
            self._choices.pack_start(button(option, partial(self.take, option)), False, False, 0)
        self._choices.show_all()
        for part in (self._field, self._pad):
            part.set_no_show_all(False)
            part.show_all()
        self._pad.set_visible(number)
        self._field.set_visible(True)
        self._entry.set_visible(not options)
        self._unit.set_visible(not options)

    def take(self, words: str | None = None) -> None:
        """Check, save and send what stands in the field; say what came of it."""
        if self._setting is None:
            return
        key = self._setting.key
        try:
            value = self._operator.settings.parse(key, self._entry.get_text() if words is None else words)
            change = self._operator.change(key, value)
        except ConfigError as error:
            self._tell(str(error), wrong=True)
            return
        self._on_change()
        self.choose(self._operator.settings.setting(key))
        self._tell("saved and sent" if change.live else "saved: restart the stack", wrong=False)

    def _reset(self) -> None:
        if self._setting is not None:
            self.take(_text(self._setting.default))

    def _tell(self, words: str, wrong: bool) -> None:
        self._told.set_text(("✘ " if wrong else "✔ ") + words)
        context = self._told.get_style_context()
        (context.add_class if wrong else context.remove_class)("wrong")

    def _type(self, key: str) -> None:
        # the first key after a choice begins a new number, as a pocket calculator does
        before = "" if self._fresh else self._entry.get_text()
        self._fresh = False
        self._entry.set_text(before + key)

    def _rub_out(self) -> None:
        self._fresh = False
        self._entry.set_text(self._entry.get_text()[:-1])

    def _clear(self) -> None:
        self._fresh = False
        self._entry.set_text("")


def _text(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, float) else str(value)

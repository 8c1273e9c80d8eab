"""Where every key and field is on the screen, as JSON: so that a test can press what a person would see."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from target_nav.gui.gtk import Gtk
from target_nav.gui.panels.hold_field import HoldField


def write_places(window: Any, path: Path) -> None:
    """Label to [x, y, width, height] in pixels of the screen, of what is visible and can be pressed; in one step."""
    _, left, top = window.get_window().get_origin()
    places: dict[str, list[int]] = {}
    for widget, label in _pressable(window):
        x, y = widget.translate_coordinates(window, 0, 0)
        size = widget.get_allocation()
        places.setdefault(label, [left + x, top + y, size.width, size.height])
    fresh = path.with_suffix(".new")
    fresh.write_text(json.dumps(places), encoding="utf-8")
    os.replace(fresh, path)


def _pressable(widget: Any) -> Iterator[tuple[Any, str]]:
    if not widget.get_mapped():
        return
    if isinstance(widget, Gtk.Button):
        yield widget, _words(widget)
    elif isinstance(widget, HoldField):
        yield widget, widget.label
    elif isinstance(widget, Gtk.Entry):
        yield widget, "entry"
    elif isinstance(widget, Gtk.Container):
        for child in widget.get_children():
            yield from _pressable(child)


def _words(widget: Any) -> str:
    """The first text inside a key."""
    if isinstance(widget, Gtk.Label):
        return str(widget.get_text()).replace("\n", " ")
    if isinstance(widget, Gtk.Container):
        return next((words for child in widget.get_children() if (words := _words(child))), "")
    return ""

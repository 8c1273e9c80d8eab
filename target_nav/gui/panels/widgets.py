"""The few widgets that all pages are made of."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from target_nav.gui.gtk import Gtk, Pango


def button(label: str, on_click: Callable[[], object], *classes: str) -> Any:
    made = Gtk.Button(label=label)
    for name in classes:
        made.get_style_context().add_class(name)
    made.connect("clicked", lambda _: on_click())
    return made


def label(words: str = "", *classes: str, wrap: bool = False, x: float = 0.0) -> Any:
    made = Gtk.Label(label=words, xalign=x)
    if wrap:
        made.set_line_wrap(True)
        made.set_max_width_chars(30)
    else:
        made.set_ellipsize(Pango.EllipsizeMode.END)
    for name in classes:
        made.get_style_context().add_class(name)
    return made


def set_class(widget: Any, name: str, on: bool) -> None:
    context = widget.get_style_context()
    if on != context.has_class(name):
        (context.add_class if on else context.remove_class)(name)


def column(*children: Any, spacing: int = 4, even: bool = False) -> Any:
    return _box(Gtk.Orientation.VERTICAL, children, spacing, even)


def row(*children: Any, spacing: int = 4, even: bool = False) -> Any:
    return _box(Gtk.Orientation.HORIZONTAL, children, spacing, even)


def scrolled(child: Any, width: int = -1) -> Any:
    """Scrolls up and down only, with a bar that a thumb can hold."""
    window = Gtk.ScrolledWindow()
    window.set_policy(Gtk.PolicyType.NEVER, Gtk.PolicyType.AUTOMATIC)
    window.set_overlay_scrolling(False)
    window.set_size_request(width, -1)
    window.add(child)
    return window


def _box(orientation: Any, children: Iterable[Any], spacing: int, even: bool) -> Any:
    box = Gtk.Box(orientation=orientation, spacing=spacing, homogeneous=even)
    for child in children:
        box.pack_start(child, even, even, 0)
    return box

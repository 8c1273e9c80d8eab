"""GTK 3 in the versions this panel is written for. Only the panel's own modules import this: view models do without."""

# ruff: noqa: E402
from __future__ import annotations

import gi

gi.require_version("Gtk", "3.0")
gi.require_version("Gdk", "3.0")

import cairo
from gi.repository import Gdk, GLib, Gtk, Pango

__all__ = ["GLib", "Gdk", "Gtk", "Pango", "cairo"]

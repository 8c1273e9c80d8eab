"""A field that means something for as long as a thumb is on it, and nothing the moment it is lifted or slides off."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from target_nav.gui.gtk import Gdk, Gtk
from target_nav.gui.panels.pane import Context, text
from target_nav.gui.panels.style import BLUE, GREY, LINE, PANE, SKY, TEXT, YELLOW


class HoldField(Gtk.DrawingArea):
    """Calls `on_hold` when it is pressed and `on_release` when it is not any more; each press has its release."""

    def __init__(
        self, sign: str, label: str, on_hold: Callable[[], None], on_release: Callable[[], None]
    ) -> None:
        super().__init__()
        self._sign, self.label = sign, label
        self._on_hold, self._on_release = on_hold, on_release
        self._held = False
        self.lit = False
        """Shown as held, by whatever holds it: a key, for instance."""
        mask = Gdk.EventMask
        self.add_events(mask.BUTTON_PRESS_MASK | mask.BUTTON_RELEASE_MASK | mask.LEAVE_NOTIFY_MASK)
        self.connect("draw", self._draw)
        self.connect("button-press-event", self._press)
        self.set_can_focus(True)
        self.connect("key-press-event", self._key_press)
        self.connect("key-release-event", self._key_release)
        mouse = ("button-release-event", "leave-notify-event", "grab-broken-event")
        for signal in (*mouse, "unmap", "focus-out-event"):
            self.connect(signal, self._release)

    def _press(self, widget: Any, event: Any) -> bool:
        if not self._held and event.type == Gdk.EventType.BUTTON_PRESS:
            self._held = True
            self._on_hold()
            self.queue_draw()
        return True

    def _key_press(self, widget: Any, event: Any) -> bool:
        """Enter holds it, for whoever has no finger to spare."""
        if (
            event.keyval not in (Gdk.KEY_Return, Gdk.KEY_KP_Enter)
            or event.state & Gdk.ModifierType.CONTROL_MASK
        ):
            return False
        if not self._held:
            self._held = True
            self._on_hold()
            self.queue_draw()
        return True

    def _key_release(self, widget: Any, event: Any) -> bool:
        return self._release(widget) if event.keyval in (Gdk.KEY_Return, Gdk.KEY_KP_Enter) else False

    def _release(self, widget: Any, event: Any = None) -> bool:
        if self._held:
            self._held = False
            self._on_release()
            self.queue_draw()
        return False

    def _draw(self, widget: Any, cr: Context) -> bool:
        size = self.get_allocation()
        active = self._held or self.lit
        enabled = self.get_sensitive()
        cr.set_source_rgb(*(SKY if active else BLUE if enabled else PANE))
        cr.rectangle(3, 3, size.width - 6, size.height - 6)
        cr.fill_preserve()
        cr.set_source_rgb(*(YELLOW if self.has_focus() else TEXT if active else LINE))
        cr.set_line_width(3.0)
        cr.stroke()
        middle = size.width / 2.0
        ink = TEXT if enabled else GREY
        text(cr, middle, size.height / 2.0 + 8, self._sign, 34.0, ink, bold=True, align=0.5)
        text(cr, middle, size.height - 12, self.label, 13.0, ink, align=0.5, width=size.width - 8)
        return False

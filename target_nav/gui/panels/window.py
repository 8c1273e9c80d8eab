"""The whole panel: bar on top, page in the middle, GO and STOP always at the right, pages along the bottom.

Space and Escape are STOP wherever the focus is. Everything can be reached with Tab and Enter; Alt+1 ... Alt+8 are the
pages, Ctrl+Enter is GO, Ctrl+P pauses, Ctrl+T is one step of the tree.
"""

from __future__ import annotations

import time
from functools import partial
from typing import Any

from target_nav.gui.gtk import Gdk, Gtk
from target_nav.gui.manual import KEYS
from target_nav.gui.missions import missions, targets
from target_nav.gui.model import Views
from target_nav.gui.operator import Operator
from target_nav.gui.panels.arrival_pane import ArrivalPane
from target_nav.gui.panels.camera_pane import CameraPane
from target_nav.gui.panels.drive_page import DrivePage
from target_nav.gui.panels.log_pane import LogPane
from target_nav.gui.panels.map_pane import MapPane
from target_nav.gui.panels.missions_page import MissionsPage
from target_nav.gui.panels.pane import Pane
from target_nav.gui.panels.radar_pane import RadarPane
from target_nav.gui.panels.status_bar import StatusBar, Strip
from target_nav.gui.panels.style import BAR_HEIGHT, CSS, HEIGHT, NAV_HEIGHT, SIDE_WIDTH, STRIP_HEIGHT, WIDTH
from target_nav.gui.panels.tree_pane import TreePane
from target_nav.gui.panels.widgets import button, column, row, set_class
from target_nav.gui.settings_tabs.page import SettingsPage
from target_nav.gui.source import World
from target_nav.state.types import CommandKind

STOP_KEYS = frozenset({"space", "Escape"})
PAGES = ("home", "camera", "map", "tree", "drive", "log", "mission", "settings")


class PanelWindow(Gtk.Window):
    """Shows what `show_views` is given, and hands what is pressed to the operator."""

    def __init__(self, operator: Operator, full_screen: bool) -> None:
        super().__init__(title="target_nav panel")
        self._operator = operator
        self._paused = False
        self.set_default_size(WIDTH, HEIGHT)
        _load_style(self.get_screen())
        choices = missions()
        self.bar, self.strip = StatusBar(-1, BAR_HEIGHT), Strip(-1, STRIP_HEIGHT)
        self._panes: list[Pane] = [self.bar, self.strip]
        self.drive = DrivePage(operator)
        self.mission = MissionsPage(operator, choices, targets(choices))
        self.settings = SettingsPage(operator)
        self._tree_page, self._log_page = TreePane(), LogPane()
        self.pages = {
            "home": self._home(),
            "camera": self._kept(CameraPane()),
            "map": self._with_arrival(self._kept(MapPane())),
            "tree": _with_scroll(self._kept(self._tree_page), -1),
            "drive": self.drive,
            "log": _with_scroll(self._kept(self._log_page), 1),
            "mission": self.mission,
            "settings": self.settings,
        }
        self._panes.append(self.drive.radar)
        self._stack = Gtk.Stack()
        self._stack.set_hhomogeneous(False)
        self._stack.set_vhomogeneous(False)
        for name, page in self.pages.items():
            self._stack.add_named(page, name)
        self._page_keys = {name: button(name, partial(self.choose, name), "page") for name in PAGES}
        keys = row(*self._page_keys.values(), spacing=2, even=True)
        keys.set_size_request(-1, NAV_HEIGHT)
        middle = column(spacing=2)
        middle.pack_start(self._stack, True, True, 0)
        middle.pack_start(keys, False, False, 0)
        body = row(spacing=2)
        body.pack_start(middle, True, True, 0)
        body.pack_start(self._side(), False, False, 0)
        whole = column(self.bar, self.strip, spacing=0)
        whole.pack_start(body, True, True, 0)
        self.add(whole)
        self.connect("key-press-event", self._key_press)
        self.connect("key-release-event", self._key_release)
        self.connect("focus-out-event", self._let_go)
        self.connect("delete-event", lambda *_: Gtk.main_quit())
        whole.show_all()
        self.choose("home")
        if full_screen:
            self.fullscreen()

    def choose(self, page: str) -> None:
        self._stack.set_visible_child_name(page)
        self._operator.pad.release_all()
        for name, key in self._page_keys.items():
            set_class(key, "chosen", name == page)

    def show_views(self, views: Views, world: World | None, problem: str) -> None:
        """Draw what can be seen; panes on other pages cost nothing."""
        self.strip.panel_problem = problem
        self._paused = views.status.paused
        self._pause.set_label("RESUME" if self._paused else "PAUSE")
        self._step.set_sensitive(self._paused)
        page = self._stack.get_visible_child_name()
        if page == "drive":
            self.drive.update(views)
        elif page == "mission":
            self.mission.update(views)
        elif page == "settings":
            self.settings.update(views, world)
        for pane in self._panes:
            if pane.get_mapped():
                pane.show_views(views)

    def beat(self) -> bool:
        """Called every 20 ms: what is held is said again, what was said is looked after."""
        now_s = time.monotonic()
        said = self._operator.beat(now_s)
        if said is not self.strip.said or (said is not None and said.acknowledged_s is None):
            self.strip.said, self.strip.now_s = said, now_s
            self.strip.queue_draw()
        self.strip.now_s = now_s
        return True

    # -- parts ---------------------------------------------------------------------------------------------------------

    def _kept(self, pane: Any) -> Any:
        self._panes.append(pane)
        return pane

    def _home(self) -> Any:
        left = column(spacing=2)
        left.pack_start(self._kept(CameraPane(318, 212)), False, False, 0)
        left.pack_start(self._kept(TreePane(318, -1, compact=True)), True, True, 0)
        home = row(spacing=2)
        home.pack_start(left, False, False, 0)
        home.pack_start(self._kept(RadarPane()), True, True, 0)
        return home

    def _with_arrival(self, pane: Any) -> Any:
        box = row(spacing=2)
        box.pack_start(pane, True, True, 0)
        box.pack_start(self._kept(ArrivalPane(210, -1)), False, False, 0)
        return box

    def _side(self) -> Any:
        operator = self._operator
        go = button("▶ GO", operator.go, "go")
        stop = button("■\nSTOP", operator.stop, "stop")
        stop.get_child().set_justify(Gtk.Justification.CENTER)
        go.set_size_request(SIDE_WIDTH, 84)
        stop.set_size_request(SIDE_WIDTH, 140)
        self._pause = button("PAUSE", self._pause_or_resume)
        self._step = button("STEP", partial(operator.say, CommandKind.STEP))
        side = column(spacing=4)
        side.get_style_context().add_class("side")
        side.pack_start(go, False, False, 0)
        side.pack_start(stop, True, True, 0)
        side.pack_start(row(self._pause, self._step, spacing=2, even=True), False, False, 0)
        return side

    def _pause_or_resume(self) -> None:
        self._operator.say(CommandKind.RESUME if self._paused else CommandKind.PAUSE)

    # -- keys ----------------------------------------------------------------------------------------------------------

    def _key_press(self, widget: Any, event: Any) -> bool:
        name = Gdk.keyval_name(event.keyval) or ""
        if name in STOP_KEYS:
            self._operator.stop()
            return True
        control = bool(event.state & Gdk.ModifierType.CONTROL_MASK)
        if event.state & Gdk.ModifierType.MOD1_MASK and name.isdigit() and 0 < int(name) <= len(PAGES):
            self.choose(PAGES[int(name) - 1])
            return True
        if control:
            return self._control(name)
        direction = self._direction(name)
        if direction:
            if not self._operator.say_first_stop(self.strip.views):
                self._operator.pad.hold(direction, f"key {name}")
            return True
        return False

    def _control(self, name: str) -> bool:
        if name in ("Return", "KP_Enter"):
            self._operator.go()
        elif name == "p":
            self._pause_or_resume()
        elif name == "t":
            self._operator.say(CommandKind.STEP)
        elif name == "q":
            Gtk.main_quit()
        else:
            return False
        return True

    def _key_release(self, widget: Any, event: Any) -> bool:
        name = Gdk.keyval_name(event.keyval) or ""
        direction = KEYS.get(name) or KEYS.get(name.lower())
        if direction:
            self._operator.pad.release(direction, f"key {name}")
        return False

    def _direction(self, name: str) -> str:
        """What a key drives, on the page for that; anywhere else arrows move the focus."""
        if self._stack.get_visible_child_name() != "drive":
            return ""
        return KEYS.get(name) or KEYS.get(name.lower(), "")

    def _let_go(self, widget: Any, event: Any) -> bool:
        """The keyboard belongs to another window now, and a key's release would never be heard of."""
        self._operator.pad.release_all()
        self._operator.release_motor()
        return False


def _with_scroll(pane: Any, sign: int) -> Any:
    """A pane with two keys that move its `lift`: a thumb hits them better than a scroll bar."""

    def lift(rows: int) -> None:
        pane.lift = pane.lift + rows if rows else 0
        if sign > 0:
            pane.lift = max(pane.lift, 0)
        pane.queue_draw()

    up = button("▲", lambda: lift(6 * sign), "key")
    down = button("▼", lambda: lift(-6 * sign), "key")
    follow = button("●", lambda: lift(0), "key")
    box = row(spacing=2)
    box.pack_start(pane, True, True, 0)
    box.pack_start(column(up, follow, down, spacing=2, even=True), False, False, 0)
    return box


def _load_style(screen: Any) -> None:
    provider = Gtk.CssProvider()
    provider.load_from_data(CSS)
    Gtk.StyleContext.add_provider_for_screen(screen, provider, Gtk.STYLE_PROVIDER_PRIORITY_APPLICATION)

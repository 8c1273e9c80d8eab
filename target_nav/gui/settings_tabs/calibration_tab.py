"""Camera and distance calibration: put a pin straight ahead at a known distance, press, look, save."""

from __future__ import annotations

from functools import partial

from target_nav.errors import ConfigError
from target_nav.gui.calibration import MOST_SAMPLES, CalibrationResult, PinCalibration
from target_nav.gui.gtk import Gtk
from target_nav.gui.model import Views
from target_nav.gui.operator import Operator
from target_nav.gui.panels.camera_pane import CameraPane
from target_nav.gui.panels.widgets import button, column, label, row
from target_nav.gui.source import World
from target_nav.state.types import TargetSpec


class CalibrationTab(Gtk.Box):
    def __init__(self, operator: Operator) -> None:
        super().__init__(orientation=Gtk.Orientation.HORIZONTAL, spacing=8)
        self._operator = operator
        self._gap_m, self._width_m = 1.0, TargetSpec().width_m
        self._running: PinCalibration | None = None
        self._result: CalibrationResult | None = None
        self._shown = label("", "big", x=0.5)
        self._told = label(
            "Put the target straight ahead. The distance is from the robot's front edge to its surface.",
            "dim",
            wrap=True,
        )
        nearer = button("−", partial(self._change, -0.05), "key")
        farther = button("+", partial(self._change, 0.05), "key")
        self._measure = button("Measure", self._begin)
        self._save = button("Save", self._keep)
        self._save.set_sensitive(False)
        self.camera = CameraPane(250, 190)
        keys = row(self._measure, self._save, even=True)
        side = column(self._shown, row(nearer, farther, even=True), keys, self._told, spacing=6)
        self.pack_start(self.camera, True, True, 0)
        self.pack_start(side, False, False, 0)
        self._change(0.0)

    def update(self, views: Views, world: World | None) -> None:
        self.camera.show_views(views)
        if world is not None and world.nav.value is not None:
            self._width_m = world.nav.value.spec.width_m
        running = self._running
        if running is None or world is None:
            return
        running.see(world)
        if not running.done:
            self._told.set_text(f"{running.count} of {MOST_SAMPLES} boxes …")
            return
        self._running, self._result = None, running.result()
        if self._result is not None:
            wrong = f"✘ {self._result.problem}. " if self._result.problem else ""
            self._told.set_text(wrong + self._result.text)
            self._save.set_sensitive(not self._result.problem)

    def _begin(self) -> None:
        self._result = None
        self._save.set_sensitive(False)
        self._running = PinCalibration(self._operator.settings.config, self._gap_m, self._width_m)

    def _keep(self) -> None:
        result = self._result
        if result is None:
            return
        try:
            self._operator.change("camera.focal_px", round(result.focal_px, 2))
            self._operator.change("camera.yaw_rad", round(result.yaw_rad, 5))
        except ConfigError as error:
            self._told.set_text(f"✘ {error}")
            return
        self._told.set_text("✔ saved: it counts from the next start")
        self._save.set_sensitive(False)

    def _change(self, step_m: float) -> None:
        self._gap_m = min(max(self._gap_m + step_m, 0.3), 4.0)
        self._shown.set_text(f"{self._gap_m:.2f} m")

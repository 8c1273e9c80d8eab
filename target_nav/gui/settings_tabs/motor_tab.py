"""Motor test: each motor turns while its field is held; CALIB counts the wheels from here. Put the robot on blocks."""

from __future__ import annotations

from functools import partial

from target_nav.gui.gtk import Gtk
from target_nav.gui.model import Views
from target_nav.gui.operator import Operator
from target_nav.gui.panels.hold_field import HoldField
from target_nav.gui.panels.widgets import button, column, label, row
from target_nav.state.types import CommandKind

MOTORS = (("FL", "front left"), ("FR", "front right"), ("RL", "rear left"), ("RR", "rear right"))
_STEP, _MOST = 20, 240


class MotorTab(Gtk.Box):
    def __init__(self, operator: Operator) -> None:
        super().__init__(orientation=Gtk.Orientation.HORIZONTAL, spacing=8)
        self._operator = operator
        self._pwm = 80
        grid = Gtk.Grid(row_homogeneous=True, column_homogeneous=True)
        self._fields = []
        for index, (motor, words) in enumerate(MOTORS):
            field = HoldField(motor, words, partial(self._hold, motor), operator.release_motor)
            field.set_size_request(118, 118)
            self._fields.append(field)
            grid.attach(field, index % 2, index // 2, 1, 1)
        self._shown = label("", x=0.5)
        self._why = label("", "dim", wrap=True)
        slower = button("−", partial(self._change, -_STEP), "key")
        faster = button("+", partial(self._change, _STEP), "key")
        back = button("backwards", self._turn_round)
        calib = button("CALIB: zero here", partial(operator.say, CommandKind.FIRMWARE, "CALIB"))
        side = column(self._shown, row(slower, faster, even=True), back, calib, self._why, spacing=6)
        self.pack_start(grid, False, False, 0)
        self.pack_start(side, True, True, 0)
        self._calib = calib
        self._change(0)

    def update(self, views: Views) -> None:
        status = views.status
        free = status.fresh and not status.requested
        for field in (*self._fields, self._calib):
            field.set_sensitive(free)
        words = "Wheels off the floor! A motor turns while its field is held."
        self._why.set_text(
            words if free else "STOP first: a mission runs." if status.fresh else "No nav process."
        )

    def _hold(self, motor: str) -> None:
        self._operator.hold_motor(motor, self._pwm)

    def _change(self, step: int) -> None:
        sign = -1 if self._pwm < 0 else 1
        self._pwm = sign * min(max(abs(self._pwm) + step, _STEP), _MOST)
        self._shown.set_text(f"PWM {self._pwm:+d} of 255")

    def _turn_round(self) -> None:
        self._pwm = -self._pwm
        self._change(0)

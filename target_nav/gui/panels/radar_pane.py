"""The world round the robot, front up: scan, obstacles, the room VFH finds, its choice, the target with its ellipse."""

from __future__ import annotations

import math

from target_nav.gui.model import Views
from target_nav.gui.panels.pane import Context, Pane, caption, grid_line, text, veil
from target_nav.gui.panels.style import BACKGROUND, GREY, LINE, ORANGE, SKY, TEXT, YELLOW
from target_nav.gui.source import age_text
from target_nav.gui.view_radar import RadarView
from target_nav.state.types import FloatArray

REACH_M = 3.0
_MOST_REACH_M = 7.0


class RadarPane(Pane):
    """`reach_m` from the robot to the upper edge; the robot stands below the middle, for it drives ahead."""

    def __init__(self, width: int = -1, height: int = -1, reach_m: float = REACH_M) -> None:
        super().__init__(width, height)
        self._reach_m = reach_m

    def paint(self, cr: Context, views: Views, width: float, height: float) -> None:
        view = views.radar
        target = view.target
        # a target farther off is brought into the picture
        seen_m = self._reach_m if target is None else max(self._reach_m, 1.15 * target.range_m)
        reach_m = min(seen_m, _MOST_REACH_M)
        scale = 0.62 * height / reach_m
        cr.save()
        cr.rectangle(0, 0, width, height)
        cr.clip()
        # x ahead is up, y left is left
        cr.translate(width / 2.0, 0.64 * height)
        _rings(cr, scale, reach_m)
        if view.avoid_fresh and view.direction_rad is not None:
            _room(cr, view, scale)
        _points(cr, view.points_m, scale, 2.4, SKY)
        if view.avoid_fresh:
            _points(cr, view.obstacles_m, scale, 3.6, ORANGE)
        _body(cr, view, scale)
        if view.avoid_fresh and view.direction_rad is not None:
            _choice(cr, view, scale)
        _target(cr, view, scale)
        _motion(cr, view, scale)
        cr.restore()
        words = "no target"
        if target is not None:
            sure = "" if target.confirmed else " ?"
            words = (
                f"{target.range_m:.2f} m {math.degrees(target.bearing_rad):+.0f}° ±{target.sigma_m:.2f}{sure}"
            )
        cr.set_source_rgba(*BACKGROUND, 0.75)
        cr.rectangle(2, 2, width - 4, 28)
        cr.fill()
        caption(cr, "RADAR")
        text(cr, width - 8, 22, words, 20.0, YELLOW if target is not None else GREY, bold=True, align=1.0)
        if not view.fresh:
            age = age_text(view.points_age_s) if len(view.points_m) else ""
            veil(cr, width, height, view.message, age)


def _rings(cr: Context, scale: float, reach_m: float) -> None:
    cr.set_source_rgb(*LINE)
    cr.set_line_width(1.0)
    whole = range(1, int(reach_m) + 1)
    for ring_m in whole:
        cr.arc(0, 0, ring_m * scale, 0, math.tau)
        cr.stroke()
        text(cr, 4, -ring_m * scale + 13, f"{ring_m} m", 12.0, GREY)
        cr.set_source_rgb(*LINE)
    grid_line(cr, 0, -whole[-1] * scale, 0, 0)


def _points(
    cr: Context, points_m: FloatArray, scale: float, size: float, colour: tuple[float, float, float]
) -> None:
    cr.set_source_rgb(*colour)
    half = size / 2.0
    for x, y in (points_m * -scale).tolist():
        cr.rectangle(y - half, x - half, size, size)
    cr.fill()


def _room(cr: Context, view: RadarView, scale: float) -> None:
    for x, y in (view.room_m * -scale).tolist():
        cr.line_to(y, x)
    cr.close_path()
    cr.set_source_rgba(*SKY, 0.16)
    cr.fill()


def _body(cr: Context, view: RadarView, scale: float) -> None:
    body = view.body
    cr.set_source_rgb(*TEXT)
    cr.set_line_width(2.0)
    cr.rectangle(
        -body.half_width_m * scale,
        -body.front_m * scale,
        2.0 * body.half_width_m * scale,
        (body.front_m + body.rear_m) * scale,
    )
    cr.stroke()
    cr.move_to(0, -body.front_m * scale - 5)
    cr.line_to(-5, -body.front_m * scale + 5)
    cr.line_to(5, -body.front_m * scale + 5)
    cr.close_path()
    cr.fill()


def _choice(cr: Context, view: RadarView, scale: float) -> None:
    assert view.direction_rad is not None, "the caller has looked"
    length = max(view.free_ahead_m, 0.45) * scale
    cr.save()
    cr.rotate(-view.direction_rad)
    cr.set_source_rgb(*SKY)
    cr.set_line_width(4.0)
    cr.move_to(0, 0)
    cr.line_to(0, -length)
    cr.stroke()
    cr.move_to(0, -length - 10)
    cr.line_to(-8, -length + 5)
    cr.line_to(8, -length + 5)
    cr.close_path()
    cr.fill()
    cr.restore()


def _target(cr: Context, view: RadarView, scale: float) -> None:
    target = view.target
    if target is None:
        return
    e = target.ellipse
    cr.save()
    cr.translate(-e.y_m * scale, -e.x_m * scale)
    cr.rotate(-e.angle_rad)
    cr.save()
    # the longer half-axis lies along x, which is up
    cr.scale(max(e.minor_m * scale, 4.0), max(e.major_m * scale, 4.0))
    cr.arc(0, 0, 1.0, 0, math.tau)
    cr.restore()
    cr.set_source_rgba(*YELLOW, 0.25)
    cr.fill_preserve()
    cr.set_source_rgb(*YELLOW)
    cr.set_line_width(2.5)
    cr.set_dash([] if target.confirmed else [5, 4])
    cr.stroke()
    cr.set_dash([])
    cr.restore()
    cr.set_source_rgb(*YELLOW)
    for dx, dy in ((7, 0), (0, 7)):
        cr.move_to(-e.y_m * scale - dx, -e.x_m * scale - dy)
        cr.line_to(-e.y_m * scale + dx, -e.x_m * scale + dy)
    cr.stroke()


def _motion(cr: Context, view: RadarView, scale: float) -> None:
    """The velocity that is sent, as where the robot would be in one second."""
    twist = view.twist
    if twist.speed_mps < 0.005:
        return
    cr.set_source_rgb(*TEXT)
    cr.set_line_width(3.0)
    cr.move_to(0, 0)
    cr.line_to(-twist.vy_mps * scale, -twist.vx_mps * scale)
    cr.stroke()

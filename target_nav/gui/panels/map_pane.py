"""The odometry frame from above: path, robot, target, obstacles of the moment, a grid of whole metres."""

from __future__ import annotations

import math

from target_nav.gui.model import Views
from target_nav.gui.panels.pane import Context, Pane, caption, text, veil
from target_nav.gui.panels.style import GREY, LINE, ORANGE, SKY, TEXT, YELLOW
from target_nav.gui.view_map import MapView

_MOST_GRID_LINES = 14


class MapPane(Pane):
    def paint(self, cr: Context, views: Views, width: float, height: float) -> None:
        view = views.map
        scale = min(width / (view.x_max_m - view.x_min_m), height / (view.y_max_m - view.y_min_m))
        x_mid, y_mid = 0.5 * (view.x_min_m + view.x_max_m), 0.5 * (view.y_min_m + view.y_max_m)

        def place(x_m: float, y_m: float) -> tuple[float, float]:
            return width / 2.0 + (x_m - x_mid) * scale, height / 2.0 - (y_m - y_mid) * scale

        _grid(cr, width, height, scale, x_mid, y_mid)
        cr.set_source_rgb(*ORANGE)
        for x_m, y_m in view.obstacles_m.tolist():
            x, y = place(x_m, y_m)
            cr.rectangle(x - 1.5, y - 1.5, 3, 3)
        cr.fill()
        cr.set_source_rgb(*SKY)
        cr.set_line_width(3.0)
        for x_m, y_m in view.path_m.tolist():
            cr.line_to(*place(x_m, y_m))
        cr.stroke()
        if view.target is not None:
            x, y = place(view.target.x_m, view.target.y_m)
            cr.save()
            cr.translate(x, y)
            cr.rotate(-view.target.angle_rad)
            cr.scale(max(view.target.major_m * scale, 5.0), max(view.target.minor_m * scale, 5.0))
            cr.arc(0, 0, 1.0, 0, math.tau)
            cr.restore()
            cr.set_source_rgba(*YELLOW, 0.3)
            cr.fill_preserve()
            cr.set_source_rgb(*YELLOW)
            cr.set_line_width(2.5)
            cr.stroke()
        _robot(cr, view, place, scale)
        caption(cr, f"MAP  odom  driven {view.driven_m:.1f} m")
        pose = view.pose
        where = f"x {pose.x_m:+.2f}  y {pose.y_m:+.2f} m  {math.degrees(pose.yaw_rad):+.0f}°"
        text(cr, width - 8, 18, where, 15.0, TEXT, bold=True, align=1.0)
        if not view.fresh:
            veil(cr, width, height, view.message)


def _grid(cr: Context, width: float, height: float, scale: float, x_mid: float, y_mid: float) -> None:
    step = 1.0
    while width / (step * scale) > _MOST_GRID_LINES:
        step *= 2.0
    cr.set_source_rgb(*LINE)
    cr.set_line_width(1.0)
    first = math.ceil((x_mid - width / 2.0 / scale) / step)
    for i in range(first, first + int(width / scale / step) + 1):
        x = width / 2.0 + (i * step - x_mid) * scale
        cr.move_to(x, 0)
        cr.line_to(x, height)
    first = math.ceil((y_mid - height / 2.0 / scale) / step)
    for i in range(first, first + int(height / scale / step) + 1):
        y = height / 2.0 - (i * step - y_mid) * scale
        cr.move_to(0, y)
        cr.line_to(width, y)
    cr.stroke()
    text(cr, width - 8, height - 8, f"grid {step:g} m", 13.0, GREY, align=1.0)


def _robot(cr: Context, view: MapView, place: object, scale: float) -> None:
    x, y = place(view.pose.x_m, view.pose.y_m)  # type: ignore[operator]
    size = max(0.15 * scale, 10.0)
    cr.save()
    cr.translate(x, y)
    cr.rotate(-view.pose.yaw_rad)
    cr.move_to(1.3 * size, 0)
    cr.line_to(-size, 0.8 * size)
    cr.line_to(-0.6 * size, 0)
    cr.line_to(-size, -0.8 * size)
    cr.close_path()
    cr.set_source_rgb(*TEXT)
    cr.fill()
    cr.restore()

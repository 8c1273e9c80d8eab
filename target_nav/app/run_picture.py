"""The picture of a run: the arena from above, the path that was driven coloured by state, where it ended."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Polygon, Rectangle

from target_nav.config import RobotConfig
from target_nav.sim.arena import Arena, BoxObstacle, CircleObstacle, WallObstacle
from target_nav.state.types import NavState

# Okabe and Ito's palette: told apart by colour-blind eyes too
STATE_COLOURS = {
    NavState.IDLE: "#999999",
    NavState.NAVIGATING: "#0072B2",
    NavState.SEARCHING: "#E69F00",
    NavState.SPIRAL_SEARCH: "#CC79A7",
    NavState.BLIND_APPROACH: "#D55E00",
    NavState.ARRIVED: "#009E73",
}
OBSTACLE = "#5b5f66"

Row = Sequence[float]


def draw_run(
    path: Path,
    arena: Arena,
    trace: Sequence[Row],
    states: Sequence[tuple[float, NavState]],
    title: str,
) -> None:
    """Write a PNG.

    Args:
        trace: (t_s, x_m, y_m, yaw_rad) of the true pose, oldest first.
        states: (t_s, state) from when on the robot was in that state.
    """
    x0, y0, x1, y1 = arena.bounds
    width = 7.0
    figure = Figure(figsize=(width, width * (y1 - y0) / (x1 - x0) + 0.9), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    _draw_arena(axes, arena)
    if len(trace):
        _draw_path(axes, np.asarray(trace, dtype=float), states)
        _draw_robot(axes, arena.config.robot, trace[0], "none")
        _draw_robot(axes, arena.config.robot, trace[-1], "#ffffff")
    axes.set(
        xlim=(x0 - 0.1, x1 + 0.1), ylim=(y0 - 0.1, y1 + 0.1), aspect="equal", xlabel="x [m]", ylabel="y [m]"
    )
    axes.set_title(textwrap.fill(title, 76), fontsize=9)
    axes.grid(alpha=0.25, linewidth=0.5)
    used = {state for _, state in states}
    handles = [Line2D([], [], color=STATE_COLOURS[s], lw=3, label=s.name) for s in NavState if s in used]
    figure.legend(
        handles=handles, loc="outside lower center", ncols=len(handles) or 1, fontsize=8, frameon=False
    )
    figure.savefig(path)


def _draw_arena(axes: Axes, arena: Arena) -> None:
    x0, y0, x1, y1 = arena.bounds
    axes.add_patch(Rectangle((x0, y0), x1 - x0, y1 - y0, fill=False, edgecolor=OBSTACLE, linewidth=3))
    for obstacle in arena.obstacles:
        match obstacle:
            case WallObstacle(x1, y1, x2, y2):
                axes.plot([x1, x2], [y1, y2], color=OBSTACLE, linewidth=3, solid_capstyle="butt")
            case CircleObstacle(x, y, radius):
                axes.add_patch(Circle((x, y), radius, facecolor=OBSTACLE, alpha=0.85))
            case BoxObstacle(x, y, length, width, yaw):
                corner = (x - length / 2, y - width / 2)
                axes.add_patch(
                    Rectangle(
                        corner, length, width, angle=math.degrees(yaw), rotation_point="center",
                        facecolor=OBSTACLE, alpha=0.85,
                    )
                )  # fmt: skip
    for thing in arena.decoys:
        axes.add_patch(Circle((thing.x_m, thing.y_m), thing.shape.radius_m, facecolor="#4d8c57"))
        axes.annotate(
            thing.class_name, (thing.x_m, thing.y_m), (5, 5), textcoords="offset points", fontsize=7
        )
    if arena.target is not None:
        where = (arena.target.x_m, arena.target.y_m)
        axes.add_patch(Circle(where, max(arena.target.shape.radius_m, 0.03), facecolor="#c1121f", zorder=5))
        axes.annotate(arena.target.class_name, where, (6, 6), textcoords="offset points", fontsize=8)
    if arena.goal is not None:
        axes.add_patch(
            Circle((arena.goal.x_m, arena.goal.y_m), arena.goal.radius_m, fill=False, edgecolor="#c1121f")
        )


def _draw_path(axes: Axes, trace: np.ndarray, states: Sequence[tuple[float, NavState]]) -> None:
    starts = [t for t, _ in states]
    for n, (begin_s, state) in enumerate(states):
        end_s = starts[n + 1] if n + 1 < len(starts) else math.inf
        # one sample more, so that the pieces touch
        first = int(np.searchsorted(trace[:, 0], begin_s))
        last = int(np.searchsorted(trace[:, 0], end_s)) + 1
        axes.plot(
            trace[first:last, 1], trace[first:last, 2], color=STATE_COLOURS[state], linewidth=2, zorder=4
        )


def _draw_robot(axes: Axes, robot: RobotConfig, row: Row, face: str) -> None:
    _, x, y, yaw = row
    c, s = math.cos(yaw), math.sin(yaw)
    corners = [
        (robot.front_m, robot.half_width_m),
        (robot.front_m, -robot.half_width_m),
        (-robot.rear_m, -robot.half_width_m),
        (-robot.rear_m, robot.half_width_m),
    ]
    axes.add_patch(
        Polygon(
            [(x + c * u - s * v, y + s * u + c * v) for u, v in corners],
            facecolor=face,
            edgecolor="#222222",
            linewidth=1.2,
            zorder=6,
        )
    )
    nose = (x + c * robot.front_m, y + s * robot.front_m)
    axes.plot([x, nose[0]], [y, nose[1]], color="#222222", linewidth=1.2, zorder=7)

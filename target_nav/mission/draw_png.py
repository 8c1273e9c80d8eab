"""A scene as PNG, painted by matplotlib (the extra `sim`), which brings its own font."""

from __future__ import annotations

import io

from target_nav.errors import MissionError
from target_nav.mission.draw_scene import Curve, Rectangle, Scene

SCALE = 2.0
"""Pixels of the picture to one of the scene: sharp on today's screens."""
MAX_PIXELS = 100_000_000


def png_of(scene: Scene) -> bytes:
    """The picture's bytes.

    Raises:
        MissionError: matplotlib is not installed, or the picture would be too large.
    """
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
        from matplotlib.patches import FancyBboxPatch, PathPatch
        from matplotlib.path import Path as Outline
    except ImportError:
        raise MissionError(
            "a PNG needs matplotlib (pip install 'target_nav[sim]'); .svg and .txt do not"
        ) from None
    scale = SCALE
    while scale > 1.0 and scene.width * scene.height * scale**2 > MAX_PIXELS:
        scale /= 2.0
    if scene.width * scene.height * scale**2 > MAX_PIXELS or max(scene.width, scene.height) * scale >= 2**16:
        raise MissionError(
            f"a PNG of {scene.width:.0f} x {scene.height:.0f} pixels is too large; draw an .svg, or a smaller tree"
        )
    # at 72 dots an inch a point is a pixel
    figure = Figure(figsize=(scene.width / 72.0, scene.height / 72.0), dpi=72.0 * scale, facecolor="#ffffff")
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(0.0, scene.width), ylim=(scene.height, 0.0))
    axes.axis("off")
    for order, shape in enumerate(scene.shapes):
        if isinstance(shape, Rectangle):
            style = shape.style
            axes.add_patch(
                FancyBboxPatch(
                    (shape.x, shape.y), shape.width, shape.height,
                    boxstyle=f"round,pad=0,rounding_size={shape.radius}", facecolor=style.fill, edgecolor=style.stroke,
                    linewidth=style.width, linestyle=(0, (4, 2)) if style.dashed else "solid", zorder=order,
                )
            )  # fmt: skip
        elif isinstance(shape, Curve):
            points = [
                (shape.x0, shape.y0),
                (shape.bend_x, shape.y0),
                (shape.bend_x, shape.y1),
                (shape.x1, shape.y1),
            ]
            codes = [Outline.MOVETO, Outline.CURVE4, Outline.CURVE4, Outline.CURVE4]
            curve = Outline(points, codes)
            axes.add_patch(
                PathPatch(
                    curve, facecolor="none", edgecolor=shape.colour, linewidth=shape.width, zorder=order
                )
            )
        else:
            axes.text(
                shape.x, shape.y, shape.text, fontsize=shape.size_px, color=shape.colour, parse_math=False,
                fontweight="bold" if shape.bold else "normal", fontfamily="DejaVu Sans", va="baseline", zorder=order,
            )  # fmt: skip
    stream = io.BytesIO()
    figure.savefig(stream, format="png", facecolor="#ffffff")
    return stream.getvalue()

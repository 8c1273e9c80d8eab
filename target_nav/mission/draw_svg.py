"""A scene as SVG: text stays text, so it can be searched and copied."""

from __future__ import annotations

from xml.sax.saxutils import escape

from target_nav.mission.draw_scene import Curve, Rectangle, Scene

FONT = "DejaVu Sans, Verdana, Segoe UI, Helvetica, Arial, sans-serif"


def svg_of(scene: Scene) -> str:
    """The picture's text."""
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{scene.width:.0f}" height="{scene.height:.0f}" '
        f'viewBox="0 0 {scene.width:.0f} {scene.height:.0f}" font-family="{FONT}">',
        f"<title>{_text(scene.title)}</title>",
        '<rect width="100%" height="100%" fill="#ffffff"/>',
    ]
    for shape in scene.shapes:
        if isinstance(shape, Rectangle):
            dash = ' stroke-dasharray="5 3"' if shape.style.dashed else ""
            lines.append(
                f'<rect x="{shape.x:.1f}" y="{shape.y:.1f}" width="{shape.width:.1f}" height="{shape.height:.1f}" '
                f'rx="{shape.radius:.1f}" fill="{shape.style.fill}" stroke="{shape.style.stroke}" '
                f'stroke-width="{shape.style.width:g}"{dash}/>'
            )
        elif isinstance(shape, Curve):
            lines.append(
                f'<path d="M{shape.x0:.1f} {shape.y0:.1f} C{shape.bend_x:.1f} {shape.y0:.1f} {shape.bend_x:.1f} '
                f'{shape.y1:.1f} {shape.x1:.1f} {shape.y1:.1f}" fill="none" stroke="{shape.colour}" '
                f'stroke-width="{shape.width:g}"/>'
            )
        else:
            weight = ' font-weight="bold"' if shape.bold else ""
            lines.append(
                f'<text x="{shape.x:.1f}" y="{shape.y:.1f}" font-size="{shape.size_px:g}"{weight} '
                f'fill="{shape.colour}" xml:space="preserve">{_text(shape.text)}</text>'
            )
    lines.append("</svg>")
    return "\n".join(lines) + "\n"


def _text(text: str) -> str:
    """Escaped, and without what XML cannot hold."""
    return escape("".join(c if c.isprintable() else " " for c in text))

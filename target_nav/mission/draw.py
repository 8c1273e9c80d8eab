"""A mission as a picture: SVG, PNG or a tree of text; as it is written, or as it stood in a recorded tick."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from target_nav.errors import MissionError
from target_nav.mission.check import analyse
from target_nav.mission.draw_layout import place
from target_nav.mission.draw_nodes import DrawNode, drawable
from target_nav.mission.draw_png import png_of
from target_nav.mission.draw_scene import scene_of
from target_nav.mission.draw_svg import svg_of
from target_nav.mission.registry import NodeRegistry


def tree_of(
    path: str | Path, statuses: Mapping[str, str] | None = None, registry: NodeRegistry | None = None
) -> DrawNode:
    """A mission file for the functions below, its subtrees written out.

    `statuses` are of one tick, by path as in `tree_paths.paths_of`.

    Raises:
        MissionError: the file has errors, or the statuses are of another mission.
    """
    analysis = analyse(Path(path), registry)
    if analysis.errors:
        raise MissionError("\n".join(map(str, analysis.errors)))
    assert analysis.root is not None, "a mission without errors has a main tree"
    return drawable(analysis.root, statuses)


def draw_svg(tree: DrawNode, caption: str = "") -> str:
    """The text of an SVG file."""
    return svg_of(scene_of(place(tree), caption))


def draw_png(tree: DrawNode, caption: str = "") -> bytes:
    """The bytes of a PNG file.

    Raises:
        MissionError: matplotlib is not installed, or the picture would be too large.
    """
    return png_of(scene_of(place(tree), caption))

"""View models as the sections of a message: each a piece of JSON that is made once and sent to every viewer.

Points go as flat lists of whole centimetres or millimetres: a scan is most of a message, and this halves it.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from target_nav.gui.events import Event
from target_nav.gui.model import Views
from target_nav.gui.plain import to_plain
from target_nav.gui.view_camera import CameraView
from target_nav.gui.view_map import MapView
from target_nav.gui.view_radar import RadarView
from target_nav.gui.view_tree import TreeView
from target_nav.state.types import FloatArray

POINTS_PER_M = 200
"""Half a centimetre: a pixel of a screen is more."""


def dumps(value: Any) -> str:
    return json.dumps(value, separators=(",", ":"), ensure_ascii=False, allow_nan=False)


def flat_points(points_m: FloatArray) -> list[int]:
    """x0, y0, x1, y1 ... in units of 1 / POINTS_PER_M; what is not finite is left out."""
    finite = points_m[np.isfinite(points_m).all(axis=1)] if len(points_m) else points_m
    flat: list[int] = np.rint(finite * POINTS_PER_M).astype(np.int32).ravel().tolist()
    return flat


def radar_section(view: RadarView) -> str:
    plain = {name: to_plain(value) for name, value in vars(view).items() if not name.endswith("s_m")}
    for name in ("points_m", "obstacles_m"):
        plain[name] = flat_points(getattr(view, name))
    plain["room_m"] = flat_points(view.room_m)
    return dumps(plain)


def map_section(view: MapView) -> str:
    plain = {name: to_plain(value) for name, value in vars(view).items() if name not in _MAP_POINTS}
    for name in _MAP_POINTS:
        plain[name] = flat_points(getattr(view, name))
    return dumps(plain)


_MAP_POINTS = ("path_m", "obstacles_m")


def camera_section(view: CameraView) -> str:
    return dumps({name: to_plain(value) for name, value in vars(view).items() if name != "image_bgr"})


def tree_section(view: TreeView) -> str:
    """Rows as lists, for there are many of them: name, word, depth, status, active, feedback."""
    head = {name: to_plain(value) for name, value in vars(view).items() if name != "rows"}
    rows = [[r.name, r.word, r.depth, r.status, int(r.active), r.feedback] for r in view.rows]
    return dumps({**head, "rows": rows})


def events_section(events: tuple[Event, ...]) -> str:
    return dumps([[e.number, e.clock_text, e.level, e.text] for e in events])


def sections_of(views: Views) -> dict[str, str]:
    """All of them but the events; what belongs to a frame of the timeline."""
    return {
        "status": dumps(to_plain(views.status)),
        "arrival": dumps(to_plain(views.arrival)),
        "camera": camera_section(views.camera),
        "radar": radar_section(views.radar),
        "tree": tree_section(views.tree),
    }


def joined(sections: dict[str, str]) -> str:
    """Sections as the members of a JSON object, without its braces."""
    return ",".join(f'"{name}":{text}' for name, text in sections.items())

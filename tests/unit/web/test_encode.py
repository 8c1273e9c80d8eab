"""What goes to a page is JSON that any browser takes, whatever stands in the world."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from target_nav.config import Config
from target_nav.gui.model import Views
from target_nav.gui.source import World
from target_nav.gui.view_arrival import arrival_view
from target_nav.gui.view_camera import camera_view
from target_nav.gui.view_map import MapModel
from target_nav.gui.view_radar import radar_view
from target_nav.gui.view_status import status_view
from target_nav.gui.view_tree import tree_view
from target_nav.state.types import Pose2D
from target_nav.web.encode import flat_points, joined, map_section, sections_of
from tests.unit.gui import worlds


def views_of(world: World) -> Views:
    config = Config()
    return Views(
        now_s=world.now_s,
        status=status_view(world, config),
        camera=camera_view(world),
        radar=radar_view(world, config.robot),
        map=MapModel().view(world),
        tree=tree_view(world),
        arrival=arrival_view(world, config),
        events=(),
    )


def plain(world: World) -> dict[str, dict[str, object]]:
    views = views_of(world)
    message = f"{{{joined({**sections_of(views), 'map': map_section(views.map)})}}}"

    def refuse(constant: str) -> None:
        raise AssertionError(f"{constant} is no JSON")

    found: dict[str, dict[str, object]] = json.loads(message, parse_constant=refuse)
    return found


def test_a_world_with_everything_in_it() -> None:
    seen = plain(worlds.world())
    assert set(seen) == {"status", "arrival", "camera", "radar", "tree", "map"}
    assert seen["radar"]["points_m"] == [200, 0, 0, 200]
    assert seen["tree"]["rows"][2] == ["drive", "Sequence", 1, "RUNNING", 1, ""]  # type: ignore[index]
    assert "image_bgr" not in seen["camera"]


@pytest.mark.parametrize("missing", ["nav", "laser", "avoid", "tree", "det", "camera", "processes"])
def test_a_world_without_one_of_its_channels(missing: str) -> None:
    assert set(plain(worlds.world(**{missing: None}))) >= {"status", "radar", "tree"}


def test_a_world_of_which_nothing_is_finite() -> None:
    broken = worlds.nav(
        pose_in_odom=Pose2D(math.nan, math.inf, math.nan),
        track=worlds.track(x_m=math.nan, covariance_m2=(math.nan,) * 4, range_m=math.inf),
        scan_age_s=math.inf,
        jitter_p99_s=math.nan,
    )
    seen = plain(worlds.world(nav=broken, laser=worlds.laser([[math.nan, 1.0], [1.0, 2.0]])))
    assert seen["status"]["lateness_p99_s"] is None
    assert seen["map"]["pose"] == {"x_m": None, "y_m": None, "yaw_rad": None}


def test_points_are_flat_whole_half_centimetres_without_those_that_are_none() -> None:
    assert flat_points(np.array([[1.0, -0.5], [math.nan, 1.0], [0.0024, 3.0026]])) == [200, -100, 0, 601]
    assert flat_points(np.empty((0, 2))) == []

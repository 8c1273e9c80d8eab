"""Each view model: what it says of a friendly world, of one that is stale, and of one where nothing is there."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.config import Config
from target_nav.gui.geometry import SIGMAS_95, ellipse_of
from target_nav.gui.plain import to_plain
from target_nav.gui.source import age_text
from target_nav.gui.view_arrival import arrival_view
from target_nav.gui.view_camera import camera_view
from target_nav.gui.view_map import MOST_POINTS, MapModel
from target_nav.gui.view_radar import radar_view
from target_nav.gui.view_status import status_view
from target_nav.gui.view_tree import path_to, shown_rows, tree_view
from target_nav.state.snapshots import NodeStatus, ProcessRow, ProcessTable
from target_nav.state.types import NavState, Outcome, OutcomeKind, Pose2D
from tests.unit.gui import worlds
from tests.unit.gui.worlds import NOW_S, stale, world

CONFIG = Config()
NOTHING = dict.fromkeys(worlds.LIMITS_S)


class TestCamera:
    def test_a_box_has_its_corners_distance_and_confidence(self) -> None:
        (box,) = camera_view(world()).boxes
        assert (box.left_px, box.top_px, box.right_px, box.bottom_px) == (310.0, 205.0, 330.0, 275.0)
        assert box.label == "bowling pin 2.20 m 93%"
        assert box.is_target

    def test_a_clipped_box_does_not_claim_a_distance(self) -> None:
        (box,) = camera_view(world(det=worlds.frame(worlds.detection(clipped=True)))).boxes
        assert "clipped" in box.label
        assert "2.20" not in box.label

    @pytest.mark.parametrize("changes", [{"bearing_rad": 0.4}, {"class_name": "bottle"}])
    def test_a_box_elsewhere_or_of_another_thing_is_not_the_target(self, changes: dict[str, object]) -> None:
        (box,) = camera_view(world(det=worlds.frame(worlds.detection(**changes)))).boxes
        assert not box.is_target

    def test_an_old_picture_stays_and_says_its_age(self) -> None:
        view = camera_view(world(camera=stale("camera", worlds.PICTURE, 7.0)))
        assert view.image_bgr is worlds.PICTURE.image_bgr
        assert not view.fresh
        assert "7.0 s old" in view.message

    def test_boxes_are_shown_where_there_is_no_picture(self) -> None:
        view = camera_view(world(camera=None), 640, 480)
        assert (view.image_bgr, view.width_px, len(view.boxes)) == (None, 640, 1)
        assert "detector" in view.message


class TestRadar:
    def test_points_taken_before_a_turn_are_seen_from_where_the_robot_stands_now(self) -> None:
        # seen ahead, then the robot turned left by 90 degrees: it is on the right now
        now = worlds.nav(pose_in_odom=Pose2D(0.0, 0.0, math.pi / 2))
        view = radar_view(world(nav=now, laser=worlds.laser([(1.0, 0.0)])), CONFIG.robot)
        assert view.points_m[0] == pytest.approx([0.0, -1.0])
        assert view.direction_rad == pytest.approx(0.3 - math.pi / 2)

    def test_outline_and_obstacles_are_told_apart(self) -> None:
        view = radar_view(world(), CONFIG.robot)
        assert len(view.room_m) == 3
        assert view.obstacles_m.tolist() == [[0.5, 0.5]]

    def test_a_leaf_that_does_not_steer_has_no_direction_and_no_room(self) -> None:
        view = radar_view(world(avoid=worlds.avoid(active=False, outline_count=0)), CONFIG.robot)
        assert view.direction_rad is None
        assert len(view.room_m) == 0
        assert len(view.obstacles_m) == 4

    def test_the_targets_ellipse_turns_with_the_robot(self) -> None:
        now = worlds.nav(pose_in_odom=Pose2D(1.0, 0.0, 0.5))
        target = radar_view(world(nav=now), CONFIG.robot).target
        assert target is not None
        assert target.range_m == pytest.approx(1.0)
        assert target.bearing_rad == pytest.approx(-0.5)
        assert target.ellipse.angle_rad == pytest.approx(-0.5)
        assert target.ellipse.major_m == pytest.approx(0.2 * SIGMAS_95)
        assert target.age_s == pytest.approx(0.1)

    def test_without_anything_it_says_so(self) -> None:
        view = radar_view(world(**NOTHING), CONFIG.robot)
        assert (view.fresh, view.target, len(view.points_m)) == (False, None, 0)
        assert "nav" in view.message

    @given(st.floats(1e-6, 4.0), st.floats(1e-6, 4.0), st.floats(-3.0, 3.0))
    def test_an_ellipse_has_the_axes_and_the_angle_it_was_made_of(
        self, a: float, b: float, turn: float
    ) -> None:
        c, s = math.cos(turn), math.sin(turn)
        rotation = np.array([[c, -s], [s, c]])
        xx, xy, yx, yy = (rotation @ np.diag([a * a, b * b]) @ rotation.T).ravel().tolist()
        ellipse = ellipse_of(worlds.track(covariance_m2=(xx, xy, yx, yy)))
        major, minor = max(a, b), min(a, b)
        assert ellipse.major_m / SIGMAS_95 == pytest.approx(major, rel=1e-3)
        assert ellipse.minor_m / SIGMAS_95 == pytest.approx(minor, rel=1e-3, abs=2e-3 * major)
        if major > 1.2 * minor:
            wanted = turn if a > b else turn + math.pi / 2
            assert abs(math.sin(ellipse.angle_rad - wanted)) < 1e-2


class TestMap:
    def drive(self, model: MapModel, *places: tuple[float, float]) -> object:
        for x_m, y_m in places:
            view = model.view(world(nav=worlds.nav(pose_in_odom=Pose2D(x_m, y_m, 0.0))))
        return view

    def test_the_path_grows_with_the_way_and_ends_at_the_robot(self) -> None:
        model = MapModel()
        view = self.drive(model, *((0.1 * i, 0.0) for i in range(11)))
        assert view.driven_m == pytest.approx(1.0)
        assert view.path_m[-1] == pytest.approx([1.0, 0.0])

    def test_standing_adds_nothing(self) -> None:
        model = MapModel()
        view = self.drive(model, *[(0.0, 0.0)] * 50)
        assert len(view.path_m) == 2

    def test_a_jump_is_a_new_odometry_and_begins_a_new_path(self) -> None:
        model = MapModel()
        view = self.drive(model, (5.0, 5.0), (5.1, 5.0), (0.0, 0.0), (0.1, 0.0))
        assert view.path_m[0] == pytest.approx([0.0, 0.0])
        assert view.driven_m == pytest.approx(0.1)

    def test_its_memory_is_bounded_however_far_it_drives(self) -> None:
        model = MapModel()
        for i in range(3 * MOST_POINTS):
            model._add(0.05 * i, 0.0)
        view = model.view(world(nav=worlds.nav(pose_in_odom=Pose2D(0.05 * 3 * MOST_POINTS, 0.0, 0.0))))
        assert len(view.path_m) <= MOST_POINTS + 1
        assert view.path_m[0] == pytest.approx([0.0, 0.0])

    def test_the_bounds_hold_path_and_target(self) -> None:
        view = self.drive(MapModel(), (0.0, 0.0), (0.0, 0.3))
        assert view.x_min_m < 0.0 < 2.0 < view.x_max_m

    def test_a_stale_pose_does_not_draw(self) -> None:
        model = MapModel()
        self.drive(model, (0.0, 0.0))
        old = world(nav=stale("nav", worlds.nav(pose_in_odom=Pose2D(0.3, 0.0, 0.0))))
        assert model.view(old).driven_m == 0.0


class TestTree:
    def test_rows_have_marks_that_need_no_colour(self) -> None:
        view = tree_view(world())
        assert [row.mark for row in view.rows] == ["▶", "✔", "▶", "·"]
        assert view.rows[view.current].name == "drive"
        assert path_to(view, view.current) == [0, 2]

    def test_without_a_running_leaf_there_is_no_current_one(self) -> None:
        view = tree_view(world(tree=worlds.tree(("root", 0, NodeStatus.FAILURE, True))))
        assert (view.current, path_to(view, view.current)) == (-1, [])

    def test_a_small_screen_keeps_the_running_path(self) -> None:
        rows = [("root", 0, NodeStatus.RUNNING, True)]
        rows += [(f"old {i}", 1, NodeStatus.INVALID, False) for i in range(30)]
        rows += [("go", 1, NodeStatus.RUNNING, True), ("drive", 2, NodeStatus.RUNNING, True)]
        kept = shown_rows(tree_view(world(tree=worlds.tree(*rows))), 4)
        assert {"root", "go", "drive"} <= {row.name for row in kept}
        assert len(kept) == 4

    def test_what_did_not_fit_is_counted(self) -> None:
        view = tree_view(world(tree=worlds.changed(worlds.TREE, total=300)))
        assert view.hidden == 296


class TestStatus:
    @pytest.mark.parametrize(
        ("changes", "headline"),
        [
            ({}, "NAVIGATING"),
            ({"state": NavState.SPIRAL_SEARCH}, "SPIRAL SEARCH"),
            ({"manual": True}, "MANUAL"),
            ({"paused": True}, "NAVIGATING (PAUSED)"),
            ({"outcome": Outcome(OutcomeKind.FAILED, "lost it")}, "GAVE UP"),
        ],
    )
    def test_the_headline_is_what_the_robot_does(self, changes: dict[str, object], headline: str) -> None:
        assert status_view(world(nav=worlds.nav(**changes)), CONFIG).headline == headline

    def test_ages_go_on_while_the_nav_process_is_silent(self) -> None:
        old = world(now_s=NOW_S + 3.0, nav=stale("nav", worlds.nav(), 3.0))
        links = {link.name: link for link in status_view(old, CONFIG).links}
        assert links["scan"].age_s == pytest.approx(3.2)
        assert not links["scan"].fresh
        assert links["det"].fresh

    def test_the_banner_names_the_dead_process_before_all_else(self) -> None:
        table = ProcessTable(
            NOW_S, (ProcessRow("nav", "running", 1, 0), ProcessRow("arduino", "restarting", 0, 2))
        )
        view = status_view(world(processes=table, camera=None), CONFIG)
        assert view.dead == ("arduino",)
        assert view.banner == "process arduino is down"

    def test_a_process_that_let_go_of_its_channel_is_dead_without_a_supervisor_too(self) -> None:
        view = status_view(world(processes=None, gone=("camera",)), CONFIG)
        assert view.dead == ("camera",)

    def test_an_old_table_accuses_nobody(self) -> None:
        table = ProcessTable(NOW_S, (ProcessRow("nav", "failed", 0, 9),))
        assert status_view(world(processes=stale("processes", table)), CONFIG).dead == ()

    @pytest.mark.parametrize(
        ("changes", "quiet"),
        [
            ({"requested": False}, True),
            ({"requested": True}, False),
            ({"requested": False, "manual": True}, False),
            ({"outcome": Outcome(OutcomeKind.SUCCEEDED, "")}, True),
        ],
    )
    def test_odometry_that_is_silent_because_nobody_drives_is_no_alarm(
        self, changes: dict[str, object], quiet: bool
    ) -> None:
        view = status_view(world(nav=worlds.nav(odom_age_s=60.0, **changes)), CONFIG)
        link = next(link for link in view.links if link.name == "odom")
        assert (link.quiet, link.fresh) == (quiet, False)
        assert (view.banner == "") == quiet

    def test_nothing_at_all_is_told_and_breaks_nothing(self) -> None:
        view = status_view(world(**NOTHING), CONFIG)
        assert view.headline == "NO CONTACT"
        assert not any(link.fresh for link in view.links)
        assert view.banner


class TestArrival:
    def test_the_gap_is_front_edge_to_surface(self) -> None:
        view = arrival_view(world(), CONFIG)
        assert view.gap_m == pytest.approx(2.0 - CONFIG.robot.front_m - 0.04)
        assert view.left_m == pytest.approx(view.gap_m - CONFIG.approach.stand_off_m)

    def test_progress_ends_at_the_stand_off(self) -> None:
        gap_m = CONFIG.robot.front_m + 0.04 + CONFIG.approach.stand_off_m
        near = worlds.nav(track=worlds.track(range_m=gap_m))
        assert arrival_view(world(nav=near), CONFIG).progress == pytest.approx(1.0)
        assert arrival_view(world(), CONFIG).progress == 0.0

    def test_without_a_target_there_is_no_number(self) -> None:
        view = arrival_view(world(nav=worlds.nav(track=None)), CONFIG)
        assert math.isnan(view.gap_m)
        assert view.progress == 0.0

    @pytest.mark.parametrize(
        ("kind", "title"), [(OutcomeKind.SUCCEEDED, "ARRIVED"), (OutcomeKind.FAILED, "GAVE UP")]
    )
    def test_it_says_how_it_ended(self, kind: OutcomeKind, title: str) -> None:
        view = arrival_view(world(nav=worlds.nav(outcome=Outcome(kind, "so"), track=None)), CONFIG)
        assert (view.done, view.title, view.reason) == (True, title, "so")


@pytest.mark.parametrize("missing", [*worlds.LIMITS_S, "all"])
def test_every_view_survives_that_a_channel_is_missing_and_becomes_json(missing: str) -> None:
    look = world(**(NOTHING if missing == "all" else {missing: None}))
    views = (
        status_view(look, CONFIG), camera_view(look), radar_view(look, CONFIG.robot), MapModel().view(look),
        tree_view(look), arrival_view(look, CONFIG),
    )  # fmt: skip
    assert json.loads(json.dumps([to_plain(view) for view in views], allow_nan=False))


def test_plain_values_have_names_for_enums_null_for_what_is_not_finite_and_no_picture() -> None:
    plain = to_plain(camera_view(world()))
    assert plain["image_bgr"] is None
    assert plain["boxes"][0]["score"] == 0.93
    assert to_plain(math.inf) is None
    assert to_plain(NavState.IDLE) == "IDLE"
    assert to_plain(np.array([[1.0, math.nan]])) == [[1.0, None]]


@pytest.mark.parametrize(
    ("age_s", "text"),
    [(0.123, "0.12 s"), (3.21, "3.2 s"), (53.2, "53 s"), (600.0, "10 min"), (math.inf, "-")],
)
def test_ages_are_short(age_s: float, text: str) -> None:
    assert age_text(age_s) == text

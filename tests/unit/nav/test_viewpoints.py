"""Where to look from next: what shows most for its way, and nothing that shows nothing."""

from __future__ import annotations

import numpy as np

from target_nav.config import Config
from target_nav.nav.coverage import Coverage
from target_nav.nav.drive import Driver
from target_nav.nav.viewpoints import Verdict, Viewpoints
from target_nav.state.types import FloatArray, Pose2D
from tests.unit.nav.views import NO_POINTS, points, view, wall

CONFIG = Config()
LIMIT_M = 40.0


def room_with(spots: FloatArray, obstacles: FloatArray = NO_POINTS) -> tuple[Viewpoints, Coverage]:
    """The robot stands at the origin and looks ahead; nothing has been looked at, everything in sight is floor."""
    coverage, driver = Coverage(CONFIG.camera, 2.0), Driver(CONFIG)
    driver.known_points(view(obstacles=obstacles))
    coverage.update(Pose2D(), obstacles, 4.0)
    coverage.look_again(2.0)
    places = Viewpoints(coverage, driver, 0.25, LIMIT_M)
    places.begin(spots)
    places.look(0.2)
    return places, coverage


def chosen(places: Viewpoints, obstacles: FloatArray = NO_POINTS) -> tuple[float, float] | None:
    verdict = Verdict.ASKING
    for _ in range(60):
        verdict = places.choose(view(obstacles=obstacles))
        if verdict is not Verdict.ASKING:
            break
    assert verdict is not Verdict.ASKING, "it decides in a bounded number of ticks"
    return places.place_m if verdict is Verdict.CHOSEN else None


def test_of_two_that_show_as_much_the_nearer_is_next() -> None:
    places, _ = room_with(points((2.0, 0.0), (0.8, 0.0)))
    assert chosen(places) == (0.8, 0.0)


def test_one_that_was_looked_round_from_is_not_next_again() -> None:
    places, coverage = room_with(points((0.8, 0.0), (2.0, 1.0)))
    assert chosen(places) == (0.8, 0.0)
    coverage.settle(Pose2D(0.8, 0.0))
    places.finish()
    assert chosen(places) == (2.0, 1.0)


def test_where_all_was_seen_there_is_none() -> None:
    places, coverage = room_with(points((0.5, 0.0), (0.0, 0.5)))
    for x in np.arange(-2.0, 2.1, 0.5):
        for y in np.arange(-2.0, 2.1, 0.5):
            coverage.settle(Pose2D(float(x), float(y)))
    assert chosen(places) is None


def test_what_cannot_be_reached_is_none() -> None:
    shut_in = np.vstack(
        [
            wall(-0.5, -0.5, 0.5, -0.5),
            wall(0.5, -0.5, 0.5, 0.5),
            wall(0.5, 0.5, -0.5, 0.5),
            wall(-0.5, 0.5, -0.5, -0.5),
        ]
    )
    places, _ = room_with(points((2.0, 0.0), (0.0, 2.0)), shut_in)
    assert chosen(places, shut_in) is None


def test_one_that_was_given_up_does_not_come_back_with_the_next_look() -> None:
    places, _ = room_with(points((0.8, 0.0), (2.0, 0.0)))
    assert chosen(places) == (0.8, 0.0)
    places.finish(given_up=True)
    places.look(0.1)
    assert chosen(places) == (2.0, 0.0)
    assert places.left == 1


def test_floor_that_has_come_to_be_known_makes_a_place_worth_asking_again() -> None:
    spots = points((0.8, 0.0))
    coverage, driver = Coverage(CONFIG.camera, 2.0), Driver(CONFIG)
    places = Viewpoints(coverage, driver, 0.25, LIMIT_M)
    coverage.update(Pose2D(), NO_POINTS, 1.0)
    places.begin(spots)
    places.look(4.0)
    assert chosen(places) is None, "what lies farther off may be a wall's inside: little counts"
    coverage.update(Pose2D(), NO_POINTS, 4.0)
    assert chosen(places) == (0.8, 0.0)


def test_thousands_of_places_are_compared_a_few_at_a_time() -> None:
    x, y = (axis.reshape(-1) for axis in np.meshgrid(np.linspace(-3.0, 3.0, 40), np.linspace(-3.0, 3.0, 40)))
    places, _ = room_with(np.column_stack([x, y]))
    assert chosen(places) is not None

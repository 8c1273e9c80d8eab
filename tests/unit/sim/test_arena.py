"""Arenas that are right, and every way to write one wrong with the message it gets."""

import math
from pathlib import Path

import numpy as np
import pytest

from target_nav.config import Config
from target_nav.errors import ConfigError
from target_nav.sim.arena import (
    ARENA_FOLDER,
    BoxObstacle,
    CircleObstacle,
    Goal,
    PlacedObject,
    WallObstacle,
    list_arenas,
    load_arena,
)
from target_nav.sim.world import World
from target_nav.state.types import Pose2D

PROMISED = {
    "open_floor", "pin_behind_boxes", "doorway", "pin_beside_wall", "box_before_pin", "decoys", "pin_out_of_sight",
    "no_pin",
}  # fmt: skip

FULL = """\
name: everything
bounds: [-3.0, -3.0, 3.0, 3.0]
robot: {x: -2.0, y: 0.5, yaw: 0.25}
target: {class: bowling_pin, x: 2.0, y: 0.5}
obstacles:
  - {circle: [0.0, 0.2, 0.15]}
  - {box: [0.5, -0.6, 0.4, 0.3, 0.2]}
  - {wall: [1.0, 1.0, 1.0, 2.0]}
decoys: [{class: bottle, x: 1.0, y: -1.0}]
profile: {lidar.rate_hz: 10, robot.drive: differential}
time_limit_s: 90
"""
HEAD = "bounds: [-3, -3, 3, 3]\nrobot: {x: 0, y: 0}\n"


def load(tmp_path: Path, text: str | bytes, name: str = "a.yaml"):
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return load_arena(path)


def problems(tmp_path: Path, text: str | bytes) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        load(tmp_path, text)
    lines = str(caught.value).splitlines()
    prefix = f"{tmp_path / 'a.yaml'}:"
    assert all(line.startswith(prefix) for line in lines)
    return [line.removeprefix(prefix) for line in lines]


def test_every_part_of_the_format_is_read(tmp_path):
    arena = load(tmp_path, FULL)
    assert arena.name == "everything"
    assert arena.bounds == (-3.0, -3.0, 3.0, 3.0)
    assert arena.robot == Pose2D(-2.0, 0.5, 0.25)
    assert arena.target == PlacedObject("bowling_pin", 2.0, 0.5)
    assert arena.target.shape.radius_m == 0.04
    assert arena.obstacles == (
        CircleObstacle(0.0, 0.2, 0.15),
        BoxObstacle(0.5, -0.6, 0.4, 0.3, 0.2),
        WallObstacle(1.0, 1.0, 1.0, 2.0),
    )
    assert arena.decoys == (PlacedObject("bottle", 1.0, -1.0),)
    assert (arena.time_limit_s, arena.expect) == (90.0, "arrived")
    assert arena.config == Config().override({"lidar.rate_hz": 10.0, "robot.drive": "differential"})


def test_what_may_be_left_out(tmp_path):
    arena = load(tmp_path, HEAD, "short.yaml")
    assert (arena.name, arena.target, arena.goal, arena.obstacles) == ("short", None, None, ())
    assert arena.expect == "not_found"
    assert arena.config == Config()


def test_a_goal_in_place_of_a_target(tmp_path):
    arena = load(tmp_path, HEAD + "goal: {x: 2.0, y: 1, radius: 1e-1}\n")
    assert arena.goal == Goal(2.0, 1.0, 0.1)
    assert arena.expect == "arrived"


def test_the_profile_changes_the_configuration_it_is_given(tmp_path):
    path = tmp_path / "a.yaml"
    path.write_text(HEAD + "profile: {lidar.rate_hz: 10.0}\n")
    config = load_arena(path, Config().override({"camera.rate_hz": 30.0, "lidar.rate_hz": 7.0})).config
    assert (config.camera.rate_hz, config.lidar.rate_hz) == (30.0, 10.0)


def test_the_promised_arenas_come_along_and_all_load():
    assert set(list_arenas()) >= PROMISED
    for name in list_arenas():
        arena = load_arena(name)
        assert arena.name == name
        assert arena.time_limit_s >= 120.0
        assert (ARENA_FOLDER / f"{name}.yaml").read_text().startswith("# ")
        assert (arena.target is None and arena.goal is None) == (arena.expect == "not_found")


@pytest.mark.parametrize("name", sorted(set(list_arenas()) - {"no_pin"}))
def test_there_is_a_way_to_the_target_for_a_robot_of_0_2_m_radius(name):
    """Flood fill on a grid of 5 cm: a disc of the robot's half width and margin comes up to the target or the goal."""
    arena = load_arena(name)
    end = arena.target or arena.goal
    assert end is not None
    radius_m, cell_m = arena.config.robot.half_width_m + 0.05, 0.05
    world = World(arena)
    x0, y0, x1, y1 = arena.bounds
    xs, ys = np.arange(x0, x1, cell_m), np.arange(y0, y1, cell_m)
    grid_x, grid_y = np.meshgrid(xs, ys, indexing="ij")
    free = np.ones(grid_x.shape, dtype=bool)
    for ax, ay, bx, by in world.segments:
        ex, ey = bx - ax, by - ay
        along = np.clip(((grid_x - ax) * ex + (grid_y - ay) * ey) / (ex * ex + ey * ey), 0.0, 1.0)
        free &= np.hypot(grid_x - ax - along * ex, grid_y - ay - along * ey) > radius_m
    for cx, cy, cr in world.circles[[*range(len(world.circles))]]:
        is_target = (cx, cy) == (end.x_m, end.y_m)
        free &= np.hypot(grid_x - cx, grid_y - cy) > cr + (0.0 if is_target else radius_m)
    start = round((arena.robot.x_m - x0) / cell_m), round((arena.robot.y_m - y0) / cell_m)
    assert free[start]
    reached, front = {start}, [start]
    while front:
        i, j = front.pop()
        for place in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)):
            if place not in reached and 0 <= place[0] < len(xs) and 0 <= place[1] < len(ys) and free[place]:
                reached.add(place)
                front.append(place)
    stand_m = 0.0
    if arena.target is not None:
        stand_m = arena.config.robot.front_m + arena.config.approach.stand_off_m + arena.target.shape.radius_m
    gaps = [math.hypot(xs[i] - end.x_m, ys[j] - end.y_m) for i, j in reached]
    assert min(abs(gap - stand_m) for gap in gaps) < cell_m


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        # not an arena at all
        ("", "1: error: the file is empty; see docs/simulator.md for the format"),
        ("# only a comment\n", "1: error: the file is empty; see docs/simulator.md for the format"),
        ("just words\n", "1: error: an arena is 'just words'; it must be a mapping (key: value)"),
        ("- 1\n- 2\n", "1: error: an arena is a list of 2; it must be a mapping (key: value)"),
        ("a: [1, 2\nb: 3\n", "2: error: not YAML: expected ',' or ']', but got ':'"),
        (b"\xff\xfe\x00name", "1: error: not UTF-8 text; is it the right file?"),
        (b"a: 1\nb: \x80\n", "2: error: not UTF-8 text; is it the right file?"),
        (b"a: \x07\n", "1: error: not YAML: unacceptable character #x0007: special characters are not allowed"),
        (HEAD + "---\nbounds: []\n", "3: error: not YAML: but found another document"),
        (b"#" * 1_000_001, "1: error: larger than 1000000 bytes; is it the right file?"),
        ("a: &x [1]\nb: *x\n", "2: error: not YAML: an alias (*name) is not taken here; write the value out"),
        ("[" * 500 + "]" * 500, "1: error: not YAML: nested deeper than 12; is a bracket missing?"),
        # keys
        ("bounds: [-3, -3, 3, 3]\n", "1: error: an arena lacks robot"),
        (HEAD + "obstcles: []\n", "3: error: an arena has no key 'obstcles'; did you mean 'obstacles'?"),
        (HEAD + "robot: {x: 1, y: 1}\n", "3: error: an arena has 'robot' twice (first in line 2); keep one"),
        (HEAD + "[1]: 2\n", "3: error: an arena has a list of 1 for a key; it must be a word"),
        (HEAD + "name: [x]\n", "3: error: name is a list of 1; it must be a word"),
        (HEAD + "name:\n", "3: error: name is empty; it must be a word"),
        # numbers
        ("bounds: [-3, -3, 3]\nrobot: {x: 0, y: 0}\n",
         "1: error: bounds has 3 values; it must have 4: x_min, y_min, x_max, y_max"),
        ("bounds: [-3, -3, 3, nowhere]\nrobot: {x: 0, y: 0}\n",
         "1: error: bounds's y_max is 'nowhere'; it must be a number in m"),
        ("bounds: [-3, -3, 3, .inf]\nrobot: {x: 0, y: 0}\n",
         "1: error: bounds's y_max is .inf; it must be a finite number in m"),
        ("bounds: [-3000, -3, 3, 3]\nrobot: {x: 0, y: 0}\n",
         "1: error: bounds's x_min is -3000 m; it must lie in -1000 ... 1000 m"),
        ("bounds: [3, -3, -3, 3]\nrobot: {x: 0, y: 0}\n",
         "1: error: bounds are -6 by 6 m; x_max must be over x_min and y_max over y_min by at least 0.5 m"),
        ("bounds: [0, 0, 6, 0.1]\nrobot: {x: 0, y: 0}\n",
         "1: error: bounds are 6 by 0.1 m; x_max must be over x_min and y_max over y_min by at least 0.5 m"),
        ("bounds: [-3, -3, 3, 3]\nrobot: {x: .nan, y: 0}\n",
         "2: error: robot's x is .nan; it must be a finite number in m"),
        ("bounds: [-3, -3, 3, 3]\nrobot: {x: true, y: 0}\n",
         "2: error: robot's x is 'true'; it must be a number in m"),
        ("bounds: [-3, -3, 3, 3]\nrobot: {x: 1:30, y: 0}\n",
         "2: error: robot's x is '1:30'; it must be a number in m"),
        ("bounds: [-3, -3, 3, 3]\nrobot: {x: 0, y: 0, yaw: 90}\n",
         "2: error: robot's yaw is 90 rad; it must lie in -6.28319 ... 6.28319 rad"),
        (HEAD + "time_limit_s: 0\n", "3: error: time_limit_s is 0 s; it must lie in 1 ... 36000 s"),
        # things
        (HEAD + "target: {x: 1, y: 1}\n", "3: error: target lacks class"),
        (HEAD + "target: {class: bowling_pn, x: 1, y: 1}\n",
         "3: error: target: there is no class 'bowling_pn'; did you mean 'bowling_pin'?"),
        (HEAD + "target: {class: bowling_pin, x: 1, y: 1, z: 0}\n",
         "3: error: target has no key 'z'; it has class, x, y, yaw, velocity_mps, moves_s"),
        (HEAD + "goal: {x: 1, y: 1, radius: -0.1}\n",
         "3: error: goal's radius is -0.1 m; it must lie in 0.001 ... 1000 m"),
        (HEAD + "target: {class: bottle, x: 1, y: 1}\ngoal: {x: 1, y: 2, radius: 1}\n",
         "4: error: there is a target and a goal; keep one of them"),
        (HEAD + "decoys: 5\n", "3: error: decoys is '5'; it must be a list"),
        (HEAD + "expect: arived\n", "3: error: expect is 'arived'; it must be arrived or not_found"),
        (HEAD + "expect: arrived\n",
         "3: error: expect is 'arrived', but there is no target and no goal; add one"),
        # obstacles
        (HEAD + "obstacles:\n  - {circle: [1, 1, -0.2]}\n",
         "4: error: obstacles[0]: radius is -0.2 m; it must be at least 0.001 m"),
        (HEAD + "obstacles:\n  - {box: [1, 1, 0.5, 0, 0]}\n",
         "4: error: obstacles[0]: width is 0 m; it must be at least 0.001 m"),
        (HEAD + "obstacles:\n  - {wall: [1, 1, 1, 1]}\n",
         "4: error: obstacles[0]: the wall begins and ends at (1, 1)"),
        (HEAD + "obstacles:\n  - {box: [1, 1, 0.5, 0.5]}\n",
         "4: error: obstacles[0]: box has 4 values; it must have 5: x, y, length, width, yaw"),
        (HEAD + "obstacles:\n  - {cirle: [1, 1, 1]}\n",
         "4: error: obstacles[0] has no key 'cirle'; did you mean 'circle'?"),
        (HEAD + "obstacles:\n  - {}\n", "4: error: obstacles[0] must be one of circle, box, wall"),
        (HEAD + "obstacles:\n  - {circle: [1, 1, 0.1], wall: [1, 1, 2, 2]}\n",
         "4: error: obstacles[0] must be one of circle, box, wall"),
        (HEAD + "obstacles:\n  - {circle: [9, 9, 0.5]}\n",
         "4: error: obstacles[0] lies outside of the bounds [-3, -3, 3, 3]; move it or drop it"),
        # the profile
        (HEAD + "profile: {lidar.rate: 10}\n",
         "3: error: profile: unknown key 'lidar.rate'; did you mean 'lidar.rate_hz'?"),
        (HEAD + "profile:\n  lidar.rate_hz: 900\n",
         "4: error: profile: lidar.rate_hz is 900 Hz; it must lie in 0.5 ... 100 Hz (turns a second "
         "(measured: 182 ms a turn))"),
        (HEAD + "profile: {lidar: {rate_hz: 10}}\n", "3: error: profile: lidar is a mapping; it must be one value"),
        (HEAD + "profile: {lidar.range_min_m: 3, lidar.range_max_m: 2}\n",
         "3: error: lidar.range_min_m is 3 m; it must be under lidar.range_max_m (2 m)"),
        (HEAD + "profile: {camera.z_m: 0.6}\n",
         "3: error: camera.z_m is 0.6 m; it must be under the obstacles' height, 0.5 m"),
        # places
        ("bounds: [-3, -3, 3, 3]\nrobot: {x: 2.9, y: 0}\n",
         "2: error: robot at (2.9, 0): its footprint (0.3 by 0.28 m) reaches outside of the bounds [-3, -3, 3, 3]; "
         "move it in"),
        (HEAD + "obstacles:\n  - {circle: [2, 2, 0.1]}\n  - {circle: [0.2, 0, 0.1]}\n",
         "2: error: robot at (0, 0): its footprint touches obstacles[1]; move one of them"),
        (HEAD + "obstacles:\n  - {box: [0, 0, 2, 2, 0.3]}\n",
         "2: error: robot at (0, 0): its footprint touches obstacles[0]; move one of them"),
        (HEAD + "obstacles: [{wall: [-1, 0.1, 1, 0.1]}]\n",
         "2: error: robot at (0, 0): its footprint touches obstacles[0]; move one of them"),
        (HEAD + "target: {class: bowling_pin, x: 0.18, y: 0}\n",
         "2: error: robot at (0, 0): its footprint touches the target (bowling_pin); move one of them"),
        (HEAD + "target: {class: bowling_pin, x: 2.98, y: 0}\n",
         "3: error: target (bowling_pin) at (2.98, 0) lies outside of the bounds [-3, -3, 3, 3]; move it in"),
        (HEAD + "target: {class: bowling_pin, x: 1, y: 1}\nobstacles: [{box: [1, 1, 1, 1, 0]}]\n",
         "3: error: target (bowling_pin) at (1, 1) stands in obstacles[0]; move one of them"),
        (HEAD + "goal: {x: 1, y: 1, radius: 0.1}\nobstacles: [{circle: [1, 1, 0.3]}]\n",
         "3: error: goal at (1, 1) stands in obstacles[0]; move one of them"),
        (HEAD + "target: {class: bowling_pin, x: 1, y: 1}\ndecoys: [{class: cup, x: 1.05, y: 1}]\n",
         "4: error: decoys[0] (cup) at (1.05, 1) stands in the target (bowling_pin); move one of them"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_told_with_its_line(tmp_path, text, expected):
    assert problems(tmp_path, text) == [expected]


def test_everything_wrong_is_told_at_once_in_the_order_of_the_lines(tmp_path):
    found = problems(
        tmp_path,
        "bounds: [-3, -3, 3, 3]\n"
        "robot: {x: 0, y: 0}\n"
        "target: {class: bowling_pin, x: 9, y: 0}\n"
        "obstacles:\n"
        "  - {circle: [1, 1]}\n"
        "  - {circle: [0.1, 0, 0.1]}\n"
        "profile: {nonsense.key: 1, lidar.beams: 2}\n"
        "colour: blue\n",
    )
    assert [line.split(":")[0] for line in found] == ["2", "3", "5", "7", "7", "8"]
    assert "touches obstacles[1]" in found[0]  # numbered as in the file, the bad one before it counted


def test_an_alias_bomb_costs_nothing(tmp_path):
    bomb = "a0: &a0 [x, x]\n" + "".join(f"a{i}: &a{i} [*a{i - 1}, *a{i - 1}]\n" for i in range(1, 60))
    (line,) = problems(tmp_path, bomb)
    assert line.startswith("2: error: not YAML: an alias")


def test_a_name_that_is_not_there_gets_the_nearest_one():
    with pytest.raises(
        ConfigError, match=r"open_flor:1: error: there is no such arena; did you mean 'open_floor'\?"
    ):
        load_arena("open_flor")
    with pytest.raises(ConfigError, match=r"arenas that come along: .*doorway"):
        load_arena("qqq.yaml")


def test_a_folder_is_not_an_arena(tmp_path):
    with pytest.raises(ConfigError, match="cannot be read"):
        load_arena(tmp_path)


def test_a_file_goes_before_an_arena_of_the_same_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("open_floor").write_text(HEAD + "name: mine\n")
    assert load_arena("open_floor").name == "mine"


def test_the_example_of_the_documentation_is_an_arena(tmp_path):
    page = (Path(__file__).parents[3] / "docs" / "simulator.md").read_text()
    arena = load(tmp_path, page.split("```yaml\n")[1].split("```")[0])
    assert arena.name == "pin_behind_boxes"
    assert len(arena.obstacles) == 3

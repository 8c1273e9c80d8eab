"""The arena's YAML into an `Arena`, or every mistake in it with file and line."""

from __future__ import annotations

import difflib
import math
import re
from pathlib import Path

import yaml

from target_nav.config import Config
from target_nav.errors import ConfigError
from target_nav.sim.arena_checks import geometry_problems
from target_nav.sim.arena_types import (
    ARRIVED,
    ENDINGS,
    NOT_FOUND,
    Arena,
    Bounds,
    BoxObstacle,
    CircleObstacle,
    Goal,
    Obstacle,
    PlacedObject,
    WallObstacle,
    config_for_goal,
)
from target_nav.sim.objects import is_class, is_tag, unknown_class
from target_nav.state.types import Pose2D
from target_nav.utils.yaml_nodes import NodeReader, describe, scalar

WORLD_LIMITS_M = (-1000.0, 1000.0)
"""An arena is a room or a hall: what lies farther out is a slip of the unit (millimetres)."""

SIZE_LIMITS_M = (0.001, 1000.0)
TIME_LIMITS_S = (1.0, 36_000.0)
DEFAULT_TIME_LIMIT_S = 120.0
VELOCITY_LIMITS_MPS = (-0.5, 0.5)
"""Of a target. The reference robot does 0.3 m/s; what is faster than this it would only ever see leave."""
LEVEL_LIMITS = (0.0, 9.0)

_SHAPES = {
    "circle": ("x", "y", "radius"),
    "box": ("x", "y", "length", "width", "yaw"),
    "wall": ("x1", "y1", "x2", "y2"),
}


def read_arena(path: Path, config: Config, known: tuple[str, ...] = ()) -> Arena:
    """`known` are names to suggest when there is no such file.

    Raises:
        ConfigError: one line `file:line: error: ...` a problem.
    """
    if not path.exists():
        near = difflib.get_close_matches(path.stem, known, n=1)
        hint = f"did you mean {near[0]!r}?" if near else f"arenas that come along: {', '.join(known)}"
        raise ConfigError(f"{path}:1: error: there is no such arena; {hint}")
    return _ArenaReader(path, config).read()


class _ArenaReader:
    def __init__(self, path: Path, config: Config) -> None:
        self._file = NodeReader(path)
        self._config = config
        self._places: dict[str, yaml.Node] = {}
        """Where a part stands in the file, by the name `arena_checks` gives it."""
        self._numbers: dict[str, str] = {}
        """That name, and the one it has in a file with bad items before it."""

    def read(self) -> Arena:
        root = self._file.load()
        keys = self._file.mapping(
            root,
            "an arena",
            required=("bounds", "robot"),
            optional=(
                "name",
                "target",
                "goal",
                "obstacles",
                "decoys",
                "profile",
                "time_limit_s",
                "expect",
                "kind",
                "level",
            ),
        )
        arena = self._arena(root, keys) if keys is not None else None
        if arena is not None:
            for place, message in geometry_problems(arena):
                self._file.complain(self._places.get(place, root), self._numbered_as_in_file(message))
        self._file.raise_problems()
        if arena is None:
            raise ConfigError(f"{self._file.path}:1: error: not an arena")
        return arena

    def _arena(self, root: yaml.Node, keys: dict[str, yaml.Node]) -> Arena | None:
        """As much of the arena as can be understood, so that its geometry is checked too; None without a frame."""
        name = self._file.text(keys["name"], "name") if "name" in keys else self._file.path.stem
        bounds = self._bounds(keys["bounds"]) if "bounds" in keys else None
        robot = self._robot(keys["robot"]) if "robot" in keys else None
        target = self._object("target", keys["target"], "target") if "target" in keys else None
        goal = self._goal(keys["goal"]) if "goal" in keys else None
        obstacles = self._obstacles(keys["obstacles"]) if "obstacles" in keys else ()
        decoys = self._decoys(keys["decoys"]) if "decoys" in keys else ()
        config = self._profile(keys["profile"]) if "profile" in keys else self._config
        limit_s: float | None = DEFAULT_TIME_LIMIT_S
        if "time_limit_s" in keys:
            limit_s = self._file.number(keys["time_limit_s"], "time_limit_s", "s", *TIME_LIMITS_S)
        if "target" in keys and "goal" in keys:
            self._file.complain(keys["goal"], "there is a target and a goal; keep one of them")
        expect = self._expect(keys)
        if bounds is None or robot is None:
            return None
        if goal is not None:
            config = config_for_goal(config, robot, goal)
        return Arena(
            name=name or "",
            bounds=bounds,
            robot=robot,
            target=target,
            goal=goal,
            obstacles=obstacles,
            decoys=decoys,
            config=config,
            time_limit_s=limit_s or DEFAULT_TIME_LIMIT_S,
            expect=expect,
            kind=(self._file.text(keys["kind"], "kind") if "kind" in keys else None) or "",
            level=self._level(keys),
        )

    def _bounds(self, node: yaml.Node) -> Bounds | None:
        self._places["bounds"] = node
        names = ("x_min", "y_min", "x_max", "y_max")
        values = self._file.numbers(node, "bounds", names, WORLD_LIMITS_M)
        return Bounds(*values) if values is not None else None

    def _robot(self, node: yaml.Node) -> Pose2D | None:
        self._places["robot"] = node
        keys = self._file.mapping(node, "robot", required=("x", "y"), optional=("yaw",))
        position = self._position(keys, "robot")
        yaw: float | None = 0.0
        if keys is not None and "yaw" in keys:
            yaw = self._file.number(keys["yaw"], "robot's yaw", "rad", -2.0 * math.pi, 2.0 * math.pi)
        return Pose2D(*position, yaw) if position is not None and yaw is not None else None

    def _goal(self, node: yaml.Node) -> Goal | None:
        self._places["goal"] = node
        keys = self._file.mapping(node, "goal", required=("x", "y", "radius"))
        position = self._position(keys, "goal")
        if keys is None or "radius" not in keys:
            return None
        radius = self._file.number(keys["radius"], "goal's radius", "m", *SIZE_LIMITS_M)
        return Goal(*position, radius) if position is not None and radius is not None else None

    def _object(self, place: str, node: yaml.Node, what: str) -> PlacedObject | None:
        self._places[place] = node
        moves = ("velocity_mps", "moves_s") if what == "target" else ()
        keys = self._file.mapping(node, what, required=("class", "x", "y"), optional=("yaw", *moves))
        position = self._position(keys, what)
        if keys is None or "class" not in keys:
            return None
        name = self._file.text(keys["class"], f"{what}'s class")
        if name is not None and not is_class(name):
            self._file.complain(keys["class"], f"{what}: {unknown_class(name)}")
            return None
        if name is None or position is None:
            return None
        yaw, motion = self._yaw(keys, name, what), self._motion(keys, name, what)
        return PlacedObject(name, *position, yaw, *motion) if yaw is not None and motion is not None else None

    def _motion(
        self, keys: dict[str, yaml.Node], name: str, what: str
    ) -> tuple[tuple[float, float], float] | None:
        """Its velocity in the arena's frame, and for how long."""
        if is_tag(name) and "velocity_mps" in keys:
            self._file.complain(keys["velocity_mps"], f"{what}: a tag hangs on its wall and does not move")
            return None
        velocity: list[float] | None = [0.0, 0.0]
        moves_s: float | None = math.inf
        if "velocity_mps" in keys:
            where = f"{what}'s velocity_mps"
            velocity = self._file.numbers(
                keys["velocity_mps"], where, ("x", "y"), VELOCITY_LIMITS_MPS, unit="m/s"
            )
        if "moves_s" in keys:
            moves_s = self._file.number(keys["moves_s"], f"{what}'s moves_s", "s", 0.0, TIME_LIMITS_S[1])
        return ((velocity[0], velocity[1]), moves_s) if velocity is not None and moves_s is not None else None

    def _yaw(self, keys: dict[str, yaml.Node], name: str, what: str) -> float | None:
        """Where a tag's face looks, which it must say and nothing else can."""
        if "yaw" not in keys:
            if is_tag(name):
                self._file.complain(keys["class"], f"{what}: a tag needs a yaw, where its face looks")
                return None
            return 0.0
        if not is_tag(name):
            self._file.complain(keys["yaw"], f"{what}: only a tag has a yaw; {name} is round")
            return None
        return self._file.number(keys["yaw"], f"{what}'s yaw", "rad", -2.0 * math.pi, 2.0 * math.pi)

    def _position(self, keys: dict[str, yaml.Node] | None, what: str) -> tuple[float, float] | None:
        if keys is None:
            return None
        x = self._file.number(keys["x"], f"{what}'s x", "m", *WORLD_LIMITS_M) if "x" in keys else None
        y = self._file.number(keys["y"], f"{what}'s y", "m", *WORLD_LIMITS_M) if "y" in keys else None
        return (x, y) if x is not None and y is not None else None

    def _decoys(self, node: yaml.Node) -> tuple[PlacedObject, ...]:
        nodes = self._file.sequence(node, "decoys") or []
        found = [self._object(f"decoys[{i}]", item, f"decoys[{i}]") for i, item in enumerate(nodes)]
        self._renumber("decoys", [item is not None for item in found])
        return tuple(item for item in found if item is not None)

    def _obstacles(self, node: yaml.Node) -> tuple[Obstacle, ...]:
        nodes = self._file.sequence(node, "obstacles") or []
        found = [self._obstacle(f"obstacles[{i}]", item) for i, item in enumerate(nodes)]
        self._renumber("obstacles", [item is not None for item in found])
        return tuple(item for item in found if item is not None)

    def _renumber(self, group: str, good: list[bool]) -> None:
        """The places of a group's good items, numbered without the bad ones, as the arena will have them."""
        kept = [i for i, is_good in enumerate(good) if is_good]
        nodes = [self._places.pop(f"{group}[{i}]") for i in range(len(good))]
        self._places.update({f"{group}[{new}]": nodes[old] for new, old in enumerate(kept)})
        self._numbers.update({f"{group}[{new}]": f"{group}[{old}]" for new, old in enumerate(kept)})

    def _numbered_as_in_file(self, message: str) -> str:
        return re.sub(r"\w+\[\d+\]", lambda name: self._numbers.get(name.group(), name.group()), message)

    def _obstacle(self, place: str, node: yaml.Node) -> Obstacle | None:
        self._places[place] = node
        keys = self._file.mapping(node, place, optional=tuple(_SHAPES))
        if keys is None:
            return None
        if len(keys) != 1:
            if keys or not node.value:
                self._file.complain(node, f"{place} must be one of {', '.join(_SHAPES)}")
            return None
        shape, value = next(iter(keys.items()))
        numbers = self._file.numbers(value, f"{place}: {shape}", _SHAPES[shape], WORLD_LIMITS_M)
        if numbers is None:
            return None
        if shape == "wall":
            if math.hypot(numbers[2] - numbers[0], numbers[3] - numbers[1]) < SIZE_LIMITS_M[0]:
                self._file.complain(
                    value, f"{place}: the wall begins and ends at ({numbers[0]:g}, {numbers[1]:g})"
                )
                return None
            return WallObstacle(*numbers)
        sizes = {"radius": numbers[2]} if shape == "circle" else {"length": numbers[2], "width": numbers[3]}
        small = {name: size for name, size in sizes.items() if size < SIZE_LIMITS_M[0]}
        for name, size in small.items():
            self._file.complain(
                value, f"{place}: {name} is {size:g} m; it must be at least {SIZE_LIMITS_M[0]:g} m"
            )
        if small:
            return None
        return CircleObstacle(*numbers) if shape == "circle" else BoxObstacle(*numbers)

    def _profile(self, node: yaml.Node) -> Config:
        self._places["profile"] = node
        config = self._config
        for key, (key_node, value_node) in (self._file.items(node, "profile") or {}).items():
            value = scalar(value_node)
            if value is None:
                self._file.complain(
                    value_node, f"profile: {key} is {describe(value_node)}; it must be one value"
                )
                continue
            try:
                config = config.override({key: value}, source="profile")
            except ConfigError as error:
                self._file.complain(key_node, str(error))
        return config

    def _level(self, keys: dict[str, yaml.Node]) -> int:
        level = self._file.number(keys["level"], "level", "1", *LEVEL_LIMITS) if "level" in keys else None
        return round(level or 0.0)

    def _expect(self, keys: dict[str, yaml.Node]) -> str:
        has_end = "target" in keys or "goal" in keys
        if "expect" not in keys:
            return ARRIVED if has_end else NOT_FOUND
        expect = self._file.text(keys["expect"], "expect")
        if expect is not None and expect not in ENDINGS:
            self._file.complain(keys["expect"], f"expect is {expect!r}; it must be {' or '.join(ENDINGS)}")
        elif expect == ARRIVED and not has_end:
            self._file.complain(
                keys["expect"], "expect is 'arrived', but there is no target and no goal; add one"
            )
        return expect or ARRIVED

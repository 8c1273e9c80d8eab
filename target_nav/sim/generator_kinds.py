"""The kinds of generated arenas, one function each: what it puts into a draft, and False when there was no room for it.

Levels 1 to 4 make rooms larger, gaps narrower, things more, and let the robot look anywhere at the start. Gaps are
for a body of 0.28 m.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from target_nav.sim.arena_types import BoxObstacle
from target_nav.sim.draft import WALL_THICKNESS_M, Draft, Place
from target_nav.sim.objects import OBJECTS

START_ROOM_M = 0.33
PIN_ROOM_M = 0.45
DOOR_M = ((0.90, 1.10), (0.70, 0.90), (0.55, 0.70), (0.45, 0.55))
CORRIDOR_M = ((0.90, 1.20), (0.75, 0.90), (0.60, 0.75), (0.50, 0.60))
NARROW_M = ((0.52, 0.60), (0.46, 0.52), (0.42, 0.46), (0.39, 0.42))
TOO_NARROW_M = (0.12, 0.24)
LIDAR_M = 0.20
"""Decoys are higher than the plane of the LiDAR: nothing on this robot sees a cup in time when it moves sideways."""
DECOYS = tuple(
    sorted(name for name, shape in OBJECTS.items() if name != "bowling_pin" and shape.height_m > LIDAR_M)
)


def open_floor(draft: Draft) -> bool:
    """Nothing but walls, robot and pin."""
    return _pin_anywhere(draft) and _robot_anywhere(draft, ((1.2, 2.5), (1.8, 3.5), (2.5, 5.0), (3.5, 9.0)))


def few_boxes(draft: Draft) -> bool:
    """Three to six things with room between them."""
    if not (_pin_anywhere(draft) and _robot_anywhere(draft)):
        return False
    draft.scatter(draft.level + 2, apart_m=0.35)
    return True


def clutter(draft: Draft) -> bool:
    """Things everywhere, of all sizes, as near to each other as may be; the pin stands among them."""
    room_m = (PIN_ROOM_M, 0.35, 0.25, 0.15)[draft.level - 1]
    area_m2 = 4.0 * draft.half_x_m * draft.half_y_m
    if not (draft.put_target(draft.place(room_m)) and _robot_anywhere(draft)):
        return False
    draft.scatter(
        round(area_m2 * draft.by_level((0.3, 0.4), (0.4, 0.5), (0.5, 0.6), (0.6, 0.75))), (0.1, 0.45)
    )
    return True


def doorway(draft: Draft) -> bool:
    """The pin is in the next room."""
    x = draft.between(-0.25, 0.25) * draft.half_x_m
    width = draft.by_level(*DOOR_M)
    middle = draft.between(-1.0, 1.0) * (draft.half_y_m - 0.5 * width - 0.2)
    draft.put_partition(x, [(middle - 0.5 * width, middle + 0.5 * width)])
    return _on_both_sides(draft, x, x, (x, middle)) and _some_boxes(draft)


def corridor(draft: Draft) -> bool:
    """Between the robot's part and the pin's lies a passage; from level 3 on it has a bend."""
    width = draft.by_level(*CORRIDOR_M)
    half_length = 0.5 * draft.by_level((0.8, 1.2), (1.0, 1.6), (1.4, 2.0), (1.8, 2.6))
    reach = draft.half_y_m - 0.5 * width - 0.15
    middle = draft.between(-0.8, 0.8) * reach
    if draft.level <= 2:
        _block(draft, -half_length, half_length, middle, width)
        exit_y = middle
    else:
        # two straight pieces, side by side, and a cross-piece as wide as they are
        sign = 1.0 if middle < 0.0 else -1.0
        exit_y = middle + sign * draft.between(width + 0.1, width + 1.0)
        if abs(exit_y) > reach:
            return False
        _block(draft, -half_length, -0.5 * width, middle, width)
        _block(draft, 0.5 * width, half_length, exit_y, width)
        low, high = min(middle, exit_y) - 0.5 * width, max(middle, exit_y) + 0.5 * width
        draft.put_box(0.0, 0.5 * (low - draft.half_y_m), width, low + draft.half_y_m)
        draft.put_box(0.0, 0.5 * (high + draft.half_y_m), width, draft.half_y_m - high)
    return _on_both_sides(draft, -half_length, half_length, (-half_length, middle))


def trap(draft: Draft) -> bool:
    """A U lies open between the robot and the pin; half of them have a slit that shows the pin but lets nobody through.

    At level 4 the robot stands inside.
    """
    half_width = 0.5 * draft.by_level((0.8, 1.0), (0.9, 1.3), (1.1, 1.6), (1.2, 1.8))
    depth = draft.by_level((0.4, 0.6), (0.6, 0.9), (0.8, 1.2), (1.0, 1.5))
    slit = draft.between(*TOO_NARROW_M) if draft.chance(0.5) else 0.0
    slit_y = draft.between(-0.5, 0.5) * (half_width - slit)
    back = draft.between(0.1, 0.5)
    draft.put_wall(back, -half_width, back, slit_y - 0.5 * slit)
    draft.put_wall(back, slit_y + 0.5 * slit, back, half_width)
    draft.put_wall(back - depth, half_width, back, half_width)
    draft.put_wall(back - depth, -half_width, back, -half_width)
    pin_y = (slit_y - 0.6, slit_y + 0.6)
    if not draft.put_target(draft.place(PIN_ROOM_M, x_m=(back + 0.5, draft.half_x_m), y_m=pin_y)):
        return False
    x_range = (back - depth, back) if draft.level == 4 else (-draft.half_x_m, back - depth - 0.3)
    y_range = (-half_width, half_width)
    return draft.put_robot(draft.place(START_ROOM_M, x_m=x_range, y_m=y_range))


def beside_wall(draft: Draft) -> bool:
    """The pin stands at a wall, from level 3 on in a corner of the room or of a wall and a box."""
    gap = draft.by_level((0.20, 0.30), (0.12, 0.20), (0.06, 0.12), (0.02, 0.06)) + 0.04
    across = draft.between(-0.8, 0.8)
    pin: Place = (draft.half_x_m - gap, across * draft.half_y_m)
    if draft.level >= 3:
        side_gap = draft.between(0.05, 0.35) + 0.04
        if draft.chance(0.5):
            pin = (pin[0], draft.half_y_m - side_gap)
        else:
            size = draft.between(0.2, 0.5)
            draft.put_box(draft.half_x_m - 0.5 * size, pin[1] + side_gap + 0.5 * size, size, size)
    turns = draft.count(0, 3)
    if not draft.put_target(pin):
        return False
    _turn_round(draft, turns)
    return _robot_anywhere(draft) and _some_boxes(draft)


def behind_box(draft: Draft) -> bool:
    """A box stands between the robot and the pin, near the pin; the pin may look out at one side."""
    if not draft.put_target(draft.place(0.55)):
        return False
    assert draft.target is not None
    pin = (draft.target.x_m, draft.target.y_m)
    robot = draft.place(START_ROOM_M, away_from=pin, away_m=(1.4, math.inf))
    if not draft.put_robot(robot) or robot is None:
        return False
    bearing = math.atan2(robot[1] - pin[1], robot[0] - pin[0])
    width = draft.by_level((0.20, 0.35), (0.30, 0.50), (0.40, 0.70), (0.60, 1.00))
    depth = draft.between(0.1, 0.4)
    off = 0.04 + draft.by_level((0.45, 0.60), (0.30, 0.50), (0.18, 0.40), (0.10, 0.30)) + 0.5 * depth
    aside = draft.between(-0.5, 0.5) * width
    x = pin[0] + off * math.cos(bearing) - aside * math.sin(bearing)
    y = pin[1] + off * math.sin(bearing) + aside * math.cos(bearing)
    draft.put_box(x, y, depth, width, bearing)
    return _some_boxes(draft)


def out_of_sight(draft: Draft) -> bool:
    """The pin is behind partitions or in a far corner, and the robot looks anywhere."""
    partitions = draft.count(1, 1 + (draft.level >= 3))
    for index in range(partitions):
        x = (-0.3 + 0.6 * index if partitions > 1 else draft.between(-0.2, 0.2)) * draft.half_x_m
        opening = draft.by_level((1.2, 2.0), (1.0, 1.6), (0.9, 1.4), (0.8, 1.2))
        at_top = draft.chance(0.5)
        gap = (
            (draft.half_y_m - opening, draft.half_y_m)
            if at_top
            else (-draft.half_y_m, opening - draft.half_y_m)
        )
        draft.put_partition(x, [gap])
    if not draft.put_target(draft.place(0.4, x_m=(0.3 * draft.half_x_m, draft.half_x_m))):
        return False
    x_range = (-draft.half_x_m, -0.35 * draft.half_x_m)
    if not draft.put_robot(draft.place(START_ROOM_M, x_m=x_range), look_at=(-2.0 * draft.half_x_m, 0.0)):
        return False
    draft.scatter(draft.level - 1, apart_m=0.4)
    return True


def decoys(draft: Draft) -> bool:
    """Bottles, vases, cones and the like, more of them than pins, some right beside it."""
    if not (_pin_anywhere(draft) and _robot_anywhere(draft)):
        return False
    draft.scatter_decoys(2 * draft.level, DECOYS)
    return _some_boxes(draft)


def no_pin(draft: Draft) -> bool:
    """Nothing to be found: boxes, and things that are none of it."""
    if not draft.put_robot(draft.place(START_ROOM_M)):
        return False
    draft.scatter(2 * draft.level, apart_m=0.1)
    draft.scatter_decoys(draft.level, DECOYS)
    return True


def narrow_gap(draft: Draft) -> bool:
    """A row of boxes across the room: one gap the robot just fits through, others that only look like it."""
    width = draft.by_level(*NARROW_M)
    x = draft.between(-0.2, 0.2) * draft.half_x_m
    true_y = draft.between(-1.0, 1.0) * (draft.half_y_m - 0.5 * width - 0.15)
    gaps = [(true_y - 0.5 * width, true_y + 0.5 * width)]
    for _ in range(draft.level):
        size = draft.between(*TOO_NARROW_M)
        low = draft.between(-draft.half_y_m + 0.1, draft.half_y_m - 0.1 - size)
        if all(low > other[1] + 0.15 or low + size < other[0] - 0.15 for other in gaps):
            gaps.append((low, low + size))
    draft.put_partition(x, sorted(gaps))
    return _on_both_sides(draft, x, x, (x, true_y))


KINDS: dict[str, Callable[[Draft], bool]] = {
    "open": open_floor,
    "few_boxes": few_boxes,
    "clutter": clutter,
    "doorway": doorway,
    "corridor": corridor,
    "trap": trap,
    "beside_wall": beside_wall,
    "behind_box": behind_box,
    "out_of_sight": out_of_sight,
    "decoys": decoys,
    "no_pin": no_pin,
    "narrow_gap": narrow_gap,
}


def _pin_anywhere(draft: Draft) -> bool:
    return draft.put_target(draft.place(PIN_ROOM_M))


def _robot_anywhere(
    draft: Draft,
    away_m: tuple[tuple[float, float], ...] = ((1.0, 3.0), (1.5, 4.0), (1.5, 6.0), (1.5, 9.0)),
) -> bool:
    """So far from the target, by level."""
    assert draft.target is not None
    pin = (draft.target.x_m, draft.target.y_m)
    return draft.put_robot(draft.place(START_ROOM_M, away_from=pin, away_m=away_m[draft.level - 1]))


def _on_both_sides(draft: Draft, left_x_m: float, right_x_m: float, look_at: Place) -> bool:
    """The robot to the left of a partition, the pin to the right."""
    half = 0.5 * WALL_THICKNESS_M
    if not draft.put_target(draft.place(0.35, x_m=(right_x_m + half, draft.half_x_m))):
        return False
    return draft.put_robot(draft.place(START_ROOM_M, x_m=(-draft.half_x_m, left_x_m - half)), look_at=look_at)


def _some_boxes(draft: Draft) -> bool:
    """From level 3 on there is something else in the room as well."""
    draft.scatter(max(draft.level - 2, 0) * draft.count(1, 2), apart_m=0.3)
    return True


def _block(draft: Draft, x0_m: float, x1_m: float, passage_y_m: float, width_m: float) -> None:
    """Solid from wall to wall between two x, but for a passage."""
    low, high = passage_y_m - 0.5 * width_m, passage_y_m + 0.5 * width_m
    middle, length = 0.5 * (x0_m + x1_m), x1_m - x0_m
    draft.put_box(middle, 0.5 * (low - draft.half_y_m), length, low + draft.half_y_m)
    draft.put_box(middle, 0.5 * (high + draft.half_y_m), length, draft.half_y_m - high)


def _turn_round(draft: Draft, quarters: int) -> None:
    """Turn all that is in the draft by so many quarters, room included."""
    for _ in range(quarters):
        draft.half_x_m, draft.half_y_m = draft.half_y_m, draft.half_x_m
        boxes = [o for o in draft.obstacles if isinstance(o, BoxObstacle)]
        draft.obstacles = []
        for box in boxes:
            draft.put_box(-box.y_m, box.x_m, box.width_m, box.length_m, box.yaw_rad)
        if draft.target is not None:
            draft.put_target((-draft.target.y_m, draft.target.x_m))

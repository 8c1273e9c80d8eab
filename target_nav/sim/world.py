"""The arena as segments and circles: ranges along many rays at once, and the exact clearance of the footprint.

Boxes are four segments, the bounds are four more, things are circles. What is seen depends on height: a ray at 0.18 m
passes over a cup.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from target_nav.sim.arena_checks import edges
from target_nav.sim.arena_types import Arena, CircleObstacle
from target_nav.sim.geometry import point_to_rectangle, point_to_segment, segment_to_rectangle
from target_nav.state.types import FloatArray
from target_nav.utils.bowling_pin import CLASS_NAME, width_at

_PARALLEL = 1e-12
_CORNER = 1e-9
"""Of a segment's length: rounding must not let a ray slip through between two segments that share a corner."""


_FEW_PAIRS = 4000
"""Fewer rays times circles than this are faster done all at once."""

IndexArray = NDArray[np.intp]


class RayCaster:
    """Ranges to the nearest of some segments, shape (S, 4) as x1 y1 x2 y2, and circles, shape (C, 3) as x y radius."""

    def __init__(self, segments: FloatArray, circles: FloatArray) -> None:
        x1, y1, x2, y2 = segments.T
        ex, ey = x2 - x1, y2 - y1
        # With a ray o + t d and a segment p + u e (Goldman, Graphics Gems I, 1990, p. 304):
        # t = (p - o) x e / (d x e), u = (p - o) x d / (d x e). Each product is a row times (ray's column).
        self._denominator = np.column_stack([ey, -ex])  # . (dx, dy)
        self._along_ray = np.column_stack([-ey, ex, x1 * ey - y1 * ex])  # . (ox, oy, 1)
        self._along_segment = np.column_stack([-y1, x1, -np.ones_like(x1)])  # . (dx, dy, o x d)
        self._cx, self._cy, self._radius2 = (
            circles[:, 0:1].copy(),
            circles[:, 1:2].copy(),
            circles[:, 2:3] ** 2,
        )
        self._work: dict[int, tuple[FloatArray, ...]] = {}

    def move_circle(self, index: int, x_m: float, y_m: float) -> None:
        self._cx[index, 0], self._cy[index, 0] = x_m, y_m

    def cast(self, ox: FloatArray, oy: FloatArray, dx: FloatArray, dy: FloatArray) -> FloatArray:
        """Ranges in metres, shape (B,), of rays from (ox, oy) along unit vectors (dx, dy), each of shape (B,).

        `inf` where a ray meets nothing, 0 where it begins inside of a circle.
        """
        beams = len(dx)
        work = self._work.get(beams)
        if work is None:
            shape = (len(self._denominator), beams)
            work = self._work[beams] = (
                np.empty(shape),
                np.empty(shape),
                np.empty(shape),
                np.ones((3, beams)),
            )
        denominator, t, u, columns = work
        with np.errstate(divide="ignore", invalid="ignore"):
            columns[0], columns[1] = dx, dy
            columns[2] = ox * dy - oy * dx
            np.matmul(self._denominator, columns[:2], out=denominator)
            np.matmul(self._along_segment, columns, out=u)
            columns[0], columns[1], columns[2] = ox, oy, 1.0
            np.matmul(self._along_ray, columns, out=t)
            # A ray along a segment divides by next to nothing: its t and u are then worth nothing either.
            denominator[np.abs(denominator) < _PARALLEL] = np.nan
            t /= denominator
            u /= denominator
            hit = (t >= 0.0) & (u >= -_CORNER) & (u <= 1.0 + _CORNER)
        ranges: FloatArray = np.where(hit, t, np.inf).min(axis=0, initial=np.inf)
        if len(self._cx):
            self._meet_circles(ranges, ox, oy, dx, dy)
        return ranges

    def _meet_circles(
        self, ranges: FloatArray, ox: FloatArray, oy: FloatArray, dx: FloatArray, dy: FloatArray
    ) -> None:
        """Shorten `ranges`. Of many rays only those are looked at that pass a circle near enough to meet it."""
        if len(dx) * len(self._cx) < _FEW_PAIRS:
            np.minimum(ranges, self._all_circles(ox, oy, dx, dy), out=ranges)
            return
        circle, ray = self._pairs(ox, oy, dx, dy)
        dx, dy = dx[ray], dy[ray]
        to_x, to_y = self._cx[circle, 0] - ox[ray], self._cy[circle, 0] - oy[ray]
        nearest = to_x * dx + to_y * dy
        off = to_x * dy - to_y * dx
        chord2 = self._radius2[circle, 0] - off * off
        meets = (chord2 >= 0.0) & (nearest >= 0.0)
        entry = np.maximum(nearest[meets] - np.sqrt(chord2[meets]), 0.0)
        np.minimum.at(ranges, ray[meets], entry)

    def _pairs(
        self, ox: FloatArray, oy: FloatArray, dx: FloatArray, dy: FloatArray
    ) -> tuple[IndexArray, IndexArray]:
        """Circles and rays that may meet, two indices a pair: by direction, seen from the middle of the origins."""
        x, y = 0.5 * (float(ox.min()) + float(ox.max())), 0.5 * (float(oy.min()) + float(oy.max()))
        spread = float(np.hypot(ox - x, oy - y).max())
        angles = np.arctan2(dy, dx)
        order = np.argsort(angles)
        angles = angles[order]
        angles = np.concatenate([angles - 2.0 * math.pi, angles, angles + 2.0 * math.pi])
        to_x, to_y = self._cx[:, 0] - x, self._cy[:, 0] - y
        distance = np.hypot(to_x, to_y)
        wide = np.sqrt(self._radius2[:, 0]) + spread
        # all round where an origin may lie inside
        with np.errstate(divide="ignore", invalid="ignore"):
            half = np.where(distance > wide, np.arcsin(np.minimum(wide / distance, 1.0)), math.pi)
        half += _CORNER
        bearing = np.arctan2(to_y, to_x)
        first = np.searchsorted(angles, bearing - half)
        count = np.searchsorted(angles, bearing + half, side="right") - first
        np.minimum(count, len(order), out=count)
        circle = np.repeat(np.arange(len(count)), count)
        within = np.arange(int(count.sum())) - np.repeat(np.cumsum(count) - count, count)
        return circle, order[(first[circle] + within) % len(order)]

    def _all_circles(self, ox: FloatArray, oy: FloatArray, dx: FloatArray, dy: FloatArray) -> FloatArray:
        to_x, to_y = self._cx - ox, self._cy - oy
        nearest = to_x * dx + to_y * dy
        off2 = to_x * dy - to_y * dx
        off2 *= off2
        chord2 = self._radius2 - off2
        meets = (chord2 >= 0.0) & (nearest >= 0.0)
        np.maximum(chord2, 0.0, out=chord2)
        entry = np.maximum(nearest - np.sqrt(chord2), 0.0)
        return np.where(meets, entry, np.inf).min(axis=0)


class World:
    """An arena, prepared for questions."""

    def __init__(self, arena: Arena) -> None:
        body = arena.config.robot
        self._half_x = 0.5 * (body.front_m + body.rear_m)
        self._half_y = body.half_width_m
        self._shift = 0.5 * (body.front_m - body.rear_m)
        self._reach = body.circumscribed_radius_m
        self.segments = _segments(arena)
        circles = [(o.x_m, o.y_m, o.radius_m) for o in arena.obstacles if isinstance(o, CircleObstacle)]
        solid = [o for o in arena.objects if not o.is_tag]
        things = [(o.x_m, o.y_m, o.shape.radius_m) for o in solid]
        self._heights = [math.inf] * len(circles) + [o.shape.height_m for o in solid]
        self._pins = [False] * len(circles) + [o.class_name == CLASS_NAME for o in solid]
        self.circles = np.array(circles + things, dtype=np.float64).reshape(-1, 3)
        self._target_index = len(circles) if arena.target is not None and not arena.target.is_tag else None
        """A tag is flat: it is no circle that anything could meet, or that could move."""
        self._casters: list[tuple[RayCaster, int]] = []
        """Those that see the target, and which of their circles it is."""
        self._segment_list = [tuple(row) for row in self.segments.tolist()]
        self._circle_list = [tuple(row) for row in self.circles.tolist()]
        x1, y1, x2, y2 = self.segments.T
        self._x1, self._y1, self._ex, self._ey = (np.ascontiguousarray(v) for v in (x1, y1, x2 - x1, y2 - y1))
        self._inverse_length2 = 1.0 / (self._ex**2 + self._ey**2)
        self._cx, self._cy, self._cr = (np.ascontiguousarray(v) for v in self.circles.T)

    def ray_caster(self, height_m: float, true_profile: bool = False) -> RayCaster:
        """What level rays at this height meet. `true_profile`: pins are as thin as they are there."""
        seen = [height > height_m for height in self._heights]
        circles = self.circles.copy()
        if true_profile:
            circles[:, 2] *= [
                _share_at(height_m, height, is_pin) for height, is_pin in zip(self._heights, self._pins)
            ]
        caster = RayCaster(self.segments, circles[seen])
        if self._target_index is not None and seen[self._target_index]:
            self._casters.append((caster, sum(seen[: self._target_index])))
        return caster

    def move_target(self, x_m: float, y_m: float) -> None:
        """The target is there now, for clearances and for every ray."""
        assert self._target_index is not None, "there is no target that could move"
        index = self._target_index
        self._cx[index], self._cy[index] = x_m, y_m
        self.circles[index, :2] = x_m, y_m
        self._circle_list[index] = (x_m, y_m, self._circle_list[index][2])
        for caster, own in self._casters:
            caster.move_circle(own, x_m, y_m)

    def room_round_target_m(self, x_m: float, y_m: float) -> float:
        """From the target's surface, were it there, to the nearest wall, obstacle or decoy."""
        assert self._target_index is not None, "there is no target that could move"
        index = self._target_index
        to_walls = min(point_to_segment(x_m, y_m, *segment) for segment in self._segment_list)
        others = (c for i, c in enumerate(self._circle_list) if i != index)
        to_things = min((math.hypot(c[0] - x_m, c[1] - y_m) - c[2] for c in others), default=math.inf)
        return float(min(to_walls, to_things)) - self._circle_list[index][2]

    def clearance_m(self, x_m: float, y_m: float, yaw_rad: float) -> float:
        """From the footprint, a rectangle, to the nearest of everything; 0 when it touches.

        A lower bound for each part (its distance to base_link less the footprint's farthest corner) puts the parts in
        order, so the exact distance is worked out for the few nearest only.
        """
        px, py = x_m - self._x1, y_m - self._y1
        along = (px * self._ex + py * self._ey) * self._inverse_length2
        np.clip(along, 0.0, 1.0, out=along)
        px -= along * self._ex
        py -= along * self._ey
        bounds = np.concatenate([np.hypot(px, py), np.hypot(x_m - self._cx, y_m - self._cy) - self._cr])
        bounds -= self._reach
        best = math.inf
        c, s = math.cos(yaw_rad), math.sin(yaw_rad)
        segments = len(self._segment_list)
        for index in np.argsort(bounds).tolist():
            if bounds[index] >= best:
                break
            if index < segments:
                ax, ay, bx, by = self._segment_list[index]
                ax, ay, bx, by = ax - x_m, ay - y_m, bx - x_m, by - y_m
                gap = segment_to_rectangle(
                    c * ax + s * ay - self._shift,
                    c * ay - s * ax,
                    c * bx + s * by - self._shift,
                    c * by - s * bx,
                    self._half_x,
                    self._half_y,
                )
            else:
                cx, cy, radius = self._circle_list[index - segments]
                cx, cy = cx - x_m, cy - y_m
                gap = point_to_rectangle(
                    c * cx + s * cy - self._shift, c * cy - s * cx, self._half_x, self._half_y
                )
                gap = max(gap - radius, 0.0)
            best = gap if gap < best else best
        return best


def _share_at(height_m: float, own_height_m: float, is_pin: bool) -> float:
    """Width at a height, of the largest."""
    return float(width_at(np.array([height_m / own_height_m]))[0]) if is_pin else 1.0


def _segments(arena: Arena) -> FloatArray:
    """Bounds, boxes and walls, shape (S, 4)."""
    x0, y0, x1, y1 = arena.bounds
    rows = [(x0, y0, x1, y0), (x1, y0, x1, y1), (x1, y1, x0, y1), (x0, y1, x0, y0)]
    for obstacle in arena.obstacles:
        rows += [(ax, ay, bx, by) for (ax, ay), (bx, by) in edges(obstacle)]
    return np.array(rows, dtype=np.float64)

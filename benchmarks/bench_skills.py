"""What one tick of each skill and of the limiter costs with 300 obstacle points, and the route planner beside peers.

The skills drive an ideal robot through a room of boxes at 20 Hz, so planning, searching and steering all take their
turns. CPU time of the thread, so that what else runs on the machine counts little.
"""

from __future__ import annotations

import heapq
import math
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from benchmarks import OURS, Row, time_call
from target_nav.config import Config
from target_nav.nav.arrival import ConfirmArrival
from target_nav.nav.blind_approach import BlindApproach
from target_nav.nav.limiter import VelocityLimiter
from target_nav.nav.navigate import NavigateToTarget
from target_nav.nav.route import RoutePlanner
from target_nav.nav.route_grid import CELL_M
from target_nav.nav.skill import Skill, SkillStatus, View
from target_nav.nav.spiral_search import SpiralSearch
from target_nav.nav.turn_search import TurnSearch
from target_nav.state.types import STOP, FloatArray, MotionRequest, NavState, Pose2D, Track, Twist2D
from target_nav.utils.frames import compose, points_to_child, to_child

POINTS = 300
TICKS = 600
TICK_S = 0.05
TARGET_M = (2.0, 0.3)
BOXES = ((0.6, 0.1, 0.4, 0.5), (-0.4, 1.0, 0.5, 0.3), (1.3, -0.7, 0.3, 0.6), (0.2, -1.2, 0.6, 0.3))
CONFIG = Config()
CostGrid = NDArray[np.uint8]


def room() -> FloatArray:
    """Points in odom on the outlines of a room and of the boxes in it, shape (POINTS, 2)."""
    outlines = [(0.5, 0.0, 5.0, 5.0), *BOXES]
    sides = []
    for x, y, length, width in outlines:
        a, b, c, d = x - length / 2, x + length / 2, y - width / 2, y + width / 2
        sides += [(a, c, b, c), (b, c, b, d), (b, d, a, d), (a, d, a, c)]
    lengths = np.array([math.hypot(x2 - x1, y2 - y1) for x1, y1, x2, y2 in sides])
    counts = np.maximum(np.round(POINTS * lengths / lengths.sum()).astype(int), 2)
    points = [
        (x1 + (x2 - x1) * share, y1 + (y2 - y1) * share)
        for (x1, y1, x2, y2), count in zip(sides, counts.tolist())
        for share in np.linspace(0.0, 1.0, count, endpoint=False).tolist()
    ]
    return np.array(points)[:POINTS]


def track_from(now_s: float, pose: Pose2D) -> Track:
    x, y = to_child(pose, *TARGET_M)
    return Track(
        now_s,
        *TARGET_M,
        (1e-4, 0.0, 0.0, 1e-4),
        True,
        20,
        now_s - 0.1,
        now_s - 0.1,
        math.hypot(x, y),
        math.atan2(y, x),
    )


def tick_times(
    make: Callable[[], Skill], start: Pose2D, points_in_odom: FloatArray, tracked: bool
) -> tuple[float, float]:
    """Median and 99th percentile of one step in milliseconds, over TICKS ticks; a skill that ends begins anew."""
    times: list[float] = []
    skill, pose, twist, now_s = make(), start, STOP, 100.0
    begun = False
    while len(times) < TICKS:
        track = track_from(now_s, pose) if tracked else None
        view = View(now_s, TICK_S, pose, twist, track, points_to_child(pose, points_in_odom), None)
        if not begun:
            skill.start(view)
            begun = True
        begin_s = time.thread_time()
        step = skill.step(view)
        times.append(time.thread_time() - begin_s)
        if step.status is not SkillStatus.RUNNING:
            skill, pose, twist, begun = make(), start, STOP, False
        else:
            twist = step.twist
            moved = Pose2D(twist.vx_mps * TICK_S, twist.vy_mps * TICK_S, twist.wz_radps * TICK_S)
            pose = compose(pose, moved)
        now_s += TICK_S
    return 1e3 * float(np.median(times)), 1e3 * float(np.quantile(times, 0.99))


def skill_rows(points: FloatArray) -> list[Row]:
    far, near = Pose2D(-1.4, -0.2, 0.1), Pose2D(TARGET_M[0], TARGET_M[1] + 0.8, -math.pi / 2)
    there = Pose2D(TARGET_M[0], TARGET_M[1] + 0.29, -math.pi / 2)
    clear_of_target = points[np.hypot(points[:, 0] - TARGET_M[0], points[:, 1] - TARGET_M[1]) > 0.1]
    cases: tuple[tuple[str, Callable[[], Skill], Pose2D, bool], ...] = (
        (
            "NavigateToTarget",
            lambda: NavigateToTarget(CONFIG, cruise_speed_mps=0.15, until_range_m=0.8, lost_after_s=3.0),
            far,
            True,
        ),
        ("TurnSearch", lambda: TurnSearch(CONFIG, time_limit_s=30.0, yaw_rate_radps=0.5), far, False),
        (
            "SpiralSearch",
            lambda: SpiralSearch(CONFIG, time_limit_s=90.0, radius_m=4.0, spacing_m=0.8, speed_mps=0.2),
            far,
            False,
        ),
        (
            "BlindApproach",
            lambda: BlindApproach(
                CONFIG, stand_off_m=0.1, speed_mps=0.1, timeout_s=15.0, target_radius_m=0.04
            ),
            near,
            True,
        ),
        (
            "ConfirmArrival",
            lambda: ConfirmArrival(
                CONFIG, stand_off_m=0.1, confirm_s=0.3, target_radius_m=0.04, timeout_s=3.0
            ),
            there,
            True,
        ),
    )
    rows = []
    for name, make, start, tracked in cases:
        median_ms, p99_ms = tick_times(make, start, clear_of_target, tracked)
        rows.append(Row(f"{name}: one tick, median", OURS, median_ms, "ms"))
        rows.append(Row(f"{name}: one tick, p99", OURS, p99_ms, "ms"))
    return rows


def limiter_row(points: FloatArray) -> Row:
    limiter = VelocityLimiter(CONFIG)
    request = MotionRequest("bench", NavState.NAVIGATING, Twist2D(0.15, 0.05, 0.2))
    in_base = points_to_child(Pose2D(0.1, 0.0, 0.0), points)

    def limit() -> None:
        limiter.limit(
            request,
            dt_s=TICK_S,
            scan_age_s=0.1,
            odom_age_s=0.0,
            camera_age_s=0.1,
            obstacles_in_base_m=in_base,
            target_in_base=(1.0, 0.0),
            measured=request.twist,
        )

    return Row("VelocityLimiter: one tick", OURS, 1e3 * time_call(limit), "ms")


def plan_rows(points: FloatArray) -> list[Row]:
    """One plan from the far side of the room, beside two other ways to solve the same grid."""
    planner = RoutePlanner(CONFIG)
    start, goal = (-1.4, -0.2), np.array([[1.3, 0.3, 0.0]])

    def plan() -> None:
        planner.reset()
        assert planner.plan(points, start, goal, 15.0) is not None

    grid = planner.cost_grid(points, start)
    side = grid.shape[0]
    column, row = (round((goal[0, axis] - start[axis]) / CELL_M) + side // 2 for axis in (0, 1))
    source, target = (side // 2, side // 2), (row, column)
    task = "route over 161 x 161 cells"
    return [
        Row(
            task,
            OURS,
            1e3 * time_call(plan),
            "ms",
            "with rasterising, clearance classes and the straight legs",
        ),
        Row(task, "A*, heapq", 1e3 * time_call(lambda: astar(grid, source, target)), "ms", "search alone"),
        Row(
            task,
            "scipy dijkstra",
            1e3 * time_call(lambda: scipy_dijkstra(grid, source)),
            "ms",
            "search alone",
        ),
    ]


def astar(grid: CostGrid, source: tuple[int, int], target: tuple[int, int]) -> float:
    """The textbook's: eight neighbours, octile distance as heuristic."""
    costs = grid.tolist()
    steps = [(dr, dc, math.hypot(dr, dc)) for dr in (-1, 0, 1) for dc in (-1, 0, 1) if dr or dc]
    best = {source: 0.0}
    queue = [(0.0, source)]
    done = set()
    while queue:
        _, cell = heapq.heappop(queue)
        if cell == target:
            return best[cell]
        if cell in done:
            continue
        done.add(cell)
        for dr, dc, length in steps:
            r, c = cell[0] + dr, cell[1] + dc
            charge = costs[r][c]
            if not charge:
                continue
            cost = best[cell] + charge * length
            if cost < best.get((r, c), math.inf):
                best[(r, c)] = cost
                across, down = abs(r - target[0]), abs(c - target[1])
                ahead = max(across, down) + 0.4142 * min(across, down)
                heapq.heappush(queue, (cost + ahead, (r, c)))
    return math.inf


def scipy_dijkstra(grid: CostGrid, source: tuple[int, int]) -> FloatArray:
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import dijkstra

    side = grid.shape[0]
    cells = np.arange(side * side).reshape(side, side)
    heads, tails, costs = [], [], []
    for dr, dc in ((0, 1), (1, 0), (1, 1), (1, -1)):
        a = cells[: side - dr, max(-dc, 0) : side - max(dc, 0)]
        b = cells[dr:, max(dc, 0) : side + min(dc, 0)]
        charge = grid.reshape(-1)
        ok = (charge[a] > 0) & (charge[b] > 0)
        heads.append(a[ok])
        tails.append(b[ok])
        costs.append(math.hypot(dr, dc) * 0.5 * (charge[a][ok] + charge[b][ok]))
    graph = csr_matrix(
        (np.concatenate(costs), (np.concatenate(heads), np.concatenate(tails))), (side**2, side**2)
    )
    distances: FloatArray = dijkstra(graph, directed=False, indices=source[0] * side + source[1])
    return distances


def run() -> list[Row]:
    points = room()
    return [*skill_rows(points), limiter_row(points), *plan_rows(points)]

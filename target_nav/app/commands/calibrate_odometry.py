"""`target-nav calibrate odometry`: drives a way, a strafe, turns and a square; finds what the wheels' counts are worth.

A person measures what was really driven; in the simulator its truth does, so that the whole procedure can be tested.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Protocol

import click
from rich.table import Table

from target_nav.app.calibration_drive import Driven, Driver, Drivetrain, SerialDrivetrain, SimDrivetrain
from target_nav.app.robot_ports import arduino_port
from target_nav.app.settings import load_config, update_config
from target_nav.app.terminal import table_console
from target_nav.config import Config
from target_nav.nav.odometry import OdometryScale
from target_nav.nav.odometry_calibration import Axis, Leg, Measured, calibrated, square
from target_nav.sim.arena import load_arena

DEFAULT_CONFIG = Path("robot.yaml")
"""Never what a simulator says without being told to: its scales are of no robot."""

SPEED_MPS = 0.15
YAW_RATE_RADPS = 0.5


class Judge(Protocol):
    """Who knows what was really driven."""

    def ready(self, text: str) -> None:
        """Before the wheels turn."""

    def way_m(self, sideways: bool) -> float:
        """How far it went since it was ready, as the crow flies."""

    def turned_rad(self, turns: int, left: bool) -> float:
        """How far it turned since it was ready, without sign."""

    def closing_m(self) -> tuple[float, float] | None:
        """Where the square ended: forward and left of its begin, in the robot's first frame; None: not measured."""


class Person:
    """Asks for what was measured on the floor."""

    def ready(self, text: str) -> None:
        click.echo(f"\n{text}")
        click.prompt("Mark the floor under the robot; Enter drives, Ctrl-C stops", "", show_default=False)

    def way_m(self, sideways: bool) -> float:
        where = "to the left" if sideways else "forward"
        return float(click.prompt(f"How far did it go {where}, mark to mark, in metres", type=float))

    def turned_rad(self, turns: int, left: bool) -> float:
        text = f"It was to turn {turns} times. How many degrees beyond that (negative: short of it)"
        return 2.0 * math.pi * turns + math.radians(float(click.prompt(text, type=float)))

    def closing_m(self) -> tuple[float, float] | None:
        text = "How far from its begin did it end: metres forward, metres to the left (Enter: not measured)"
        answer = str(click.prompt(text, "", show_default=False)).replace(",", " ").split()
        return (float(answer[0]), float(answer[1])) if len(answer) == 2 else None


class Truth:
    """The simulator's."""

    def __init__(self, drivetrain: SimDrivetrain) -> None:
        self._drivetrain = drivetrain
        self._begin = drivetrain.true_pose

    def ready(self, text: str) -> None:
        self._begin = self._drivetrain.true_pose

    def way_m(self, sideways: bool) -> float:
        return math.hypot(*self._moved())

    def turned_rad(self, turns: int, left: bool) -> float:
        return abs(self._drivetrain.true_pose.yaw_rad - self._begin.yaw_rad)

    def closing_m(self) -> tuple[float, float] | None:
        dx, dy = self._moved()
        c, s = math.cos(self._begin.yaw_rad), math.sin(self._begin.yaw_rad)
        return c * dx + s * dy, c * dy - s * dx

    def _moved(self) -> tuple[float, float]:
        end = self._drivetrain.true_pose
        return end.x_m - self._begin.x_m, end.y_m - self._begin.y_m


@dataclass(frozen=True)
class Plan:
    """How much to drive of each; 0: leave it out."""

    distance_m: float
    strafe_m: float
    turns: int
    square_m: float


@click.command(name="odometry")
@click.option(
    "--config",
    "config_path",
    type=click.Path(dir_okay=False, path_type=Path),
    help="The robot's configuration: read if it is there, and written. Default: robot.yaml, with --sim none.",
)
@click.option("--port", help="Serial port of the Arduino; else key serial.port.")
@click.option(
    "--distance", default=2.0, show_default=True, type=click.FloatRange(0.0, 10.0), help="Forward, m."
)
@click.option(
    "--strafe", default=1.0, show_default=True, type=click.FloatRange(0.0, 10.0), help="To the left, m."
)
@click.option(
    "--turns", default=3, show_default=True, type=click.IntRange(0, 20), help="On the spot, each way."
)
@click.option(
    "--square", "square_m", default=2.0, show_default=True, type=click.FloatRange(0.0, 10.0),
    help="Side of the square that proves the result, m.",
)  # fmt: skip
@click.option(
    "--sim", "arena_name", metavar="ARENA", help="In the simulator, in virtual time; its truth measures."
)
@click.option(
    "--seed", default=1, show_default=True, type=click.IntRange(0), help="Of all that is random there."
)
@click.option("--dry-run", is_flag=True, help="Measure, and write nothing.")
def command(
    config_path: Path | None,
    port: str | None,
    distance: float,
    strafe: float,
    turns: int,
    square_m: float,
    arena_name: str | None,
    seed: int,
    dry_run: bool,
) -> None:
    """Find the scales of the wheels' odometry (keys odometry.forward_scale, lateral_scale, yaw_scale).

    The robot drives forward and back, to the left and back, turns on the spot both ways, and at last a square with the
    scales it has found. It needs the stack stopped, 0.5 m of free floor round all that, and a tape measure. Nobody
    looks out for obstacles meanwhile. 0 leaves a part out.
    """
    if config_path is None and arena_name is None:
        config_path = DEFAULT_CONFIG
    config = load_config(config_path) if config_path is not None and config_path.exists() else Config()
    if config.robot.drive != "mecanum":
        strafe = 0.0
    with _opened(config, port, arena_name, seed) as (config, drivetrain, judge):
        scale = _measure(Plan(distance, strafe, turns, square_m), config, drivetrain, judge)
        if dry_run or config_path is None:
            click.echo("nothing written")
        else:
            note = f"measured {date.today().isoformat()}" + (
                f" in simulator {arena_name}" if arena_name else ""
            )
            update_config(config_path, _keys(scale), note)
            click.echo(f"written to {config_path}")
        if square_m:
            _prove(square_m, scale, config, drivetrain, judge)


@contextlib.contextmanager
def _opened(
    config: Config, port: str | None, arena_name: str | None, seed: int
) -> Iterator[tuple[Config, Drivetrain, Judge]]:
    if arena_name is not None:
        arena = load_arena(arena_name, config)
        simulated = SimDrivetrain(arena, seed)
        yield arena.config, simulated, Truth(simulated)
        return
    with contextlib.closing(SerialDrivetrain(port or arduino_port(config), config.serial.baud)) as drivetrain:
        yield config, drivetrain, Person()


def _measure(plan: Plan, config: Config, drivetrain: Drivetrain, judge: Judge) -> OdometryScale:
    driver = Driver(drivetrain, config, OdometryScale())
    forward = lateral = yaw = None
    if plan.distance_m:
        forward = _way(driver, judge, Leg(Axis.FORWARD, plan.distance_m, SPEED_MPS))
    if plan.strafe_m:
        lateral = _way(driver, judge, Leg(Axis.LEFT, plan.strafe_m, SPEED_MPS))
    if plan.turns:
        left = _turn(driver, judge, plan.turns, left=True)
        yaw = left.plus(_turn(driver, judge, plan.turns, left=False))
    old = config.odometry
    before = OdometryScale(old.forward_scale, old.lateral_scale, old.yaw_scale)
    scale = calibrated(forward, lateral, yaw, before)
    table = Table(title="odometry")
    for column in ("", "reported", "measured", "scale before", "scale now"):
        table.add_column(column)
    rows = (
        ("forward", forward, "m", before.forward, scale.forward),
        ("sideways", lateral, "m", before.lateral, scale.lateral),
        ("turning", yaw, "rad", before.yaw, scale.yaw),
    )
    for name, measured, unit, was, now in rows:
        seen = (f"{measured.reported:.3f} {unit}", f"{measured.true:.3f} {unit}") if measured else ("-", "-")
        table.add_row(name, *seen, f"{was:.4f}", f"{now:.4f}")
    table_console().print(table)
    return scale


def _way(driver: Driver, judge: Judge, leg: Leg) -> Measured:
    sideways = leg.axis is Axis.LEFT
    judge.ready(
        f"{leg.amount:g} m {'to the left' if sideways else 'forward'}, and back after it was measured."
    )
    driven = driver.drive([leg])
    measured = Measured(_way_m(driven), judge.way_m(sideways))
    driver.drive([Leg(leg.axis, -leg.amount, leg.speed)])
    return measured


def _turn(driver: Driver, judge: Judge, turns: int, left: bool) -> Measured:
    sign = 1.0 if left else -1.0
    judge.ready(f"{turns} whole turns {'to the left' if left else 'to the right'}, on the spot.")
    driven = driver.drive([Leg(Axis.TURN, sign * 2.0 * math.pi * turns, YAW_RATE_RADPS)])
    return Measured(abs(driven.end.yaw_rad - driven.start.yaw_rad), judge.turned_rad(turns, left))


def _prove(side_m: float, scale: OdometryScale, config: Config, drivetrain: Drivetrain, judge: Judge) -> None:
    judge.ready(f"A square of {side_m:g} m, counter-clockwise, with the new scales.")
    driven = Driver(drivetrain, config, scale).drive(square(side_m, SPEED_MPS, YAW_RATE_RADPS))
    x_m, y_m = driven.end.x_m - driven.start.x_m, driven.end.y_m - driven.start.y_m
    click.echo(f"square: odometry says it ended {x_m:+.3f} m forward and {y_m:+.3f} m left of its begin")
    true = judge.closing_m()
    if true is not None:
        off_m = math.hypot(true[0] - x_m, true[1] - y_m)
        click.echo(
            f"square: it really ended {true[0]:+.3f} m forward and {true[1]:+.3f} m left; odometry is off by "
            f"{off_m:.3f} m after {4 * side_m:g} m"
        )


def _way_m(driven: Driven) -> float:
    return math.hypot(driven.end.x_m - driven.start.x_m, driven.end.y_m - driven.start.y_m)


def _keys(scale: OdometryScale) -> dict[str, float]:
    return {
        "odometry.forward_scale": round(scale.forward, 5),
        "odometry.lateral_scale": round(scale.lateral, 5),
        "odometry.yaw_scale": round(scale.yaw, 5),
    }

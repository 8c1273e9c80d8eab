"""`target-nav calibrate odometry` as a whole: a plant with known errors is measured, and the file gets its scales."""

from __future__ import annotations

import math
import re
import threading
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from target_nav.app.arduino_sim import ArduinoSim
from target_nav.app.calibration_drive import Driver, SimDrivetrain
from target_nav.app.commands.calibrate import command
from target_nav.app.settings import load_config
from target_nav.config import Config
from target_nav.errors import DeviceError
from target_nav.nav.odometry import OdometryScale
from target_nav.nav.odometry_calibration import Axis, Leg, square
from target_nav.sim.arena import Arena, Bounds, load_arena
from target_nav.sim.simulation import Simulation
from target_nav.sim.wheels import Base
from target_nav.state.types import Pose2D
from tests.utils.processes import wait_until

LATERAL_ERROR = 0.05
SIDE_M = 2.0


def calibrate(*options: str, answers: str = "") -> Result:
    return CliRunner().invoke(command, ["odometry", *options], input=answers)


def config_file(folder: Path, text: str = "") -> Path:
    path = folder / "robot.yaml"
    path.write_text(text)
    return path


def scale_of(path: Path) -> OdometryScale:
    odometry = load_config(path).odometry
    return OdometryScale(odometry.forward_scale, odometry.lateral_scale, odometry.yaw_scale)


@pytest.mark.parametrize("seed", [11, 12, 13])
def test_a_plants_errors_are_found(tmp_path: Path, seed: int) -> None:
    path = config_file(
        tmp_path, f"drive_sim.lateral_over_report: {LATERAL_ERROR}\ndrive_sim.slip_rate_per_m: 0\n"
    )
    plant = Simulation(load_arena("open_floor", load_config(path)), seed).drive
    result = calibrate("--config", str(path), "--sim", "open_floor", "--seed", str(seed))
    assert result.exit_code == 0, result.output
    found = scale_of(path)
    assert plant.lateral_scale < 0.97  # drawn around 5 %
    assert found.lateral == pytest.approx(plant.lateral_scale, abs=0.001)
    assert found.forward == pytest.approx(plant.forward_scale, abs=0.001)
    assert found.yaw == pytest.approx(1.0, abs=0.002)


def test_the_rest_of_the_file_stays_and_a_second_time_finds_the_same(tmp_path: Path) -> None:
    text = "# my robot\nlidar.rate_hz: 7.0  # faster motor\nodometry.lateral_scale: 0.8\n"
    path = config_file(tmp_path, text)
    options = ("--config", str(path), "--sim", "open_floor", "--square", "0")
    assert calibrate(*options).exit_code == 0
    first = path.read_text()
    assert first.startswith("# my robot\nlidar.rate_hz: 7.0  # faster motor\nodometry.lateral_scale: 0.9")
    assert len(re.findall(r"^odometry\.", first, re.MULTILINE)) == 3
    assert calibrate(*options).exit_code == 0

    def without_notes(text: str) -> str:
        return re.sub("  # measured .*", "", text)  # the day may have changed meanwhile

    assert without_notes(path.read_text()) == without_notes(first)


def test_parts_can_be_left_out_and_nothing_need_be_written(tmp_path: Path) -> None:
    path = config_file(tmp_path, "odometry.yaw_scale: 1.02\n")
    result = calibrate(
        "--config", str(path), "--sim", "open_floor", "--turns", "0", "--square", "0", "--dry-run"
    )
    assert result.exit_code == 0
    assert "nothing written" in result.output
    assert path.read_text() == "odometry.yaw_scale: 1.02\n"
    assert re.search(r"turning .* - .* 1\.0200 .* 1\.0200", result.output)


def test_a_simulators_scales_are_not_written_unasked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    result = calibrate("--sim", "open_floor", "--strafe", "0", "--turns", "0", "--square", "0")
    assert result.exit_code == 0
    assert "nothing written" in result.output
    assert list(tmp_path.iterdir()) == []


def test_a_robot_that_hits_something_says_so(tmp_path: Path) -> None:
    result = calibrate("--config", str(tmp_path / "new.yaml"), "--sim", "open_floor", "--distance", "6")
    assert isinstance(result.exception, DeviceError)
    assert "touched something" in str(result.exception)
    assert not (tmp_path / "new.yaml").exists()


# --- a square: the whole way from a twist to wheel speeds, motors, encoders, ODOM and a pose ---


def hall(**drive_sim: float) -> Arena:
    values = {f"drive_sim.{key}": value for key, value in drive_sim.items()}
    return Arena("hall", Bounds(-20, -20, 20, 20), Pose2D(), config=Config().override(values))


def closing_error(arena: Arena, seed: int) -> tuple[float, SimDrivetrain]:
    """How far odometry is off after a square of 2 m, in metres, with the plant's own scales."""
    drivetrain = SimDrivetrain(arena, seed)
    plant = drivetrain.simulation.drive
    scale = OdometryScale(plant.forward_scale, plant.lateral_scale, 1.0)
    driven = Driver(drivetrain, arena.config, scale).drive(square(SIDE_M, 0.15, 0.5))
    assert math.hypot(driven.end.x_m, driven.end.y_m) < 0.02  # odometry itself closes it
    end = drivetrain.true_pose
    return math.hypot(end.x_m - driven.end.x_m, end.y_m - driven.end.y_m), drivetrain


def drift_error_m(drift_rad_per_m: float, config: Config) -> float:
    """What a drift of the heading makes of a square's end, to first order.

    The mean heading error of side k is drift * (k * (side + corner) + side / 2): opposite sides do not cancel, and
    what is left of both pairs is at right angles.
    """
    corner_m = Base.of(config.robot).lever_m * 0.5 * math.pi
    return abs(drift_rad_per_m) * math.sqrt(2.0) * SIDE_M * 2.0 * (SIDE_M + corner_m)


@pytest.mark.parametrize("seed", [21, 22, 23])
def test_a_square_closes_when_the_plant_does_not_drift(seed: int) -> None:
    arena = hall(heading_drift_rad_per_m=0.0, slip_rate_per_m=0.0)
    error_m, _ = closing_error(arena, seed)
    assert error_m < 0.005


@pytest.mark.parametrize("seed", [21, 22, 23])
def test_a_square_closes_within_the_plants_drift_and_no_more(seed: int) -> None:
    arena = hall(slip_rate_per_m=0.0)
    error_m, drivetrain = closing_error(arena, seed)
    expected_m = drift_error_m(drivetrain.simulation.drive.drift_rad_per_m, arena.config)
    assert 0.05 < expected_m < 0.15
    print(
        f"seed {seed}: odometry off by {1e3 * error_m:.1f} mm, the drift's share is {1e3 * expected_m:.1f} mm"
    )
    assert error_m == pytest.approx(expected_m, abs=0.005)


def test_without_calibration_a_strafe_is_off_by_what_the_plant_over_reports() -> None:
    arena = hall(slip_rate_per_m=0.0, lateral_over_report=LATERAL_ERROR)
    drivetrain = SimDrivetrain(arena, 21)
    driven = Driver(drivetrain, arena.config, OdometryScale()).drive([Leg(Axis.LEFT, 2.0, 0.15)])
    over = driven.end.y_m / drivetrain.true_pose.y_m
    assert over == pytest.approx(1.0 / drivetrain.simulation.drive.lateral_scale, abs=0.001)
    assert over > 1.03


# --- over a real serial line, with a person ---


@pytest.mark.linux
@pytest.mark.slow
def test_a_person_measures_over_the_serial_port(tmp_path: Path) -> None:
    link, path = tmp_path / "arduino", tmp_path / "robot.yaml"
    robot = ArduinoSim(link)
    try:
        # Enter to drive 0.4 m; then 0.38 m were measured.
        options = (
            "--config",
            str(path),
            "--port",
            str(link),
            "--distance",
            "0.4",
            "--strafe",
            "0",
            "--turns",
            "0",
        )
        result = calibrate(*options, "--square", "0", answers="\n0.38\n")
        assert result.exit_code == 0, (result.output, result.exception)
        assert scale_of(path).forward == pytest.approx(0.95, abs=0.01)
        assert robot.simulation.drive.path_m > 0.75  # there and back
        assert abs(robot.simulation.true_pose.x_m) < 0.05
    finally:
        robot.close()


@pytest.mark.linux
@pytest.mark.slow
def test_a_cable_that_is_pulled_ends_it_and_nothing_is_written(tmp_path: Path) -> None:
    link, path = tmp_path / "arduino", tmp_path / "robot.yaml"
    robot = ArduinoSim(link)

    def pull_while_it_drives() -> None:
        wait_until(lambda: robot.simulation.drive.path_m > 0.05, "a moving robot")
        robot.unplug()

    pull = threading.Thread(target=pull_while_it_drives)
    pull.start()
    try:
        result = calibrate("--config", str(path), "--port", str(link), answers="\n")
        assert isinstance(result.exception, DeviceError)
        assert re.search("is lost|no odometry", str(result.exception))
        assert not path.exists()
    finally:
        pull.join()
        robot.close()


@pytest.mark.linux
def test_a_port_without_an_arduino(tmp_path: Path) -> None:
    result = calibrate("--config", str(tmp_path / "robot.yaml"), "--port", str(tmp_path / "none"))
    assert isinstance(result.exception, DeviceError)
    assert "there is no serial port" in str(result.exception)

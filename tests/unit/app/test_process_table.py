"""The process table: who runs, in which order, on which core, with which options."""

from __future__ import annotations

import importlib.util
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from target_nav.app.process_spec import ProcessSpec, ReadyWhen, RestartPolicy
from target_nav.app.process_table import (
    StackOptions,
    find_ros_executable,
    recorder,
    robot_stack,
    simulation_stack,
)


@pytest.fixture
def options(tmp_path: Path) -> StackOptions:
    return StackOptions(run_dir=tmp_path, mission="bowling_pin", prefix="t1", cores=4)


def by_name(stack: tuple[ProcessSpec, ...]) -> dict[str, ProcessSpec]:
    return {spec.name: spec for spec in stack}


def option(spec: ProcessSpec, name: str) -> str:
    return spec.argv[spec.argv.index(name) + 1]


def test_the_simulator_comes_first_and_nav_last(options: StackOptions) -> None:
    names = [spec.name for spec in simulation_stack(options, "open_floor", 7)]
    assert names == ["sim", "camera", "arduino", "odometry", "nav"]


def test_every_process_is_a_module_of_this_project(options: StackOptions) -> None:
    for spec in simulation_stack(options, "open_floor", 7):
        interpreter, dash_m, module = spec.argv[:3]
        assert (interpreter, dash_m) == (sys.executable, "-m")
        assert importlib.util.find_spec(module) is not None, module


def test_all_processes_share_channels_and_configuration(options: StackOptions, tmp_path: Path) -> None:
    config = tmp_path / "config.yaml"
    for spec in simulation_stack(replace(options, config_file=config), "open_floor", 7):
        assert option(spec, "--prefix") == "t1"
        assert option(spec, "--config") == str(config)


def test_the_arduino_node_opens_what_the_simulator_offers(options: StackOptions) -> None:
    stack = by_name(simulation_stack(options, "open_floor", 7))
    assert option(stack["arduino"], "--port") == option(stack["sim"], "--serial-link")
    assert option(stack["sim"], "--arena") == "open_floor"
    assert option(stack["sim"], "--seed") == "7"


def test_only_the_simulator_makes_the_others_wait(options: StackOptions) -> None:
    stack = by_name(simulation_stack(options, "open_floor", 7))
    assert {spec.ready for spec in stack.values()} == {ReadyWhen.REPORTED}
    assert [name for name, spec in stack.items() if spec.holds_next and name != "nav"] == ["sim"]


def test_the_simulated_world_never_begins_anew_in_mid_run(options: StackOptions) -> None:
    stack = by_name(simulation_stack(options, "open_floor", 7))
    assert stack["sim"].restart.max_failures == 1
    assert min(spec.restart.max_failures for name, spec in stack.items() if name != "sim") > 1


def test_cores_and_niceness_are_the_references(options: StackOptions) -> None:
    stack = by_name(simulation_stack(options, "open_floor", 7))
    cores = {name: spec.core for name, spec in stack.items()}
    assert cores == {"sim": None, "camera": 2, "arduino": None, "odometry": None, "nav": 1}
    assert option(stack["camera"], "--detector-core") == "3"
    assert {name: spec.nice for name, spec in stack.items() if spec.nice is not None} == {"nav": -5}


@pytest.mark.parametrize("cores", [1, 2, 3])
def test_few_cores_are_shared_and_not_pinned(options: StackOptions, cores: int) -> None:
    assert {spec.core for spec in simulation_stack(replace(options, cores=cores), "open_floor", 7)} == {None}
    camera = by_name(simulation_stack(replace(options, cores=cores), "open_floor", 7))["camera"]
    assert "--detector-core" not in camera.argv


def test_the_camera_process_starts_the_detector_and_its_log_belongs_to_the_run(options: StackOptions) -> None:
    camera = by_name(simulation_stack(options, "open_floor", 7))["camera"]
    assert option(camera, "--detector") == "sim"
    assert option(camera, "--logs") == str(options.run_dir / "logs")
    assert camera.children == ("detector",)


def test_nav_gets_its_orders(options: StackOptions, tmp_path: Path) -> None:
    plain = by_name(simulation_stack(options, "open_floor", 7))["nav"]
    assert "--go" not in plain.argv
    assert "--record" not in plain.argv
    orders = replace(options, go=True, record=tmp_path / "run.mcap")
    nav = by_name(simulation_stack(orders, "open_floor", 7))["nav"]
    assert "--go" in nav.argv
    assert option(nav, "--record") == str(tmp_path / "run.mcap")
    assert option(nav, "--mission") == "bowling_pin"


def test_the_robot_has_no_simulator(options: StackOptions) -> None:
    stack = by_name(robot_stack(options, "/dev/ttyACM0", environment={}))
    assert list(stack) == ["lidar", "camera", "arduino", "odometry", "nav"]
    assert option(stack["arduino"], "--port") == "/dev/ttyACM0"
    assert option(stack["camera"], "--detector") == "/dev/video0"


def test_without_rplidar_ros_our_own_driver_reads_the_lidar(options: StackOptions) -> None:
    lidar = robot_stack(options, "/dev/ttyACM0", "/dev/ttyUSB1", environment={})[0]
    assert lidar.argv[2] == "target_nav.app.lidar_node"
    assert option(lidar, "--port") == "/dev/ttyUSB1"
    assert option(lidar, "--prefix") == "t1"
    assert (lidar.critical, lidar.holds_next, lidar.ready) == (True, False, ReadyWhen.REPORTED)


def install(prefix: Path, package: str, name: str) -> dict[str, str]:
    """An executable of a ROS package, and the environment in which it is found."""
    program = prefix / "lib" / package / name
    program.parent.mkdir(parents=True)
    program.write_text("")
    program.chmod(0o755)
    return {"AMENT_PREFIX_PATH": f"/nowhere:{prefix}"}


def test_our_own_driver_can_be_asked_for(options: StackOptions, tmp_path: Path) -> None:
    environment = install(tmp_path, "rplidar_ros", "rplidar_node")
    asked = replace(options, own_lidar_driver=True)
    assert (
        robot_stack(asked, "/dev/ttyACM0", environment=environment)[0].argv[2] == "target_nav.app.lidar_node"
    )


def test_the_model_is_published_where_its_publisher_is_installed(
    options: StackOptions, tmp_path: Path
) -> None:
    environment = install(tmp_path, "robot_state_publisher", "robot_state_publisher")
    model = by_name(robot_stack(options, "/dev/ttyACM0", environment=environment))["model"]
    assert model.argv[2] == "target_nav.app.robot_description"
    assert option(model, "--publish") == str(tmp_path / "robot_description.yaml")
    assert not model.critical


def test_a_bag_is_recorded_when_asked_for(options: StackOptions, tmp_path: Path) -> None:
    asked = replace(options, bag=tmp_path / "bag")
    for stack in (
        simulation_stack(asked, "open_floor", 7),
        robot_stack(asked, "/dev/ttyACM0", environment={}),
    ):
        spec = stack[-1]
        assert (spec.name, spec.critical) == ("recorder", False)
        assert option(spec, "--output") == str(tmp_path / "bag")
        assert "--topics" not in spec.argv


def test_a_recorder_can_be_asked_for_other_topics(options: StackOptions) -> None:
    spec = recorder(options, Path("bag"), ("/scan", "/tf"))
    assert spec.argv[-3:] == ("--topics", "/scan", "/tf")


@pytest.mark.parametrize("name", ["rplidar_node", "rplidar_composition"])
def test_an_installed_lidar_driver_is_started_first(options: StackOptions, tmp_path: Path, name: str) -> None:
    environment = install(tmp_path, "rplidar_ros", name)
    lidar = robot_stack(options, "/dev/ttyACM0", "/dev/ttyUSB1", environment=environment)[0]
    assert lidar.name == "lidar"
    assert lidar.argv[0] == str(tmp_path / "lib" / "rplidar_ros" / name)
    assert "serial_port:=/dev/ttyUSB1" in lidar.argv


def test_an_executable_is_looked_for_in_prefixes_only() -> None:
    assert find_ros_executable("rplidar_ros", ("rplidar_node",), {"AMENT_PREFIX_PATH": ""}) is None
    assert find_ros_executable("rplidar_ros", ("rplidar_node",), {}) is None


def test_back_off_doubles_up_to_its_bound() -> None:
    policy = RestartPolicy(first_delay_s=0.25, max_delay_s=5.0)
    assert [policy.delay_s(n) for n in (1, 2, 3, 4, 5, 6, 100)] == [0.25, 0.5, 1.0, 2.0, 4.0, 5.0, 5.0]

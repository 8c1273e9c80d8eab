"""The process table: every process of a stack, in the order of starting, with its core and niceness.

Only the simulator makes the others wait, for it makes the serial port; they find each other in any order. One
place, so that which loop runs where is not spread over launch files. Cores are the reference's: 0 GUI, 1 nav,
2 camera, 3 detector (which the camera process starts and watches); with fewer than four cores nothing is pinned, for
then sharing is better than waiting.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from target_nav.app import gui_launch
from target_nav.app.process_spec import ProcessSpec, ReadyWhen, RestartPolicy

GUI_CORE, NAV_CORE, CAMERA_CORE, DETECTOR_CORE = 0, 1, 2, 3
CORES_TO_PIN = 4
NAV_NICE = -5

ONCE = RestartPolicy(max_failures=1)
"""For the simulator: a world that begins anew in mid-run would make the run a lie, so its death ends the stack."""

LIDAR_PACKAGE = "rplidar_ros"
LIDAR_EXECUTABLES = ("rplidar_node", "rplidar_composition")
"""Of the present and of older releases."""

MODEL_PUBLISHER = "robot_state_publisher"


@dataclass(frozen=True)
class StackOptions:
    """What a whole stack is started with; each process gets its share as options.

    `config_file` as `settings.write_config` writes it. `go` begins the mission without waiting for an
    operator.
    """

    run_dir: Path
    mission: str
    prefix: str
    config_file: Path | None = None
    record: Path | None = None
    go: bool = False
    bag: Path | None = None
    """Record the stack's topics into this folder."""
    own_lidar_driver: bool = False
    """Take this project's LiDAR driver even where rplidar_ros is installed."""
    cores: int | None = None
    """Cores to share out; None: those this process may use."""
    gui: bool = False
    """Open the operator's panel; `gui_launch.problem` says beforehand whether that can be."""
    settings_file: Path | None = None
    """The operator's saved changes, over `config_file`; it need not exist."""

    @property
    def common(self) -> tuple[str, ...]:
        return gui_launch.options_of(self.prefix, self.config_file, self.settings_file)

    def core(self, number: int) -> int | None:
        cores = self.cores if self.cores is not None else len(os.sched_getaffinity(0))
        return number if cores >= CORES_TO_PIN else None


def simulation_stack(options: StackOptions, arena: str, seed: int) -> tuple[ProcessSpec, ...]:
    """The full stack against the simulator. The truth goes to `truth.json` in the run's folder."""
    link = options.run_dir.resolve() / "arduino"
    sim = ProcessSpec(
        "sim",
        _module(
            "sim_node",
            "--arena", arena,
            "--seed", str(seed),
            "--serial-link", str(link),
            "--truth", str(options.run_dir / "truth.json"),
            *options.common,
        ),
        ready=ReadyWhen.REPORTED,
        restart=ONCE,
    )  # fmt: skip
    rest = (*_drive_and_nav(options, str(link)), *_recorder(options), *_gui(options))
    return (sim, *_perception(options, "sim"), *rest)


def robot_stack(
    options: StackOptions,
    serial_port: str,
    lidar_port: str = "/dev/ttyUSB0",
    camera_source: str = "/dev/video0",
    environment: Mapping[str, str] | None = None,
) -> tuple[ProcessSpec, ...]:
    """The stack on the robot. Without rplidar_ros the LiDAR is driven by `lidar_node`."""
    environment = os.environ if environment is None else environment
    return (
        _lidar(options, lidar_port, environment),
        *_model(options, environment),
        *_perception(options, camera_source),
        *_drive_and_nav(options, serial_port),
        *_recorder(options),
        *_gui(options),
    )


def recorder(options: StackOptions, bag: Path, topics: Sequence[str] = ()) -> ProcessSpec:
    """ROS topics into a bag; without `topics` those of the stack. The stack does without it, too."""
    chosen = ("--topics", *topics) if topics else ()
    return ProcessSpec(
        "recorder",
        _module("bag_recorder", "--output", str(bag), *options.common, *chosen),
        critical=False,
        ready=ReadyWhen.REPORTED,
        holds_next=False,
    )


def find_ros_executable(package: str, names: tuple[str, ...], environment: Mapping[str, str]) -> Path | None:
    """The first of a ROS package's executables that is installed, as `ros2 run` would find it."""
    for prefix in environment.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        for name in names:
            path = Path(prefix) / "lib" / package / name
            if prefix and os.access(path, os.X_OK):
                return path
    return None


def _lidar(options: StackOptions, port: str, environment: Mapping[str, str]) -> ProcessSpec:
    driver = None
    if not options.own_lidar_driver:
        driver = find_ros_executable(LIDAR_PACKAGE, LIDAR_EXECUTABLES, environment)
    if driver is None:
        return ProcessSpec(
            "lidar",
            _module("lidar_node", "--port", port, *options.common),
            ready=ReadyWhen.REPORTED,
            holds_next=False,
        )
    parameters = (f"serial_port:={port}", "frame_id:=laser", "angle_compensate:=true")
    return ProcessSpec(
        "lidar", (str(driver), "--ros-args", *(part for value in parameters for part in ("-p", value)))
    )


def _model(options: StackOptions, environment: Mapping[str, str]) -> tuple[ProcessSpec, ...]:
    """The robot model for RViz and Foxglove, where its publisher is installed."""
    if find_ros_executable(MODEL_PUBLISHER, (MODEL_PUBLISHER,), environment) is None:
        return ()
    parameters = options.run_dir.resolve() / "robot_description.yaml"
    argv = _module("robot_description", "--publish", str(parameters), *options.common)
    return (ProcessSpec("model", argv, critical=False),)


def _recorder(options: StackOptions) -> tuple[ProcessSpec, ...]:
    return (recorder(options, options.bag),) if options.bag is not None else ()


def _gui(options: StackOptions) -> tuple[ProcessSpec, ...]:
    """The operator's panel. The robot does without it, whatever becomes of it."""
    if not options.gui:
        return ()
    return (
        ProcessSpec(
            "gui",
            gui_launch.command(*options.common),
            core=options.core(GUI_CORE),
            critical=False,
            ready=ReadyWhen.REPORTED,
            holds_next=False,
            stop_timeout_s=1.0,
        ),
    )


def _perception(options: StackOptions, source: str) -> tuple[ProcessSpec, ...]:
    detector = ["--detector", source, "--logs", str(options.run_dir / "logs")]
    core = options.core(DETECTOR_CORE)
    if core is not None:
        detector += ["--detector-core", str(core)]
    return (
        ProcessSpec(
            "camera",
            _module("camera_node", *options.common, *detector),
            core=options.core(CAMERA_CORE),
            ready=ReadyWhen.REPORTED,
            holds_next=False,
            children=("detector",),
        ),
    )


def _drive_and_nav(options: StackOptions, serial_port: str) -> tuple[ProcessSpec, ...]:
    nav = ["--mission", options.mission, *options.common]
    if options.record is not None:
        nav += ["--record", str(options.record)]
    if options.go:
        nav.append("--go")
    return (
        ProcessSpec(
            "arduino",
            _module("arduino_node", "--port", serial_port, *options.common),
            ready=ReadyWhen.REPORTED,
            holds_next=False,
        ),
        ProcessSpec(
            "odometry",
            _module("odometry_node", "--state", str(options.run_dir / "odometry.state"), *options.common),
            ready=ReadyWhen.REPORTED,
            holds_next=False,
        ),
        ProcessSpec(
            "nav",
            _module("tree_executor", *nav),
            core=options.core(NAV_CORE),
            nice=NAV_NICE,
            ready=ReadyWhen.REPORTED,
            holds_next=False,
        ),
    )


def _module(name: str, *arguments: str) -> tuple[str, ...]:
    return (sys.executable, "-m", f"target_nav.app.{name}", *arguments)

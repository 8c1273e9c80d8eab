"""The robot model says what the configuration says, and is one tree of frames."""

from __future__ import annotations

import importlib.util
import math
import os
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from target_nav.app.robot_description import frame_to_msg, frames, parameter_file, urdf
from target_nav.app.ros_clock import RosClock
from target_nav.app.ros_convert import BASE_FRAME, CAMERA_FRAME, LASER_FRAME
from target_nav.config import Config
from target_nav.sim.wheels import WHEEL_RADIUS_M, Base

ROOT = Path(__file__).resolve().parents[3]
COMMITTED = ROOT / "urdf" / "target_nav.urdf"

WHEELS = ["wheel_front_left", "wheel_front_right", "wheel_rear_left", "wheel_rear_right"]

MOUNTS = {
    "laser": ("lidar.x_m", "lidar.y_m", "lidar.z_m", "lidar.yaw_rad"),
    "camera_link": ("camera.x_m", "camera.y_m", "camera.z_m", "camera.yaw_rad"),
}


def joints(text: str) -> dict[str, tuple[str, list[float], list[float]]]:
    """Child link to (parent link, xyz, rpy)."""
    found = {}
    for joint in ET.fromstring(text).iter("joint"):
        parent, child, origin = joint.find("parent"), joint.find("child"), joint.find("origin")
        assert parent is not None
        assert child is not None
        assert origin is not None
        xyz, rpy = ([float(v) for v in origin.attrib[name].split()] for name in ("xyz", "rpy"))
        found[child.attrib["link"]] = (parent.attrib["link"], xyz, rpy)
    return found


def rotation(roll: float, pitch: float, yaw: float) -> np.ndarray:
    """Fixed axes: first roll about x, then pitch about y, then yaw about z (URDF, REP-103)."""
    cr, sr, cp, sp, cy, sy = (f(a) for a in (roll, pitch, yaw) for f in (math.cos, math.sin))
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return about_z @ about_y @ about_x


def test_the_committed_file_is_the_generated_one() -> None:
    fresh = urdf(Config())
    assert COMMITTED.read_text(encoding="utf-8") == fresh, (
        "config.py has changed: python -m target_nav.app.robot_description > urdf/target_nav.urdf"
    )


def test_the_command_prints_it() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "target_nav.app.robot_description", "--set", "lidar.z_m=0.31"],
        capture_output=True, text=True, check=True, timeout=60,
    )  # fmt: skip
    assert done.stdout == urdf(Config().override({"lidar.z_m": 0.31}))


def test_there_is_one_tree_below_base_link() -> None:
    model = ET.fromstring(urdf(Config()))
    links = [link.attrib["name"] for link in model.iter("link")]
    parents = {child: parent for child, (parent, _, _) in joints(urdf(Config())).items()}
    assert len(set(links)) == len(links)
    assert set(links) == {*parents, *parents.values()}
    assert set(links) - set(parents) == {BASE_FRAME}
    assert len(list(model.iter("joint"))) == len(links) - 1
    assert {*WHEELS, LASER_FRAME, CAMERA_FRAME, "base_footprint", "camera_optical_frame"} < set(links)


@settings(max_examples=50, deadline=None)
@given(st.data())
def test_mounts_are_where_the_configuration_puts_them(data: st.DataObject) -> None:
    limits = {key: (meta["low"], meta["high"]) for key, _, meta in Config().items() if "low" in meta}
    wanted = {key: data.draw(st.floats(*limits[key]), label=key) for keys in MOUNTS.values() for key in keys}
    found = joints(urdf(Config().override(wanted)))
    for frame, (x, y, z, yaw) in MOUNTS.items():
        parent, xyz, rpy = found[frame]
        assert parent == BASE_FRAME
        assert xyz == pytest.approx([wanted[x], wanted[y], wanted[z]], abs=1e-12)
        assert rpy == pytest.approx([0.0, 0.0, wanted[yaw]], abs=1e-12)


def test_wheels_stand_on_the_floor_at_the_corners_of_axles_and_track() -> None:
    config = Config().override({"robot.wheelbase_m": 0.3, "robot.track_m": 0.2, "robot.wheel_radius_m": 0.05})
    found = joints(urdf(config))
    places = {name: found[name][1] for name in WHEELS}
    assert places == {
        "wheel_front_left": [0.15, 0.1, 0.05],
        "wheel_front_right": [0.15, -0.1, 0.05],
        "wheel_rear_left": [-0.15, 0.1, 0.05],
        "wheel_rear_right": [-0.15, -0.1, 0.05],
    }


def test_wheels_are_those_of_the_kinematics() -> None:
    robot = Config().robot
    assert robot.wheel_radius_m == WHEEL_RADIUS_M
    assert 0.5 * (robot.wheelbase_m + robot.track_m) == pytest.approx(Base.of(robot).lever_m)
    differential = Config().override({"robot.drive": "differential"}).robot
    assert 0.5 * robot.track_m == pytest.approx(Base.of(differential).lever_m)


def test_the_optical_frame_looks_out_of_the_lens() -> None:
    parent, xyz, rpy = joints(urdf(Config()))["camera_optical_frame"]
    assert (parent, xyz) == (CAMERA_FRAME, [0.0, 0.0, 0.0])
    x, y, z = rotation(*rpy).T
    assert x == pytest.approx([0.0, -1.0, 0.0])  # right in the picture is right
    assert y == pytest.approx([0.0, 0.0, -1.0])  # down in the picture is down
    assert z == pytest.approx([1.0, 0.0, 0.0])  # depth is ahead


def test_the_footprint_is_base_link_itself() -> None:
    assert joints(urdf(Config()))["base_footprint"] == (BASE_FRAME, [0.0] * 3, [0.0] * 3)


def test_the_body_is_the_footprint_of_the_collision_checks() -> None:
    config = Config().override({"robot.front_m": 0.25, "robot.rear_m": 0.15, "robot.half_width_m": 0.2})
    collision = ET.fromstring(urdf(config)).find("./link[@name='base_link']/collision")
    assert collision is not None
    origin, box = collision.find("origin"), collision.find("geometry/box")
    assert origin is not None
    assert box is not None
    centre, size = ([float(v) for v in text.split()] for text in (origin.attrib["xyz"], box.attrib["size"]))
    assert centre[0] + size[0] / 2 == pytest.approx(0.25)
    assert centre[0] - size[0] / 2 == pytest.approx(-0.15)
    assert size[1] == pytest.approx(0.4)
    assert centre[2] + size[2] / 2 < config.lidar.z_m


def test_frames_and_model_say_the_same() -> None:
    config = Config().override({"camera.yaw_rad": 0.02, "lidar.x_m": -0.03})
    found = joints(urdf(config))
    for frame in frames(config):
        parent, xyz, rpy = found.pop(frame.name)
        assert parent == frame.parent
        assert xyz == pytest.approx([frame.x_m, frame.y_m, frame.z_m], abs=1e-12)
        assert rpy == pytest.approx([frame.roll_rad, frame.pitch_rad, frame.yaw_rad], abs=1e-12)
    assert not found


@pytest.mark.skipif(
    importlib.util.find_spec("urdf_parser_py") is None, reason="urdf_parser_py is in the extra `dev`"
)
def test_the_parser_of_ros_reads_it() -> None:
    from urdf_parser_py.urdf import URDF

    robot = URDF.from_xml_string(COMMITTED.read_bytes())
    assert robot.get_root() == BASE_FRAME
    chain = robot.get_chain(BASE_FRAME, "camera_optical_frame", joints=False)
    assert chain == [BASE_FRAME, CAMERA_FRAME, "camera_optical_frame"]
    lidar = Config().lidar
    assert robot.joint_map["laser_joint"].origin.xyz == pytest.approx([lidar.x_m, lidar.y_m, lidar.z_m])


def test_the_parameter_file_is_what_robot_state_publisher_takes() -> None:
    data = yaml.safe_load(parameter_file(Config()))
    assert data == {"robot_state_publisher": {"ros__parameters": {"robot_description": urdf(Config())}}}


def run_publisher(tmp_path: Path, prefix: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "target_nav.app.robot_description", "--publish", str(tmp_path / "model.yaml")],
        env={**os.environ, "AMENT_PREFIX_PATH": prefix}, capture_output=True, text=True, timeout=60,
    )  # fmt: skip


def test_an_installed_publisher_is_started_with_the_model(tmp_path: Path) -> None:
    program = tmp_path / "lib" / "robot_state_publisher" / "robot_state_publisher"
    program.parent.mkdir(parents=True)
    program.write_text('#!/bin/sh\necho "started $*"\n')
    program.chmod(0o755)
    done = run_publisher(tmp_path, str(tmp_path))
    assert done.stdout == f"started --ros-args --params-file {tmp_path / 'model.yaml'}\n"
    assert (tmp_path / "model.yaml").read_text() == parameter_file(Config())


def test_a_missing_publisher_is_told(tmp_path: Path) -> None:
    done = run_publisher(tmp_path, "")
    assert done.returncode == 2
    assert "apt install ros-jazzy-robot-state-publisher" in done.stderr
    assert not (tmp_path / "model.yaml").exists()


@pytest.mark.ros
def test_the_optical_frame_looks_along_the_cameras_x_axis_in_tf_as_well() -> None:
    pytest.importorskip("geometry_msgs.msg")
    optical = next(f for f in frames(Config()) if f.name == "camera_optical_frame")
    q = frame_to_msg(optical, 1.0, RosClock()).transform.rotation
    # REP-103: z out of the lens; the third column of the rotation matrix is where z points
    z_axis = (2 * (q.x * q.z + q.w * q.y), 2 * (q.y * q.z - q.w * q.x), 1 - 2 * (q.x**2 + q.y**2))
    assert z_axis == pytest.approx((1.0, 0.0, 0.0), abs=1e-9)
    assert q.x**2 + q.y**2 + q.z**2 + q.w**2 == pytest.approx(1.0)

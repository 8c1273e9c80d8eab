"""Pictures in shared memory to objects in shared memory, through the two real processes."""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
import time
import uuid
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest

from target_nav.config import Config
from target_nav.ipc import channels
from target_nav.sim.arena import Arena, Bounds, PlacedObject
from target_nav.sim.render import Renderer
from target_nav.state.snapshots import CameraFrame, NavSnapshot
from target_nav.state.types import STOP, NavState, Pose2D, TargetSpec
from tests.utils.perception import PerceptionRig, has_object

pytestmark = pytest.mark.linux

CONFIG = Config()
START_LIMIT_S = 30.0
RANGE_M, BEARING_RAD = 1.5, 0.15


def picture(with_pin: bool) -> np.ndarray:
    camera_m = CONFIG.camera.x_m
    x, y = RANGE_M * math.cos(BEARING_RAD) + camera_m, RANGE_M * math.sin(BEARING_RAD)
    target = PlacedObject("bowling_pin", x, y) if with_pin else None
    arena = Arena("chain", Bounds(-4.0, -4.0, 4.0, 4.0), Pose2D(), target)
    return Renderer(arena, CONFIG).draw(Pose2D(), 0.0, np.random.default_rng(1))


class Chain(PerceptionRig):
    UNTIL_LIMIT_S = 10.0

    def __init__(self, folder: Path) -> None:
        super().__init__(folder, picture(with_pin=True))

    def start(self, name: str, *options: str, ready: bool = True) -> subprocess.Popen[str]:
        ready_file = self.folder / f"{name}_{uuid.uuid4().hex}"
        process = subprocess.Popen(
            [sys.executable, "-m", f"target_nav.app.{name}", "--prefix", self.prefix, *options],
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, "TARGET_NAV_READY_FILE": str(ready_file)},
        )
        self.running.append(process)
        deadline_s = time.monotonic() + START_LIMIT_S
        while ready and not ready_file.exists():
            assert process.poll() is None, process.communicate()[1]
            assert time.monotonic() < deadline_s, f"{name} not ready after {START_LIMIT_S} s"
            time.sleep(0.02)
        return process


@pytest.fixture
def chain(tmp_path: Path) -> Iterator[Chain]:
    chain = Chain(tmp_path)
    yield chain
    chain.close()


def test_a_picture_becomes_an_object_with_range_bearing_and_its_own_stamp(chain: Chain) -> None:
    chain.start("detector_node")
    chain.start("camera_node", "--no-ros")
    frame = chain.until(has_object)
    (pin,) = frame.detections
    assert pin.range_m == pytest.approx(RANGE_M, rel=0.04)
    assert pin.bearing_rad == pytest.approx(BEARING_RAD, abs=0.01)
    assert not pin.clipped
    assert frame.stamp_s in chain.sent

    shown = channels.open_reader(channels.CAMERA, prefix=chain.prefix).latest()
    assert shown is not None
    assert shown.stamp_s in chain.sent
    assert np.array_equal(shown.image_bgr, chain.image)

    chain.image = picture(with_pin=False)
    seen_nothing = chain.until(lambda f: not f.detections)
    assert seen_nothing.stamp_s > frame.stamp_s


def test_a_killed_detector_is_noticed_and_a_new_one_goes_on(chain: Chain) -> None:
    detector = chain.start("detector_node")
    chain.start("camera_node", "--no-ros")
    before = chain.until(has_object)

    detector.send_signal(signal.SIGKILL)
    detector.wait(timeout=5.0)
    for _ in range(5):
        chain.send()
    killed_s = time.monotonic()
    last = chain.det.latest()
    for _ in range(12):
        chain.send()
    assert last is not None
    assert chain.det.latest() == last, "an old frame was handed on as a new one"
    assert chain.det.age_s(time.monotonic()) > time.monotonic() - killed_s

    chain.start("detector_node")
    after = chain.until(lambda f: has_object(f) and f.stamp_s > killed_s)
    assert after.detections[0].range_m == pytest.approx(before.detections[0].range_m, rel=0.03)


def test_both_poses_of_a_tag_come_through_to_the_nav_process(chain: Chain) -> None:
    facing_rad = math.pi - 0.6
    tag = PlacedObject("apriltag:7", 1.5, 0.2, facing_rad)
    room = Arena("tag", Bounds(-4.0, -4.0, 1.5, 4.0), Pose2D(), tag)
    chain.image = Renderer(room, CONFIG).draw(Pose2D(), 0.0, np.random.default_rng(1))
    chain.start("detector_node")
    chain.start("camera_node", "--no-ros")
    with channels.open_writer(channels.NAV, prefix=chain.prefix) as nav:
        nav.write(nav_snapshot(TargetSpec("apriltag:7", 0.16, 0.16)))
        frame = chain.until(lambda f: any(d.confirmed and d.facing is not None for d in f.detections))
    (seen,) = frame.detections
    assert seen.facing is not None
    assert seen.other_facing is not None
    assert abs(math.remainder(seen.facing.facing_rad - facing_rad, math.tau)) < 0.08
    assert seen.facing.error_px < seen.other_facing.error_px
    assert seen.range_m == pytest.approx(math.hypot(1.5 - CONFIG.camera.x_m, 0.2), rel=0.03)


def test_the_mission_s_target_reaches_the_detector(chain: Chain) -> None:
    """Size from the nav process scales the range; the class goes on to the detector by `calibration`."""
    chain.start("detector_node")
    chain.start("camera_node", "--no-ros")
    chain.until(has_object)
    calibration = channels.open_reader(channels.CALIBRATION, prefix=chain.prefix)
    first = calibration.latest()
    assert first is not None
    assert (first.class_name, first.score_min) == ("bowling_pin", CONFIG.detector.propose_score)
    assert (first.focal_x_px, first.center_u_px) == (CONFIG.camera.focal_px, 320.0)

    nav = channels.open_writer(channels.NAV, prefix=chain.prefix)
    nav.write(nav_snapshot(TargetSpec("bowling_pin", 0.14, 0.04)))
    half = chain.until(lambda f: any(d.range_m < 0.6 * RANGE_M for d in f.detections))
    assert half.detections[0].range_m == pytest.approx(RANGE_M / 2, rel=0.04)

    nav.write(nav_snapshot(TargetSpec("bottle", 0.25, 0.07)))
    chain.until(lambda f: not f.detections)
    newest = calibration.latest()
    assert newest is not None
    assert newest.class_name == "bottle"
    nav.close()


def test_what_a_former_run_left_is_not_followed(chain: Chain) -> None:
    before_s = time.monotonic() - 5.0
    chain.sim_camera.write(CameraFrame(before_s, 1, chain.image))
    with channels.open_writer(channels.NAV, prefix=chain.prefix) as nav:
        nav.write(nav_snapshot(TargetSpec("bottle", 0.25, 0.07), before_s))
    chain.start("detector_node")
    chain.start("camera_node", "--no-ros")
    time.sleep(1.0)
    assert chain.det.latest() is None
    calibration = channels.open_reader(channels.CALIBRATION, prefix=chain.prefix).latest()
    assert calibration is not None
    assert calibration.class_name == "bowling_pin"


@pytest.mark.parametrize("name", ["detector_node", "camera_node"])
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_ends_a_process_in_good_order(chain: Chain, name: str, number: signal.Signals) -> None:
    process = chain.start(name, *(("--no-ros",) if name == "camera_node" else ()))
    process.send_signal(number)
    _, errors = process.communicate(timeout=5.0)
    assert process.returncode == 0, errors
    assert "Traceback" not in errors


def test_a_second_detector_is_refused(chain: Chain) -> None:
    chain.start("detector_node")
    second = chain.start("detector_node", ready=False)
    _, errors = second.communicate(timeout=START_LIMIT_S)
    assert second.returncode == 2
    assert "camera" in errors


def test_a_camera_that_is_not_there_is_told_and_not_tried_again(chain: Chain) -> None:
    process = chain.start("detector_node", "--source", "/dev/video_none", ready=False)
    _, errors = process.communicate(timeout=START_LIMIT_S)
    assert process.returncode == 2
    assert "camera /dev/video_none is not there" in errors
    assert "Traceback" not in errors


def test_pictures_of_another_size_are_refused(chain: Chain) -> None:
    process = chain.start("detector_node")
    chain.image = np.zeros((240, 320, 3), np.uint8)
    chain.send()
    _, errors = process.communicate(timeout=5.0)
    assert process.returncode == 2
    assert "pictures are 320x240, the configuration has 640x480" in errors


def test_a_video_file_is_looked_through_to_its_end(chain: Chain, tmp_path: Path) -> None:
    video = tmp_path / "pin.avi"
    writer = cv2.VideoWriter(str(video), cv2.VideoWriter.fourcc(*"MJPG"), 20.0, (640, 480))
    for _ in range(10):
        writer.write(chain.image)
    writer.release()
    process = chain.start("detector_node", "--source", str(video), "--rate", "20")
    _, errors = process.communicate(timeout=10.0)
    assert process.returncode == 0, errors
    assert f"end of {video} after 10 pictures" in errors
    last = channels.open_reader(channels.DETECTIONS, prefix=chain.prefix).latest()
    assert last is not None
    assert last.frame_id == 10
    assert [box.class_name for box in last.detections] == ["bowling_pin"]


@pytest.mark.ros
def test_onlookers_get_json_and_the_mode(chain: Chain) -> None:
    from std_msgs.msg import String

    from target_nav.app.ros_support import RosNode, latched_qos, stream_qos

    texts: list[str] = []
    modes: list[str] = []
    with RosNode("onlooker") as ros:
        ros.subscribe(String, "/detections", lambda m: texts.append(m.data), stream_qos())
        ros.subscribe(String, "/detector_mode", lambda m: modes.append(m.data), latched_qos())
        ros.start()
        chain.start("camera_node")
        detector = chain.start("detector_node")
        chain.until(lambda f: has_object(f) and len(texts) > 3, limit_s=20.0)
        detector.kill()
        deadline_s = time.monotonic() + 5.0
        while "stale" not in modes and time.monotonic() < deadline_s:
            time.sleep(0.05)
    assert modes in (["waiting", "live", "stale"], ["live", "stale"])
    message = json.loads(texts[-1])
    assert message["stamp_s"] in chain.sent
    (pin,) = message["detections"]
    assert pin["class_name"] == "bowling_pin"
    assert pin["range_m"] == pytest.approx(RANGE_M, rel=0.04)


def nav_snapshot(spec: TargetSpec, stamp_s: float | None = None) -> NavSnapshot:
    return NavSnapshot(
        stamp_s=time.monotonic() if stamp_s is None else stamp_s,
        tick=1,
        state=NavState.IDLE,
        outcome=None,
        running_leaf="",
        reason="",
        requested=False,
        pose_in_odom=Pose2D(),
        twist_sent=STOP,
        limited_by="",
        track=None,
        spec=spec,
        scan_age_s=math.inf,
        odom_age_s=math.inf,
        camera_age_s=math.inf,
        rate_hz=20.0,
        jitter_p99_s=0.0,
        overruns=0,
    )

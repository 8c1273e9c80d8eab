"""Process `camera`: starts the detector and watches it, and turns its boxes into objects with a range and a bearing.

detections                            in: boxes of one picture
nav                                   in: what the mission looks for
det                                   out: objects, stamped with the time at which the picture was taken
calibration                           out: what the detector shall do, once a second and when it changes
/detections (std_msgs/String)         out: `det` as JSON, for who has only ROS
/detector_mode (std_msgs/String)      out, latched: waiting, live, stale, or ended (of a video)
/drpai_restart (std_msgs/String)      in: start the detector anew; the text says why

A picture is handed on once. When the detector stops, nothing is written, and the age of `det` grows: that is what stops
the robot, whatever happens here.
"""

from __future__ import annotations

import argparse
import json
import logging
import math
import sys
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import asdict
from pathlib import Path

from target_nav.app.detector_process import DetectorProcess, DetectorState
from target_nav.app.detector_program import detector_command
from target_nav.app.logs import CountedWarnings
from target_nav.app.process import StopSignal, report_ready, run_process
from target_nav.app.ros_support import RosNode, command_qos, latched_qos, require_ros, stream_qos
from target_nav.app.settings import add_config_arguments, config_from, parse_arguments, write_config
from target_nav.config import Config
from target_nav.detectors.pipeline import DetectionPipeline
from target_nav.errors import DeviceError, StaleInput
from target_nav.ipc import channels
from target_nav.state.snapshots import Calibration
from target_nav.state.types import DetectionFrame, RawDetectionFrame, TargetSpec
from target_nav.utils.latency import LatencyWindow

POLL_S = 0.004
NAV_EVERY_S = 0.1
NAV_MAX_AGE_S = 2.0
"""What a nav process said that runs no more, perhaps days ago, is not followed."""
CALIBRATION_EVERY_S = 1.0
REPORT_EVERY_S = 10.0

WAITING, LIVE, STALE, ENDED = "waiting", "live", "stale", "ended"

log = logging.getLogger(__name__)


class CameraNode:
    """`step` as often as possible. `tell` names whom to tell what others may want to know."""

    def __init__(self, config: Config, detector: DetectorProcess | None = None) -> None:
        prefix = config.ipc.prefix
        self.mode = WAITING
        self._config = config
        self._detector = detector
        self._restart_wanted = ""
        self._publish: Callable[[DetectionFrame], None] = lambda frame: None
        self._publish_mode: Callable[[str], None] = lambda mode: None
        self._pipeline = DetectionPipeline(config)
        self._spec = TargetSpec()
        self._raw = channels.open_reader(channels.DETECTIONS, prefix=prefix)
        self._nav = channels.open_reader(channels.NAV, prefix=prefix)
        self._det = channels.open_writer(channels.DET, prefix=prefix)
        self._calibration = channels.open_writer(channels.CALIBRATION, prefix=prefix)
        self._warnings = CountedWarnings(log)
        self._newest_s = -math.inf
        self._max_age_s = config.loop.camera_max_age_s
        self._nav_due_s = -math.inf
        self._calibration_due_s = -math.inf
        self._latency = LatencyWindow(REPORT_EVERY_S, time.monotonic())

    @property
    def counters(self) -> dict[str, int]:
        """What became of every box since the start, by layer."""
        return self._pipeline.counters.as_dict()

    def ask_restart(self, reason: str) -> None:
        """Have the detector started anew in the next `step`; from any thread."""
        self._restart_wanted = reason or "asked for"

    def step(self, now_s: float) -> None:
        """Raises DeviceError when the detector cannot be run; the stack is to be stopped then."""
        self._look_after_detector(now_s)
        self._follow_mission(now_s)
        raw = self._raw.take_new()
        if raw is not None:
            self._hand_on(raw, now_s)
        self._update_mode(now_s)
        self._report(now_s)

    def tell(self, publish: Callable[[DetectionFrame], None], publish_mode: Callable[[str], None]) -> None:
        """Whom to tell of every frame and of the mode from now on."""
        self._publish, self._publish_mode = publish, publish_mode
        publish_mode(self.mode)

    def close(self) -> None:
        if self._detector is not None:
            self._detector.close()
        for channel in (self._raw, self._nav, self._det, self._calibration):
            channel.close()

    def _look_after_detector(self, now_s: float) -> None:
        wanted, self._restart_wanted = self._restart_wanted, ""
        if self._detector is None:
            if wanted:
                log.warning(
                    "the detector was not started by this process and is not started anew: %s", wanted
                )
            return
        if wanted:
            self._detector.restart(wanted)
        self._detector.advance(now_s)

    def _hand_on(self, raw: RawDetectionFrame, now_s: float) -> None:
        age_s = now_s - raw.stamp_s
        if age_s > self._max_age_s:
            self._warnings.warn(
                "old",
                f"boxes are {age_s:.2f} s old (limit {self._max_age_s:.2f} s) and dropped; is the detector slow?",
            )
            return
        try:
            frame = self._pipeline.process(raw, self._spec)
        except StaleInput as error:
            self._warnings.warn("order", str(error))
            return
        self._det.write(frame)
        self._newest_s = frame.stamp_s
        self._latency.add(age_s)
        self._publish(frame)

    def _follow_mission(self, now_s: float) -> None:
        if now_s >= self._nav_due_s:
            self._nav_due_s = now_s + NAV_EVERY_S
            nav = self._nav.take_new()
            if nav is not None and nav.spec != self._spec and now_s - nav.stamp_s <= NAV_MAX_AGE_S:
                self._spec = nav.spec
                self._calibration_due_s = now_s
                if self._detector is not None:
                    self._detector.look_for(nav.spec.class_name)
                log.info(
                    "looking for %s, %.2f x %.2f m", nav.spec.class_name, nav.spec.height_m, nav.spec.width_m
                )
        if now_s >= self._calibration_due_s:
            self._calibration_due_s = now_s + CALIBRATION_EVERY_S
            self._calibration.write(calibration_of(self._config, self._spec, now_s))

    def _update_mode(self, now_s: float) -> None:
        age_s = now_s - self._newest_s
        mode = WAITING if math.isinf(age_s) else STALE if age_s > self._max_age_s else LIVE
        if mode != LIVE and self._detector is not None and self._detector.state is DetectorState.ENDED:
            mode = ENDED
        if mode == self.mode:
            return
        self.mode = mode
        self._publish_mode(mode)
        if mode == STALE:
            log.warning(
                "the newest picture is %.1f s old (limit %.1f s); does the detector run?",
                age_s,
                self._max_age_s,
            )
        else:
            log.info("the detector is %s", mode)

    def _report(self, now_s: float) -> None:
        summary = self._latency.take(now_s)
        if summary is not None:
            counts = ", ".join(f"{name} {count}" for name, count in self.counters.items())
            restarts = f"; detector restarts {self._detector.restarts}" if self._detector is not None else ""
            log.info("pictures to objects: %s; %s%s", summary, counts, restarts)


def calibration_of(config: Config, spec: TargetSpec, now_s: float) -> Calibration:
    camera = config.camera
    return Calibration(
        stamp_s=now_s,
        focal_x_px=camera.focal_px,
        focal_y_px=camera.focal_y_px,
        center_u_px=camera.center_u_px,
        center_v_px=camera.center_v_px,
        distortion=camera.lens,
        score_min=min(config.detector.propose_score, config.detector.score_min),
        class_name=spec.class_name,
    )


def detections_json(frame: DetectionFrame, counters: dict[str, int]) -> str:
    """`stamp_s` is monotonic time, as everywhere in this project; `counters` are those of the pipeline's layers."""
    return json.dumps({**asdict(frame), "counters": counters}, separators=(",", ":"))


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="camera_node", description="Boxes to objects with range and bearing, for the nav process."
    )
    add_config_arguments(parser)
    parser.add_argument("--no-ros", action="store_true", help="shared memory only, no topics")
    parser.add_argument(
        "--detector",
        metavar="SOURCE",
        help="start the detector on this source (sim, a camera, a video file, a folder of images) and watch it",
    )
    parser.add_argument("--detector-core", type=int, metavar="N", help="core the detector is pinned to")
    parser.add_argument(
        "--logs",
        type=Path,
        default=Path("runs/detector"),
        metavar="DIR",
        help="where the detector's log goes",
    )
    arguments = parse_arguments(parser)
    sys.exit(run_process("camera", lambda: _run(arguments)))


def _run(arguments: argparse.Namespace) -> None:
    config = config_from(arguments)
    with ExitStack() as stack:
        ros = None if arguments.no_ros else _ros_if_there(stack)
        detector = _detector(config, arguments) if arguments.detector is not None else None
        node = CameraNode(config, detector=detector)
        stack.callback(node.close)
        if ros is not None:
            _join_ros(node, ros)
        stop = ros.stop if ros is not None else stack.enter_context(StopSignal())
        if ros is not None:
            ros.start()
        report_ready()
        while not stop.wait(POLL_S):
            node.step(time.monotonic())
            if ros is not None:
                ros.check()
        log.info("stopped")


def _ros_if_there(stack: ExitStack) -> RosNode | None:
    """A node, or None where there is no ROS: the topics are for onlookers, the robot drives without them."""
    try:
        require_ros()
    except DeviceError as error:
        log.info("no topics: %s", error)
        return None
    return stack.enter_context(RosNode("camera_node"))


def _detector(config: Config, arguments: argparse.Namespace) -> DetectorProcess:
    arguments.logs.mkdir(parents=True, exist_ok=True)
    config_file = arguments.logs / "detector.yaml"
    write_config(config, config_file)
    options = ("--config", str(config_file))
    return DetectorProcess(
        lambda class_name: detector_command(config, arguments.detector, options, class_name),
        arguments.logs,
        arguments.detector_core,
    )


def _join_ros(node: CameraNode, ros: RosNode) -> None:
    from std_msgs.msg import String

    send = ros.publisher(String, "/detections", stream_qos())
    send_mode = ros.publisher(String, "/detector_mode", latched_qos())

    def publish(frame: DetectionFrame) -> None:
        send(String(data=detections_json(frame, node.counters)))

    def publish_mode(mode: str) -> None:
        send_mode(String(data=mode))

    node.tell(publish, publish_mode)
    ros.subscribe(String, "/drpai_restart", lambda message: node.ask_restart(message.data), command_qos())


if __name__ == "__main__":
    main()

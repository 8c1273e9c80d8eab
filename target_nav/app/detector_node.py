"""Process `detector`: pictures in, boxes out, by the detector that the mission names. The board has its own.

sim_camera, or a camera      in: pictures
calibration                  in: what the camera process wants: lowest score, class, lens
camera                       out: the pictures, for who wants to show them
detections                   out: the boxes of each, stamped with the time at which the picture was taken
"""

from __future__ import annotations

import argparse
import logging
import sys
import time
from collections.abc import Callable
from typing import Protocol

from target_nav.app.model_file import cpu_model, find_model, missing_model
from target_nav.app.process import EXIT_FAILED, EXIT_OK, StopSignal, report_ready, run_process
from target_nav.app.settings import add_config_arguments, config_from, parse_arguments
from target_nav.config import Config
from target_nav.detectors.detector import Detector
from target_nav.detectors.named import detector_for
from target_nav.detectors.onnx_detector import OnnxDetector
from target_nav.detectors.pin_pixels import PinPixelDetector
from target_nav.detectors.undistort import Undistorter
from target_nav.detectors.video_source import VideoSource
from target_nav.errors import ConfigError, DeviceError
from target_nav.ipc import channels
from target_nav.state.snapshots import Calibration, CameraFrame
from target_nav.state.target_label import TargetDetector
from target_nav.state.types import RawDetection, RawDetectionFrame
from target_nav.utils.latency import LatencyWindow

POLL_S = 0.003
REPORT_EVERY_S = 10.0
SIM = "sim"

log = logging.getLogger(__name__)


class FrameSource(Protocol):
    ended: str
    lost: bool

    def poll(self) -> CameraFrame | None: ...

    def close(self) -> None: ...


class SimSource:
    """The simulator's pictures. It never ends: a simulator that is gone may come back."""

    ended = ""
    lost = False

    def __init__(self, prefix: str) -> None:
        self._reader = channels.open_reader(channels.SIM_CAMERA, prefix=prefix)

    def poll(self) -> CameraFrame | None:
        return self._reader.take_new()

    def close(self) -> None:
        self._reader.close()


class DetectorNode:
    """One picture through the detector in each `step`."""

    def __init__(
        self,
        config: Config,
        source: FrameSource,
        detector: Detector,
        choose: Callable[[str], Detector] | None = None,
    ) -> None:
        """`detector` until a mission says what it looks for; then what `choose` makes of the target's label."""
        self._choose = choose
        prefix = config.ipc.prefix
        self._size = (config.camera.width_px, config.camera.height_px)
        self._source = source
        self._detector = detector
        self._undistorter = Undistorter()
        self._calibrations = channels.open_reader(channels.CALIBRATION, prefix=prefix)
        self._camera = channels.open_writer(channels.CAMERA, prefix=prefix)
        self._detections = channels.open_writer(channels.DETECTIONS, prefix=prefix)
        self._calibration: Calibration | None = None
        self._latency = LatencyWindow(REPORT_EVERY_S, time.monotonic())

    def step(self) -> bool:
        """Whether there was a picture.

        Raises:
            DeviceError: pictures of another size than configured; ranges would be wrong.
        """
        calibration = self._calibrations.take_new()
        if calibration is not None:
            self._follow(calibration)
        frame = self._source.poll()
        if frame is None:
            return False
        self._check_size(frame)
        image = self._undistorter.apply(frame.image_bgr, self._calibration)
        boxes = self._wanted(self._detector.detect(image))
        self._detections.write(RawDetectionFrame(frame.stamp_s, frame.frame_id, boxes))
        self._latency.add(time.monotonic() - frame.stamp_s)
        self._camera.write(CameraFrame(frame.stamp_s, frame.frame_id, image))
        return True

    def report(self, now_s: float) -> None:
        summary = self._latency.take(now_s)
        if summary is not None:
            log.info("pictures to boxes: %s", summary)

    def close(self) -> None:
        for channel in (self._calibrations, self._camera, self._detections):
            channel.close()

    def _follow(self, calibration: Calibration) -> None:
        wanted = calibration.class_name
        if self._calibration is None or self._calibration.class_name != wanted:
            self._take_detector(wanted)
            known = self._detector.class_names
            if wanted in known:
                log.info("looking for %s", wanted)
            else:
                log.warning("the mission wants %r; this detector finds only %s", wanted, ", ".join(known))
        self._calibration = calibration

    def _take_detector(self, label: str) -> None:
        """The detector for the label; the old one stays where there is none, and its boxes have another class."""
        if self._choose is None or label in self._detector.class_names:
            return
        try:
            self._detector = self._choose(label)
        except (ConfigError, DeviceError) as error:
            log.error("%s", error)

    def _wanted(self, boxes: tuple[RawDetection, ...]) -> tuple[RawDetection, ...]:
        if self._calibration is None:
            return boxes
        score_min = self._calibration.score_min
        return tuple(box for box in boxes if box.score >= score_min)

    def _check_size(self, frame: CameraFrame) -> None:
        height, width = frame.image_bgr.shape[:2]
        if (width, height) != self._size:
            raise DeviceError(
                f"pictures are {width}x{height}, the configuration has {self._size[0]}x{self._size[1]}: set "
                "camera.width_px, camera.height_px and the focal_px that belongs to them"
            )


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="detector_node", description="Finds the target in the camera's pictures."
    )
    add_config_arguments(parser)
    parser.add_argument(
        "--source", default=SIM, metavar="SOURCE", help="sim, a camera (0, /dev/video0) or a video file"
    )
    parser.add_argument(
        "--detector",
        default=TargetDetector.network.value,
        choices=(TargetDetector.network.value, TargetDetector.outline.value),
        help="for a pin; other targets have theirs",
    )
    parser.add_argument(
        "--rate",
        type=float,
        metavar="HZ",
        help="pictures a second, at most, of a camera or file (key camera.rate_hz)",
    )
    arguments = parse_arguments(parser)
    sys.exit(run_process("detector", lambda: _run(arguments)))


def _run(arguments: argparse.Namespace) -> int:
    config = config_from(arguments)
    if arguments.rate is not None:
        config = config.override({"camera.rate_hz": arguments.rate}, source="--rate")
    source = _open_source(arguments.source, config)
    node = DetectorNode(
        config,
        source,
        _default_detector(arguments.detector, config),
        lambda label: detector_for(label, lambda: cpu_model(config)),
    )
    try:
        with StopSignal() as stop:
            report_ready()
            while not source.ended and not stop.wait(POLL_S):
                node.step()
                node.report(time.monotonic())
    finally:
        node.close()
        source.close()
    if source.lost:
        log.error("%s", source.ended)
        return EXIT_FAILED
    log.info("%s", source.ended or "stopped")
    return EXIT_OK


def _default_detector(name: str, config: Config) -> Detector:
    """The network, or the outline where there is no file of it; a file that is not whole is not passed over."""
    if name == TargetDetector.network.value:
        if find_model(config, "cpu") is not None:
            return OnnxDetector(cpu_model(config))
        log.warning("%s; looking for the pin's outline instead", missing_model(config))
    return PinPixelDetector()


def _open_source(source: str, config: Config) -> FrameSource:
    if source == SIM:
        return SimSource(config.ipc.prefix)
    camera = config.camera
    return VideoSource(source, camera.width_px, camera.height_px, camera.rate_hz)


if __name__ == "__main__":
    main()

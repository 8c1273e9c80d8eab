"""The detector that a mission names."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from target_nav.detectors.apriltag import AprilTagDetector
from target_nav.detectors.colour import ColourDetector, TwoBoxDetector
from target_nav.detectors.detector import Detector
from target_nav.detectors.onnx_detector import OnnxDetector
from target_nav.detectors.pin_pixels import PinPixelDetector
from target_nav.errors import ConfigError
from target_nav.state.target_label import TargetDetector, split_label
from target_nav.utils import bowling_pin


def detector_for(label: str, model: Callable[[], Path]) -> Detector:
    """Every box it finds carries `label`, so that the camera process knows whose it is.

    `model` finds the network's file.

    Raises:
        ConfigError: there is no such detector, or it does not know what to look for.
        DeviceError: the network's file cannot be used.
    """
    kind, what = split_label(label)
    if kind in (TargetDetector.network, TargetDetector.outline) and what != bowling_pin.CLASS_NAME:
        raise ConfigError(f"the detector {kind.value!r} finds {bowling_pin.CLASS_NAME} only, not {what!r}")
    if kind is TargetDetector.network:
        return OnnxDetector(model(), label)
    if kind is TargetDetector.outline:
        return PinPixelDetector(label)
    if kind is TargetDetector.colour:
        return ColourDetector(what, label)
    if kind is TargetDetector.hsv:
        return ColourDetector(what, label, kind="hsv")
    if kind is TargetDetector.two_boxes:
        return TwoBoxDetector(what, label)
    if not what.isdecimal():
        raise ConfigError(f"an AprilTag is named by its number, not {what!r}")
    return AprilTagDetector(int(what), label)

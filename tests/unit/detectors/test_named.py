"""A mission names a detector; the label carries it to the detector process and back on every box."""

from __future__ import annotations

import pytest

from target_nav.app.model_file import cpu_model
from target_nav.config import Config
from target_nav.detectors.apriltag import AprilTagDetector
from target_nav.detectors.colour import ColourDetector, TwoBoxDetector
from target_nav.detectors.detector import Detector
from target_nav.detectors.named import detector_for
from target_nav.detectors.onnx_detector import OnnxDetector
from target_nav.detectors.pin_pixels import PinPixelDetector
from target_nav.errors import ConfigError


@pytest.mark.parametrize(
    ("label", "kind"),
    [
        ("bowling_pin", OnnxDetector),
        ("outline:bowling_pin", PinPixelDetector),
        ("colour:green", ColourDetector),
        ("hsv:orange", ColourDetector),
        ("two_boxes:green", TwoBoxDetector),
        ("apriltag:7", AprilTagDetector),
    ],
)
def test_each_label_has_its_detector_and_its_boxes_carry_the_label(label: str, kind: type[Detector]) -> None:
    detector = detector_for(label, lambda: cpu_model(Config()))
    assert type(detector) is kind
    assert detector.class_names == (label,)


@pytest.mark.parametrize(
    ("label", "words"),
    [
        ("cone", "finds bowling_pin only"),
        ("outline:cone", "finds bowling_pin only"),
        ("colour:mauve", "no colour 'mauve'"),
        ("apriltag:seven", "named by its number"),
        ("sonar:cat", "known: network"),
        ("colour:", "no detector for"),
    ],
)
def test_what_nobody_can_find_is_told(label: str, words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        detector_for(label, lambda: cpu_model(Config()))

"""The shipped network is as good as docs/model.md says: a small share of `python -m deploy.model.evaluate`.

Limits are those of the command, with room for the chance of few pictures. Seeds are not those that were reported.
"""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

import numpy as np
import pytest

from deploy.model.evaluate_photos import judge_duckpins, judge_negatives
from deploy.model.evaluate_rendered import judge_clipped, judge_rendered, judge_tracked
from deploy.model.limits import Figure
from target_nav.app.model_file import cpu_model
from target_nav.config import Config
from target_nav.detectors.onnx_detector import OnnxDetector

pytestmark = pytest.mark.slow

SCORE = Config().detector.score_min
DATA = Path(os.environ.get("TARGET_NAV_DATA", Path(__file__).parents[3] / "shared" / "data")) / "duckpins"


@pytest.fixture(scope="module")
def detector() -> OnnxDetector:
    return OnnxDetector(cpu_model(Config()), score_min=0.05)


def by_name(figures: list[Figure]) -> dict[str, float]:
    return {figure.name: figure.value for figure in figures}


def test_the_file_is_the_one_its_check_sum_says() -> None:
    path = cpu_model(Config())
    said = path.with_suffix(".onnx.sha256").read_text().split()[0]
    assert hashlib.sha256(path.read_bytes()).hexdigest() == said


def test_pins_in_rendered_rooms_are_found_and_measured(detector: OnnxDetector) -> None:
    figures = by_name(judge_rendered(detector, 80, SCORE, np.random.default_rng(5), None))
    assert figures["rendered 0.6-4 m: detection rate"] >= 0.95
    assert figures["rendered: range error p95, one frame"] <= 0.05


def test_tracking_makes_ranges_steadier(detector: OnnxDetector) -> None:
    figures = by_name(judge_tracked(detector, 3, SCORE, np.random.default_rng(6)))
    assert figures["rendered: range error p95, tracked"] <= 0.05


def test_what_the_border_cuts_is_never_believed(detector: OnnxDetector) -> None:
    figures = by_name(judge_clipped(detector, 20, SCORE, np.random.default_rng(7)))
    assert figures["clipped: cut boxes not flagged and > 10 % off"] == 0.0


@pytest.mark.skipif(not DATA.is_dir(), reason=f"no photographs of duckpins in {DATA}")
def test_real_duckpins_are_found_with_boxes_of_the_right_height(detector: OnnxDetector) -> None:
    figures = judge_duckpins(detector, DATA, SCORE, None)
    assert all(figure.holds for figure in figures), "\n".join(figure.text() for figure in figures)
    (false,) = judge_negatives(detector, [], DATA, SCORE, None)
    assert false.value == 0.0

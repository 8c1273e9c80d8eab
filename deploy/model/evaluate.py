"""How good the model is: `python -m deploy.model.evaluate [--model FILE] [--duckpins DIR] [--negatives DIR ...]`.

Four parts, each with the limit it is held to: real duckpins (weak labels), photographs without a pin, rendered
pictures from 0.6 to 4 m with what tracking makes of them, and boxes that the border cuts. Needs what the robot
needs and nothing of what training does. Exit 1 when a limit is missed.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from pathlib import Path

import cv2
import numpy as np

from deploy.model.evaluate_photos import judge_duckpins, judge_negatives
from deploy.model.evaluate_rendered import judge_clipped, judge_rendered, judge_tracked
from deploy.model.limits import Figure
from target_nav.config import Config
from target_nav.detectors.onnx_detector import OnnxDetector

MODEL = Path(__file__).parent / "bowling_pin.onnx"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--model", type=Path, default=MODEL)
    parser.add_argument("--duckpins", type=Path, help="folder with images/ and labels/")
    parser.add_argument(
        "--negatives", type=Path, nargs="*", default=[], help="photographs or folders, without a pin"
    )
    parser.add_argument("--score", type=float, default=Config().detector.score_min, help="the one threshold")
    parser.add_argument("--pictures", type=int, default=400, help="rendered ones")
    parser.add_argument("--seed", type=int, default=1000)
    parser.add_argument("--draw", type=Path, help="folder for pictures with what was found")
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    cv2.setNumThreads(1)
    detector = OnnxDetector(arguments.model, score_min=0.05)
    figures: list[Figure] = []
    if arguments.duckpins is not None:
        figures += judge_duckpins(detector, arguments.duckpins, arguments.score, arguments.draw)
    if arguments.negatives or arguments.duckpins is not None:
        figures += judge_negatives(
            detector, arguments.negatives, arguments.duckpins, arguments.score, arguments.draw
        )
    if arguments.pictures:
        rng = np.random.default_rng(arguments.seed)
        figures += judge_rendered(detector, arguments.pictures, arguments.score, rng, arguments.draw)
        figures += judge_tracked(detector, max(arguments.pictures // 20, 4), arguments.score, rng)
        figures += judge_clipped(detector, max(arguments.pictures // 4, 20), arguments.score, rng)
    for figure in figures:
        print(figure.text())
    if arguments.json is not None:
        values = {figure.name: None if math.isnan(figure.value) else figure.value for figure in figures}
        arguments.json.write_text(json.dumps(values, indent=1))
    sys.exit(0 if all(figure.holds for figure in figures) else 1)


if __name__ == "__main__":
    main()

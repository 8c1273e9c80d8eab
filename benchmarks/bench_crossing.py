"""How often ids swap when two pins pass each other in the picture. The scene is tests/unit/detectors/test_crossing."""

from __future__ import annotations

import numpy as np

from benchmarks import OURS, Row
from tests.unit.detectors.test_crossing import pass_by

RATIOS = (1.1, 1.25, 1.6, 2.5)
PASSES = 200
SEED = 31


def run() -> list[Row]:
    rows = []
    for ratio in RATIOS:
        rng = np.random.default_rng(SEED)
        swapped = more = 0
        for seed in range(PASSES):
            near_m = float(rng.uniform(0.8, 2.0))
            speed_mps = float(rng.uniform(0.1, 0.25) * rng.choice([-1, 1]))
            turn = float(rng.uniform(-0.1, 0.1))
            near, far = pass_by(
                near_m, near_m * ratio, speed_mps, turn, jitter=0.03, missed=0.06, seed=SEED + seed
            )
            swapped += bool(set(near) & set(far))
            more += len(near) + len(far) > 2
        note = f"of {PASSES}; an id too many in {more}"
        rows.append(Row(f"passes with a swap, ranges 1:{ratio:g}", OURS, float(swapped), "1", note=note))
    return rows

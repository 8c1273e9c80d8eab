"""Which cell of which head has to say what: a pin is the business of the few cells round its middle.

A head is chosen by the pin's size in the picture, with overlap, so that no size falls between two.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

STRIDES = (8, 16, 32)
WIDTH, HEIGHT = 320, 256
FRAME_TOP, FRAME_BOTTOM = 8, 248
SIZES = ((0.0, 64.0), (44.0, 150.0), (110.0, 1e9))
"""Of a pin, pixels, for each head."""
CENTER_STRIDES = 1.0
BEYOND_PX = 24.0
"""So far outside of the picture an edge may be said to lie: enough to know that it is not inside."""

Float32Array = NDArray[np.float32]


def centers() -> Float32Array:
    """(cells, 3): column and row of each cell's centre, and its stride; heads in order."""
    rows = []
    for stride in STRIDES:
        y, x = np.mgrid[0 : HEIGHT // stride, 0 : WIDTH // stride]
        rows.append(
            np.stack([(x + 0.5) * stride, (y + 0.5) * stride, np.full(x.shape, stride)], -1).reshape(-1, 3)
        )
    return np.concatenate(rows).astype(np.float32)


CENTERS = centers()
_LOW = np.concatenate([np.full(HEIGHT * WIDTH // s**2, SIZES[i][0]) for i, s in enumerate(STRIDES)])
_HIGH = np.concatenate([np.full(HEIGHT * WIDTH // s**2, SIZES[i][1]) for i, s in enumerate(STRIDES)])


def assign(boxes: Float32Array, ignored: Float32Array) -> Float32Array:
    """(cells, 6) for boxes in pixels of the network's input: state, l, t, r, b in strides, size.

    The state is 1 for a pin, 0 for none, -1 where it does not matter.
    """
    out = np.zeros((len(CENTERS), 6), np.float32)
    x, y, stride = CENTERS.T
    for box in ignored:
        out[(x > box[0]) & (x < box[2]) & (y > box[1]) & (y < box[3]), 0] = -1.0
    best = np.full(len(CENTERS), np.inf)
    low = np.array([0.0, FRAME_TOP, 0.0, FRAME_TOP], np.float32)
    high = np.array([WIDTH, FRAME_BOTTOM, WIDTH, FRAME_BOTTOM], np.float32)
    for box in boxes:
        seen = np.clip(box, low, high)
        target = np.clip(box, low - BEYOND_PX, high + BEYOND_PX)
        size = max(seen[3] - seen[1], 2.2 * (seen[2] - seen[0]))
        dx, dy = np.abs(x - 0.5 * (seen[0] + seen[2])), np.abs(y - 0.5 * (seen[1] + seen[3]))
        off = np.maximum(dx, dy) / stride
        mine = (off <= CENTER_STRIDES) & (size >= _LOW) & (size < _HIGH)
        mine &= dx * dx + dy * dy < best
        best[mine] = (dx * dx + dy * dy)[mine]
        out[mine, 0] = 1.0
        edges = np.stack([x - target[0], y - target[1], target[2] - x, target[3] - y], 1) / stride[:, None]
        out[mine, 1:5] = np.maximum(edges[mine], 0.0)
        out[mine, 5] = size
    return out

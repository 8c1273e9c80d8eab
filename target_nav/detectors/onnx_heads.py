"""The network's picture and its raw heads: letterbox before, boxes after. NumPy only but for the scaling.

The same rules as the C++ detector's decoder, so both give the same boxes from the same heads. Anchor-free, as in Tian
and others, *FCOS: Fully convolutional one-stage object detection*, ICCV 2019.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from target_nav.detectors.detector import ImageBgr
from target_nav.state.types import FloatArray

Float32Array = NDArray[np.float32]
INPUT_WIDTH, INPUT_HEIGHT = 320, 256
PAD_GREY = 114
HEAD_PLANES = 5
OVERLAP_MAX = 0.5
"""Two boxes that overlap by more (intersection over union) are one thing; the better one stays."""
SIDE_MIN_PX = 2.0
CANDIDATES_MAX = 512
BOXES_MAX = 64


def planes_of(image_bgr: ImageBgr) -> Float32Array:
    """float32 (1, 3, rows, columns), RGB, 0 to 1."""
    planes = image_bgr[:, :, ::-1].transpose(2, 0, 1)[None]
    return np.ascontiguousarray(planes, np.float32) * np.float32(1.0 / 255.0)


@dataclass(frozen=True)
class Letterbox:
    """How a frame lies in the network's input: input = frame * scale + (left, top)."""

    scale: float
    left: float
    top: float
    width: int
    height: int

    @classmethod
    def of(cls, frame_width: int, frame_height: int) -> Letterbox:
        scale = min(INPUT_WIDTH / frame_width, INPUT_HEIGHT / frame_height)
        width, height = round(scale * frame_width), round(scale * frame_height)
        return cls(scale, (INPUT_WIDTH - width) // 2, (INPUT_HEIGHT - height) // 2, width, height)

    def apply(self, image_bgr: ImageBgr) -> Float32Array:
        """The network's input, float32 (1, 3, INPUT_HEIGHT, INPUT_WIDTH), RGB, 0 to 1."""
        # At exactly one half both ways of shrinking are the mean of four pixels.
        method = cv2.INTER_AREA if self.scale < 1.0 else cv2.INTER_LINEAR
        scaled = cv2.resize(image_bgr, (self.width, self.height), interpolation=method)
        padded = np.full((INPUT_HEIGHT, INPUT_WIDTH, 3), PAD_GREY, np.uint8)
        left, top = int(self.left), int(self.top)
        padded[top : top + self.height, left : left + self.width] = scaled
        return planes_of(padded)


@dataclass(frozen=True)
class ScoredBox:
    """Edges in pixels of the frame, clipped at its borders."""

    score: float
    left: float
    top: float
    right: float
    bottom: float


def stride_of(head: Float32Array, input_height: int = INPUT_HEIGHT, input_width: int = INPUT_WIDTH) -> int:
    """Of one head (1, 5, rows, columns).

    Raises:
        ValueError: the array is no head of this network.
    """
    if head.ndim != 4 or head.shape[:2] != (1, HEAD_PLANES) or input_height % head.shape[2]:
        raise ValueError(
            f"an output has the shape {head.shape}; a head has (1, {HEAD_PLANES}, rows, columns)"
        )
    stride = input_height // head.shape[2]
    if head.shape[3] * stride != input_width:
        raise ValueError(
            f"a head has {head.shape[2]} x {head.shape[3]} cells; {input_height} x {input_width} pixels have not"
        )
    return int(stride)


def decode_heads(
    heads: Sequence[Float32Array],
    letterbox: Letterbox,
    frame_width: int,
    frame_height: int,
    score_min: float,
    input_height: int = INPUT_HEIGHT,
    input_width: int = INPUT_WIDTH,
) -> list[ScoredBox]:
    """Boxes of one frame, best score first.

    `heads` are float32 (1, 5, rows, columns): logit, then the distances l, t, r, b from a cell's centre to the edges in
    strides. Cells with numbers that are none are left out.
    """
    strides = [stride_of(head, input_height, input_width) for head in heads]
    ordered = sorted(zip(strides, heads), key=lambda pair: pair[0])
    rows = np.concatenate([_cells(head, stride) for stride, head in ordered])
    logit_min = _logit(score_min)
    with np.errstate(invalid="ignore"):
        rows = rows[(rows[:, 0] >= logit_min) & np.isfinite(rows).all(axis=1)]
    rows = rows[np.argsort(-rows[:, 0], kind="stable")[:CANDIDATES_MAX]]
    offset = np.array([letterbox.left, letterbox.top, letterbox.left, letterbox.top])
    limits = np.array([frame_width, frame_height, frame_width, frame_height], float)
    edges = np.clip((rows[:, 1:] - offset) / letterbox.scale, 0.0, limits)
    big = (edges[:, 2] - edges[:, 0] >= SIDE_MIN_PX) & (edges[:, 3] - edges[:, 1] >= SIDE_MIN_PX)
    edges, logits = edges[big], rows[big, 0]
    return [
        ScoredBox(1.0 / (1.0 + math.exp(-float(logits[i]))), *(float(value) for value in edges[i]))
        for i in _suppress(edges)
    ]


def _logit(score: float) -> float:
    if score <= 0.0:
        return -math.inf
    return math.log(score / (1.0 - score)) if score < 1.0 else math.inf


def _cells(head: Float32Array, stride: int) -> FloatArray:
    """(cells, 5): logit, left, top, right, bottom in pixels of the network's input."""
    planes = head[0].reshape(HEAD_PLANES, -1).astype(np.float64)
    y, x = np.divmod(np.arange(planes.shape[1]), head.shape[3])
    u, v = (x + 0.5) * stride, (y + 0.5) * stride
    left, top, right, bottom = planes[1:] * stride
    return np.stack([planes[0], u - left, v - top, u + right, v + bottom], axis=1)


def _suppress(edges: FloatArray) -> list[int]:
    """Greedy non-maximum suppression of boxes that come best first."""
    kept: list[int] = []
    areas = (edges[:, 2] - edges[:, 0]) * (edges[:, 3] - edges[:, 1])
    left = np.arange(len(edges))
    while left.size and len(kept) < BOXES_MAX:
        best, rest = left[0], left[1:]
        kept.append(int(best))
        sides = np.minimum(edges[rest, 2:], edges[best, 2:]) - np.maximum(edges[rest, :2], edges[best, :2])
        common = np.maximum(sides, 0.0).prod(axis=1)
        left = rest[common <= OVERLAP_MAX * (areas[rest] + areas[best] - common)]
    return kept

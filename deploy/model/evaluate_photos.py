"""The model on real photographs: duckpins with weak labels, and photographs without any pin."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from deploy.model.limits import Figure
from target_nav.detectors.detector import Detector, ImageBgr
from target_nav.state.types import RawDetection

FRAME = (640, 480)
FOUND_OVERLAP = 0.5
LANE_MIDDLE = 0.483
"""Of the photograph's width: the column of the front pin."""
PIN_FREE_WINDOWS = ((0.0, 0.5, 0.5, 1.0), (0.25, 0.53, 0.72, 1.0), (0.5, 0.5, 1.0, 1.0), (0.0, 0.0, 0.22, 0.32),
                    (0.74, 0.0, 1.0, 0.35), (0.72, 0.3, 1.0, 0.72), (0.0, 0.3, 0.2, 0.6))  # fmt: skip
"""Shares of a duckpin photograph: boards, walls and machinery. The scene never changes, so one photograph is used."""
SUFFIXES = {".jpg", ".jpeg", ".png", ".webp", ".bmp"}
Edges = tuple[float, float, float, float]


def judge_duckpins(detector: Detector, folder: Path, score: float, draw: Path | None) -> list[Figure]:
    """Recall, precision and heights at one threshold; the figure of the threshold that would be best beside it."""
    hits: list[tuple[float, bool, float]] = []
    labels_total = pictures = 0
    for name, frame, labels in _duckpin_frames(folder):
        found = detector.detect(frame)
        pictures += 1
        labels_total += len(labels)
        rows = _match(found, labels)
        hits += rows
        if draw is not None:
            _save(draw / f"duckpins_{name}.png", frame, found, score, labels)
    at = [row for row in hits if row[0] >= score]
    true = sum(row[1] for row in at)
    heights = [row[2] for row in at if row[1]]
    best, best_score = _best_threshold(hits, labels_total)
    note = (
        f"{true} of {labels_total} pins in {pictures} photographs, {len(at) - true} others, score {score:g}"
    )
    return [
        Figure("duckpins: recall", true / max(labels_total, 1), low=0.95, note=note),
        Figure("duckpins: precision", true / max(len(at), 1), low=0.95),
        Figure("duckpins: box height / label, median - 1", float(np.median(heights)) - 1.0 if heights else math.nan,
               -0.03, 0.03),
        Figure("duckpins: best of min(recall, precision)", best, note=f"at score {best_score:.2f}"),
    ]  # fmt: skip


def _duckpin_frames(folder: Path) -> Iterator[tuple[str, ImageBgr, list[Edges]]]:
    for path in sorted((folder / "images").glob("*.jpg")):
        image = cv2.imread(str(path))
        if image is None:
            raise SystemExit(f"{path} cannot be read as a picture")
        rows, columns = image.shape[:2]
        width = round(rows * FRAME[0] / FRAME[1])
        left = min(max(round(LANE_MIDDLE * columns - 0.5 * width), 0), columns - width)
        frame = cv2.resize(image[:, left : left + width], FRAME, interpolation=cv2.INTER_AREA)
        scale = FRAME[1] / rows
        labels: list[Edges] = []
        for line in (folder / "labels" / f"{path.stem}.txt").read_text().splitlines():
            _, cx, cy, w, h = (float(value) for value in line.split()[:5])
            u, v = (cx * columns - left) * scale, cy * rows * scale
            half_w, half_h = 0.5 * w * columns * scale, 0.5 * h * rows * scale
            labels.append((u - half_w, v - half_h, u + half_w, v + half_h))
        yield path.stem[-6:], np.asarray(frame, np.uint8), labels


def _match(found: Sequence[RawDetection], labels: list[Edges]) -> list[tuple[float, bool, float]]:
    """(score, is a pin, height over the label's) of each box, best score first; a label is given once."""
    free = set(range(len(labels)))
    rows = []
    for box in found:
        edges = _edges(box)
        best = max(free, key=lambda i: overlap(edges, labels[i]), default=None)
        if best is not None and overlap(edges, labels[best]) >= FOUND_OVERLAP:
            free.discard(best)
            rows.append((box.score, True, box.height_px / (labels[best][3] - labels[best][1])))
        else:
            rows.append((box.score, False, math.nan))
    return rows


def _best_threshold(hits: list[tuple[float, bool, float]], labels: int) -> tuple[float, float]:
    best, at = 0.0, math.nan
    for score in sorted({row[0] for row in hits}):
        kept = [row for row in hits if row[0] >= score]
        true = sum(row[1] for row in kept)
        value = min(true / max(labels, 1), true / max(len(kept), 1))
        if value > best:
            best, at = value, score
    return best, at


def judge_negatives(
    detector: Detector, given: Iterable[Path], duckpins: Path | None, score: float, draw: Path | None
) -> list[Figure]:
    """False boxes on photographs without a pin, each seen through one or more windows of 4:3."""
    photographs = false = windows = 0
    worst: list[tuple[float, str]] = []
    sources = [(path.stem, list(_windows(_read(path)))) for path in _photographs(given)]
    if duckpins is not None:
        sources += [("duckpin lane", list(_pin_free(duckpins)))]
    for name, views in sources:
        photographs += 1
        for index, view in enumerate(views):
            windows += 1
            found = [box for box in detector.detect(view) if box.score >= score]
            false += len(found)
            worst += [(box.score, name) for box in found]
            if draw is not None and found:
                _save(draw / f"false_{name}_{index}.png", view, found, score, [])
    note = f"{false} boxes, {windows} windows of {photographs} photographs"
    if worst:
        note += (
            f"; worst: {', '.join(f'{name} {value:.2f}' for value, name in sorted(worst, reverse=True)[:4])}"
        )
    return [Figure("without a pin: false boxes a window", false / max(windows, 1), high=0.02, note=note)]


def _photographs(given: Iterable[Path]) -> Iterator[Path]:
    for path in given:
        if path.is_dir():
            yield from sorted(p for p in path.rglob("*") if p.suffix.lower() in SUFFIXES)
        else:
            yield path


def _read(path: Path) -> ImageBgr:
    image = cv2.imread(str(path), cv2.IMREAD_COLOR)
    if image is None:
        raise SystemExit(f"{path} cannot be read as a picture")
    return np.asarray(image, np.uint8)


def _windows(image: ImageBgr) -> Iterator[ImageBgr]:
    """The middle 4:3 of a photograph, the rest of it, and its quarters if it is large."""
    rows, columns = image.shape[:2]
    width, height = min(columns, rows * 4 // 3), min(rows, columns * 3 // 4)
    across, down = (0, columns - width), (0, rows - height)
    places = {(across[0], down[0]), (across[1], down[1]), (across[1] // 2, down[1] // 2)}
    for x, y in sorted(places):
        yield _frame(image[y : y + height, x : x + width])
    if width >= 2 * FRAME[0] // 2 and height >= 400:
        for x in (0, columns - width // 2):
            for y in (0, rows - height // 2):
                yield _frame(image[y : y + height // 2, x : x + width // 2])


def _frame(image: NDArray[np.uint8]) -> ImageBgr:
    method = cv2.INTER_AREA if image.shape[1] > FRAME[0] else cv2.INTER_LINEAR
    return np.asarray(cv2.resize(image, FRAME, interpolation=method), np.uint8)


def _pin_free(folder: Path) -> Iterator[ImageBgr]:
    first = sorted((folder / "images").glob("*.jpg"))[0]
    image = _read(first)
    rows, columns = image.shape[:2]
    for left, top, right, bottom in PIN_FREE_WINDOWS:
        yield _frame(image[int(top * rows) : int(bottom * rows), int(left * columns) : int(right * columns)])


def _edges(box: RawDetection) -> Edges:
    half_w, half_h = 0.5 * box.width_px, 0.5 * box.height_px
    return box.u_px - half_w, box.v_px - half_h, box.u_px + half_w, box.v_px + half_h


def overlap(a: Edges, b: Edges) -> float:
    """Intersection over union."""
    width, height = min(a[2], b[2]) - max(a[0], b[0]), min(a[3], b[3]) - max(a[1], b[1])
    if width <= 0.0 or height <= 0.0:
        return 0.0
    common = width * height
    return common / ((a[2] - a[0]) * (a[3] - a[1]) + (b[2] - b[0]) * (b[3] - b[1]) - common)


def _save(
    path: Path, frame: ImageBgr, found: Sequence[RawDetection], score: float, labels: list[Edges]
) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    picture = frame.copy()
    for label in labels:
        cv2.rectangle(picture, (int(label[0]), int(label[1])), (int(label[2]), int(label[3])), (0, 200, 0), 1)
    for box in found:
        left, top, right, bottom = (round(value) for value in _edges(box))
        colour = (0, 255, 255) if box.score >= score else (255, 100, 0)
        cv2.rectangle(picture, (left, top), (right, bottom), colour, 1)
        cv2.putText(picture, f"{box.score:.2f}", (left, top - 2), cv2.FONT_HERSHEY_PLAIN, 0.8, colour, 1)
    cv2.imwrite(str(path), picture)

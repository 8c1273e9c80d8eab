"""Backgrounds of small bright parts: circuit boards, breadboards, shelves of parcels and books, print.

What looks like a pin in them is a capacitor, a connector, a bottle's label: white, upright, with a band or a waist.
"""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

Rng = np.random.Generator
Picture = NDArray[np.float32]


def circuit(rng: Rng, rows: int, columns: int) -> Picture:
    """A board, level or turned, with parts, rows of pins, tracks, print and jumper wires; BGR (rows, columns, 3)."""
    side = int(math.hypot(rows, columns)) + 2
    board = _bare(rng, side)
    unit = float(np.exp(rng.uniform(math.log(3.0), math.log(14.0))))
    for _ in range(int(rng.integers(10, 90))):
        _track(rng, board, unit)
    for _ in range(int(rng.integers(10, 70))):
        _part(rng, board, unit)
    for _ in range(int(rng.integers(0, 14))):
        _wire(rng, board, unit)
    turn = float(rng.choice([0.0, 0.5 * math.pi, rng.uniform(-math.pi, math.pi)]))
    matrix = cv2.getRotationMatrix2D((0.5 * side, 0.5 * side), math.degrees(turn), 1.0)
    matrix[:, 2] += (0.5 * (columns - side), 0.5 * (rows - side))
    turned = cv2.warpAffine(board, matrix, (columns, rows), borderMode=cv2.BORDER_REFLECT)
    soft = cv2.GaussianBlur(turned, (0, 0), float(rng.uniform(0.4, 1.2)))
    ramp = np.linspace(rng.uniform(0.5, 1.2), rng.uniform(0.5, 1.2), columns, dtype=np.float32)
    return np.asarray(soft * ramp[None, :, None], np.float32)


def shelf(rng: Rng, rows: int, columns: int) -> Picture:
    """Rows of upright things side by side: books, parcels, bottles, with bands and labels; BGR (rows, columns, 3)."""
    picture = np.full((rows, columns, 3), rng.uniform(10, 120), np.float32)
    foot = float(rng.uniform(20, 80))
    while foot < rows + 60:
        reach = float(rng.uniform(20, 110))
        u = float(rng.uniform(-20, 0))
        while u < columns:
            w, h = reach * float(rng.uniform(0.12, 0.5)), reach * float(rng.uniform(0.6, 1.0))
            _upright(rng, picture, u, foot, w, h)
            u += w * float(rng.choice([1.0, 1.05, rng.uniform(1.0, 2.0)]))
        board = int(rng.integers(2, 8))
        cv2.rectangle(picture, (0, int(foot)), (columns, int(foot) + board), _loud(rng), -1)
        foot += reach + board + float(rng.uniform(5, 30))
    return picture


def _bare(rng: Rng, side: int) -> Picture:
    kinds = ((60, 110, 20), (120, 60, 20), (30, 25, 25), (40, 40, 150), (225, 230, 232), (40, 60, 50))
    base = np.array(kinds[int(rng.integers(len(kinds)))]) * rng.uniform(0.6, 1.15) + rng.normal(0, 10, 3)
    board = np.tile(np.clip(base, 5, 250).astype(np.float32), (side, side, 1))
    if rng.random() < 0.35:
        pitch = float(rng.uniform(3, 9))
        y, x = np.mgrid[0:side, 0:side]
        hole = (np.mod(x, pitch) < 0.4 * pitch) & (np.mod(y, pitch) < 0.4 * pitch)
        board[hole] *= rng.uniform(0.2, 0.8)
        for _ in range(int(rng.integers(0, 5))):
            at = int(rng.integers(side))
            colour = (40, 40, 200) if rng.random() < 0.5 else (200, 60, 40)
            cv2.line(board, (0, at), (side, at), colour, 1)
    return board


def _loud(rng: Rng) -> tuple[float, float, float]:
    kind = rng.random()
    if kind < 0.35:
        value = float(rng.uniform(190, 255))
        return value, value, value
    if kind < 0.55:
        return float(rng.uniform(10, 90)), float(rng.uniform(10, 90)), float(rng.uniform(130, 240))
    if kind < 0.75:
        value = float(rng.uniform(5, 80))
        return value, value, value
    blue, green, red = (float(value) for value in rng.uniform(0, 255, 3))
    return blue, green, red


def _place(rng: Rng, board: Picture) -> tuple[int, int]:
    return int(rng.integers(board.shape[1])), int(rng.integers(board.shape[0]))


def _track(rng: Rng, board: Picture, unit: float) -> None:
    points = [np.array(_place(rng, board), float)]
    for _ in range(int(rng.integers(1, 5))):
        way = rng.uniform(2, 25) * unit
        angle = 0.25 * math.pi * int(rng.integers(8))
        points.append(points[-1] + way * np.array([math.cos(angle), math.sin(angle)]))
    colour = np.clip(board[0, 0] * rng.uniform(0.6, 1.6), 0, 255).tolist()
    cv2.polylines(board, [np.int32(points)], False, colour, max(int(0.3 * unit), 1), cv2.LINE_AA)
    cv2.circle(
        board, tuple(np.int32(points[-1]).tolist()), max(int(0.5 * unit), 1), _loud(rng), -1, cv2.LINE_AA
    )


def _part(rng: Rng, board: Picture, unit: float) -> None:
    """A chip, a two-ended part with bands, a can, a row of pins, or a word."""
    u, v = _place(rng, board)
    kind = int(rng.integers(6))
    along, across = (1, 0) if rng.random() < 0.5 else (0, 1)
    colour, other = _loud(rng), _loud(rng)
    if kind == 0:
        w, h = int(unit * rng.uniform(2, 12)), int(unit * rng.uniform(2, 12))
        for k in range(0, w, max(int(unit), 2)):
            cv2.line(board, (u + k, v - int(unit)), (u + k, v + h + int(unit)), (200, 205, 205), 1)
        cv2.rectangle(board, (u, v), (u + w, v + h), colour, -1)
    elif kind in (1, 2):
        long, wide = unit * float(rng.uniform(2, 8)), unit * float(rng.uniform(0.6, 2.5))
        for k, share in enumerate(sorted(rng.uniform(0, 1, int(rng.integers(1, 5))), reverse=True)):
            reach = np.array([along, across]) * long * (1.0 if k == 0 else share)
            half = (
                0.5
                * wide
                * np.array([across, along])
                * (1.0 if rng.random() < 0.6 else rng.uniform(0.5, 1.0))
            )
            a, b = np.int32(np.array([u, v]) - half), np.int32(np.array([u, v]) + half + reach)
            cv2.rectangle(board, a.tolist(), b.tolist(), _loud(rng) if k else colour, -1)
    elif kind == 3:
        radius = max(int(unit * rng.uniform(0.6, 3.0)), 2)
        cv2.circle(board, (u, v), radius, colour, -1, cv2.LINE_AA)
        cv2.circle(board, (u, v), int(radius * rng.uniform(0.3, 0.9)), other, -1, cv2.LINE_AA)
        if rng.random() < 0.5:
            w, h = int(radius * rng.uniform(0.5, 1.0)), int(radius * rng.uniform(1.0, 4.0))
            cv2.rectangle(board, (u - w, v), (u + w, v + h), other, -1)
    elif kind == 4:
        for k in range(int(rng.integers(2, 20))):
            at = (int(u + k * unit * along), int(v + k * unit * across))
            cv2.circle(board, at, max(int(0.35 * unit), 1), colour, -1, cv2.LINE_AA)
            if across == 0:
                cv2.line(board, at, (at[0], at[1] - int(1.5 * unit)), other, max(int(0.3 * unit), 1))
    else:
        text = "".join(chr(int(c)) for c in rng.integers(48, 91, int(rng.integers(1, 9))))
        print_ = np.zeros((int(4 * unit) + 6, int(20 * unit) + 20), np.uint8)
        font, size = int(rng.integers(0, 5)), 0.06 * unit + 0.15
        cv2.putText(print_, text, (1, print_.shape[0] - 4), font, size, 255, 1, cv2.LINE_AA)
        region = board[v : v + print_.shape[0], u : u + print_.shape[1]]
        share = print_[: region.shape[0], : region.shape[1], None] / np.float32(255.0)
        region += share * (np.array(colour, np.float32) - region)


def _wire(rng: Rng, board: Picture, unit: float) -> None:
    a, b = np.array(_place(rng, board), float), np.array(_place(rng, board), float)
    bow = 0.5 * (a + b) + rng.normal(0, 12 * unit, 2)
    t = np.linspace(0, 1, 24)[:, None]
    points = np.int32((1 - t) ** 2 * a + 2 * t * (1 - t) * bow + t**2 * b)
    cv2.polylines(board, [points], False, _loud(rng), max(int(rng.uniform(0.3, 1.2) * unit), 1), cv2.LINE_AA)
    for end in (points[0], points[-1]):
        reach = np.array([max(int(0.5 * unit), 1), max(int(rng.uniform(0.5, 2.5) * unit), 1)])
        cv2.rectangle(board, (end - reach).tolist(), (end + reach).tolist(), _loud(rng), -1)


def _upright(rng: Rng, picture: Picture, u: float, foot: float, w: float, h: float) -> None:
    left, right, top = int(u), int(u + w), int(foot - h)
    cv2.rectangle(picture, (left, top), (right, int(foot)), _loud(rng), -1)
    for _ in range(int(rng.integers(0, 4))):
        low = int(foot - h * rng.uniform(0, 1))
        cv2.rectangle(
            picture, (left, low), (right, low + max(int(h * rng.uniform(0.02, 0.25)), 1)), _loud(rng), -1
        )
    if rng.random() < 0.3:
        neck, shoulder = int(w * rng.uniform(0.1, 0.35)), top + int(h * rng.uniform(0.1, 0.4))
        for a, b in ((left, left + neck), (right - neck, right)):
            cv2.rectangle(picture, (a, top), (b, shoulder), (30.0, 30.0, 30.0), -1)

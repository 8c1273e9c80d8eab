"""Backgrounds without a pin: rooms, lanes, heaps of shapes (dead leaves), clouds of noise, the dark.

A dead-leaves picture has the edges and the scales of natural pictures (Lee, Mumford and Huang, *Occlusion models for
natural images*, IJCV 41, 2001), which keeps a network trained on drawings from seeing pins in photographs.
"""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

ImageBgr = NDArray[np.uint8]
Rng = np.random.Generator
WIDTH, HEIGHT = 400, 300


def a_background(rng: Rng) -> ImageBgr:
    """One picture of WIDTH x HEIGHT."""
    kinds = (_room, _dead_leaves, _lane, _clouds, _dark, _structure)
    chosen = int(rng.choice(len(kinds), p=(0.32, 0.26, 0.14, 0.08, 0.08, 0.12)))
    return np.ascontiguousarray(np.clip(kinds[chosen](rng), 0, 255).astype(np.uint8))


def _colour(rng: Rng) -> NDArray[np.float64]:
    """Mostly the muted colours of rooms; now and then a loud one."""
    value = rng.uniform(15, 245)
    return np.clip(value + rng.normal(0, 1, 3) * (12 if rng.random() < 0.7 else 70), 0, 255)


def noise_picture(rng: Rng, rows: int, columns: int, slope: float) -> NDArray[np.float32]:
    """Noise with the power of frequency^-`slope`, mean 0, sigma 1: 0 is white, about 1 is what nature looks like."""
    f = np.hypot(np.fft.fftfreq(rows)[:, None], np.fft.rfftfreq(columns)[None, :])
    f[0, 0] = 1.0
    spectrum = (rng.normal(size=f.shape) + 1j * rng.normal(size=f.shape)) * f**-slope
    spectrum[0, 0] = 0.0
    picture = np.fft.irfft2(spectrum, s=(rows, columns))
    return (picture / (picture.std() + 1e-9)).astype(np.float32)


def texture(rng: Rng, rows: int, columns: int) -> NDArray[np.float32]:
    """Wood, stripes, tiles, checks, plaster, print, or one colour; float32 (rows, columns, 3)."""
    base = _colour(rng)
    picture = np.tile(base.astype(np.float32), (rows, columns, 1))
    kind = int(rng.integers(8))
    y, x = np.mgrid[0:rows, 0:columns].astype(np.float32)
    other = np.clip(base + rng.normal(0, 45, 3), 0, 255).astype(np.float32)
    if kind == 1:
        grain = noise_picture(rng, max(rows // 8, 2), columns, 0.8)
        picture += 14.0 * cv2.resize(grain, (columns, rows))[:, :, None]
    elif kind in (2, 3):
        period, angle = float(rng.uniform(4, 50)), float(rng.choice([0, math.pi / 2, rng.uniform(0, 3.1)]))
        wave = np.mod(x * math.cos(angle) + y * math.sin(angle), period) < period * rng.uniform(0.1, 0.6)
        picture[wave] = other
    elif kind == 4:
        period = float(rng.uniform(10, 60))
        joint = (np.mod(x, period) < 1.5) | (np.mod(y + rng.uniform(0, period), period) < 1.5)
        picture[joint] *= rng.uniform(0.4, 1.3)
    elif kind == 5:
        period = float(rng.uniform(6, 40))
        picture[(np.floor(x / period) + np.floor(y / period)) % 2 > 0] = other
    elif kind == 6:
        print_ = np.zeros((rows, columns), np.uint8)
        for _ in range(int(rng.integers(3, 16))):
            place = (int(rng.integers(columns)), int(rng.integers(rows)))
            text = "".join(chr(int(c)) for c in rng.integers(48, 91, int(rng.integers(1, 8))))
            font, size = int(rng.integers(0, 5)), float(rng.uniform(0.3, 2.5))
            cv2.putText(print_, text, place, font, size, 255, int(rng.integers(1, 4)), cv2.LINE_AA)
        picture += (print_ / np.float32(255.0))[:, :, None] * (other - picture)
    sigma = float(rng.uniform(0, 12))
    small = noise_picture(rng, max(rows // 2, 2), max(columns // 2, 2), float(rng.uniform(0.2, 1.5)))
    return np.asarray(picture + sigma * cv2.resize(small, (columns, rows))[:, :, None], np.float32)


def _room(rng: Rng) -> NDArray[np.float32]:
    horizon = int(rng.uniform(0.15, 0.75) * HEIGHT)
    picture = texture(rng, HEIGHT, WIDTH)
    floor = texture(rng, 300, 300)
    spread = float(rng.uniform(1.2, 8.0))
    middle = float(rng.uniform(-0.5, 1.5) * WIDTH)
    goal = np.array(
        [(0.5 * WIDTH + 0.3 * (middle - 0.5 * WIDTH) - 0.6 * WIDTH, horizon),
         (0.5 * WIDTH + 0.3 * (middle - 0.5 * WIDTH) + 0.6 * WIDTH, horizon),
         (middle + 0.5 * spread * WIDTH, HEIGHT + 5), (middle - 0.5 * spread * WIDTH, HEIGHT + 5)], np.float32
    )  # fmt: skip
    source = np.array([(0, 0), (300, 0), (300, 300), (0, 300)], np.float32)
    warped = cv2.warpPerspective(
        floor, cv2.getPerspectiveTransform(source, goal), (WIDTH, HEIGHT), borderMode=cv2.BORDER_REFLECT
    )
    for _ in range(int(rng.integers(0, 8))):
        _panel(rng, picture, horizon)
    picture[horizon:] = warped[horizon:]
    if rng.random() < 0.5:
        thickness = int(rng.integers(1, 12))
        picture[max(horizon - thickness, 0) : horizon] *= rng.uniform(0.3, 1.3)
    for _ in range(int(rng.integers(0, 6))):
        _furniture(rng, picture, horizon)
    if rng.random() < 0.6:
        ramp = np.linspace(rng.uniform(0.5, 1.2), rng.uniform(0.5, 1.2), WIDTH, dtype=np.float32)
        picture *= ramp[None, :, None]
    return picture


def _panel(rng: Rng, picture: NDArray[np.float32], horizon: int) -> None:
    """A poster, door, window or shelf on the wall."""
    w, h = int(rng.uniform(8, 140)), int(rng.uniform(15, 220))
    x, y = int(rng.integers(-20, WIDTH)), int(rng.integers(-40, max(horizon, 1)))
    inner = texture(rng, h, w)
    _put(picture, inner, x, y)
    if rng.random() < 0.6:
        cv2.rectangle(picture, (x, y), (x + w, y + h), _colour(rng).tolist(), int(rng.integers(1, 5)))


def _furniture(rng: Rng, picture: NDArray[np.float32], horizon: int) -> None:
    """A box on the floor, a table's legs, a bright upright stripe."""
    kind = rng.random()
    foot = int(rng.uniform(horizon, HEIGHT + 30))
    x = int(rng.integers(-30, WIDTH))
    if kind < 0.5:
        w, h = int(rng.uniform(15, 160)), int(rng.uniform(15, 150))
        _put(picture, texture(rng, h, w), x, foot - h)
        side = int(rng.uniform(0, 0.5) * w)
        if side > 2:
            _put(picture, np.asarray(texture(rng, h, side) * 0.6, np.float32), x + w, foot - h)
    elif kind < 0.8:
        colour = _colour(rng).tolist()
        h, t = int(rng.uniform(20, 150)), int(rng.integers(2, 9))
        for k in range(int(rng.integers(1, 5))):
            left = x + k * int(rng.uniform(12, 60))
            cv2.line(picture, (left, foot), (left + int(rng.normal(0, 4)), foot - h), colour, t, cv2.LINE_AA)
        cv2.line(picture, (x - 10, foot - h), (x + 150, foot - h), colour, t, cv2.LINE_AA)
    else:
        w, h = int(rng.uniform(3, 25)), int(rng.uniform(20, 200))
        cv2.rectangle(picture, (x, foot - h), (x + w, foot), (rng.uniform(190, 255, 3)).tolist(), -1)


def _put(picture: NDArray[np.float32], patch: NDArray[np.float32], x: int, y: int) -> None:
    x0, y0 = max(x, 0), max(y, 0)
    x1, y1 = min(x + patch.shape[1], picture.shape[1]), min(y + patch.shape[0], picture.shape[0])
    if x1 > x0 and y1 > y0:
        picture[y0:y1, x0:x1] = patch[y0 - y : y1 - y, x0 - x : x1 - x]


def _dead_leaves(rng: Rng) -> NDArray[np.float32]:
    picture = texture(rng, HEIGHT, WIDTH)
    count = int(rng.integers(20, 160))
    sizes = np.sort(1.0 / np.sqrt(rng.uniform(1 / 110**2, 1 / 5**2, count)))[::-1]
    for size in sizes:
        center = (int(rng.integers(0, WIDTH)), int(rng.integers(0, HEIGHT)))
        mask = np.zeros((HEIGHT, WIDTH), np.uint8)
        kind = int(rng.integers(4))
        if kind == 0:
            cv2.circle(mask, center, int(size), 255, -1, cv2.LINE_AA)
        elif kind == 1:
            axes = (int(size) + 1, int(size * rng.uniform(0.1, 0.9)) + 1)
            cv2.ellipse(mask, center, axes, float(rng.uniform(0, 180)), 0, 360, 255, -1, cv2.LINE_AA)
        else:
            n = int(rng.integers(3, 8))
            angles = np.sort(rng.uniform(0, 2 * math.pi, n))
            reach = size * rng.uniform(0.3, 1.4, n)
            points = np.stack([np.cos(angles) * reach, np.sin(angles) * reach], 1) * [
                1.0,
                rng.uniform(0.3, 3),
            ]
            cv2.fillPoly(mask, [np.int32(points + center)], 255, cv2.LINE_AA)
        x, y, w, h = cv2.boundingRect(mask)
        if w == 0 or h == 0:
            continue
        share = mask[y : y + h, x : x + w, None].astype(np.float32) / 255.0
        patch = texture(rng, h, w) if size > 18 and rng.random() < 0.5 else _colour(rng).astype(np.float32)
        if rng.random() < 0.4:
            patch = patch * np.linspace(rng.uniform(0.4, 1.0), rng.uniform(0.6, 1.4), w)[None, :, None]
        region = picture[y : y + h, x : x + w]
        region[:] = region * (1 - share) + patch * share
    return picture


def _lane(rng: Rng) -> NDArray[np.float32]:
    """Boards that run to a dark pit between two walls, from a camera above them."""
    picture = np.full((HEIGHT, WIDTH, 3), rng.uniform(0, 40), np.float32)
    picture += 4.0 * noise_picture(rng, HEIGHT, WIDTH, 1.2)[:, :, None]
    near, far = int(rng.uniform(0.45, 0.9) * HEIGHT), int(rng.uniform(0.0, 0.35) * HEIGHT)
    u = float(rng.uniform(0.3, 0.7) * WIDTH)
    half_near, half_far = rng.uniform(0.25, 0.6) * WIDTH, rng.uniform(0.12, 0.3) * WIDTH
    wood = np.clip(np.array([150, 190, 215]) * rng.uniform(0.5, 1.15) + rng.normal(0, 15, 3), 0, 255)
    boards = np.tile(wood, (64, 256, 1))
    for column in range(0, 256, int(rng.integers(4, 14))):
        boards[:, column : column + 14] *= rng.uniform(0.82, 1.1)
        boards[:, column] *= 0.75
    deck = np.tile(_colour(rng) * rng.uniform(0.1, 0.6), (64, 256, 1))
    deck += 3 * noise_picture(rng, 64, 256, 1.0)[:, :, None]
    half_end = half_near * rng.uniform(1.2, 2.0)
    _quad(
        picture,
        deck,
        [(u - half_far, far), (u + half_far, far), (u + half_near, near), (u - half_near, near)],
    )
    ends = [(u + half_end, HEIGHT + 60), (u - half_end, HEIGHT + 60)]
    _quad(picture, boards, [(u - half_near, near), (u + half_near, near), *ends])
    for sign in (-1, 1):
        wall = texture(rng, 64, 64) * rng.uniform(0.3, 1.0)
        top = far - rng.uniform(20, 120)
        corners = [(u + sign * half_far * 1.05, far), (u + sign * half_far * 1.05, top),
                   (u + sign * half_end * 1.3, top - rng.uniform(0, 200)),
                   (u + sign * half_end * 1.2, HEIGHT + 80)]  # fmt: skip
        if rng.random() < 0.8:
            _quad(picture, wall, corners)
    for _ in range(int(rng.integers(0, 6))):
        _panel(rng, picture, max(far, 2)) if rng.random() < 0.5 else _furniture(rng, picture, near)
    return picture


def _quad(
    picture: NDArray[np.float32], patch: NDArray[np.float32], corners: list[tuple[float, float]]
) -> None:
    rows, columns = patch.shape[:2]
    source = np.array([(0, 0), (columns, 0), (columns, rows), (0, rows)], np.float32)
    matrix = cv2.getPerspectiveTransform(source, np.array(corners, np.float32))
    warped = cv2.warpPerspective(
        patch.astype(np.float32), matrix, (WIDTH, HEIGHT), borderMode=cv2.BORDER_REPLICATE
    )
    mask = np.zeros((HEIGHT, WIDTH), np.uint8)
    cv2.fillConvexPoly(mask, np.int32(np.round(corners)), 255, cv2.LINE_AA)
    share = mask[:, :, None].astype(np.float32) / 255.0
    picture[:] = picture * (1 - share) + warped * share


def _clouds(rng: Rng) -> NDArray[np.float32]:
    slope = float(rng.uniform(0.6, 2.0))
    light = noise_picture(rng, HEIGHT, WIDTH, slope)
    tint = np.stack([noise_picture(rng, HEIGHT, WIDTH, slope) for _ in range(3)], 2)
    return np.asarray(
        _colour(rng) + rng.uniform(5, 60) * light[:, :, None] + rng.uniform(0, 20) * tint, np.float32
    )


def _dark(rng: Rng) -> NDArray[np.float32]:
    """Night: little of a room, and a few lamps."""
    picture = _room(rng) * float(rng.uniform(0.02, 0.3))
    for _ in range(int(rng.integers(0, 6))):
        center = (int(rng.integers(WIDTH)), int(rng.integers(HEIGHT)))
        halo = np.zeros((HEIGHT, WIDTH, 3), np.float32)
        cv2.circle(halo, center, int(rng.integers(1, 14)), rng.uniform(120, 255, 3).tolist(), -1, cv2.LINE_AA)
        picture += cv2.GaussianBlur(halo, (0, 0), float(rng.uniform(0.5, 9)))
    return picture


def _structure(rng: Rng) -> NDArray[np.float32]:
    """Bars, pipes, leaves of grass, cables: thin things in all directions."""
    picture = texture(rng, HEIGHT, WIDTH)
    lean = float(rng.uniform(0, math.pi))
    for _ in range(int(rng.integers(20, 200))):
        start = rng.uniform((-20, -20), (WIDTH + 20, HEIGHT + 20))
        angle = lean + rng.normal(0, rng.choice([0.05, 0.4, 2.0]))
        end = start + rng.uniform(10, 200) * np.array([math.cos(angle), math.sin(angle)])
        cv2.line(picture, np.int32(start).tolist(), np.int32(end).tolist(), _colour(rng).tolist(),
                 int(rng.integers(1, 9)), cv2.LINE_AA)  # fmt: skip
    return picture

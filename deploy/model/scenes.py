"""Pictures with their boxes: pins, look-alikes and clutter put on a background, far ones first.

Boxes are those of whole pins, also of what another thing hides; a pin of which too little shows is neither to be found
nor to be missed, and so is one that lies down or is too small.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from deploy.model.backgrounds import a_background
from deploy.model.bodies import Sprite
from deploy.model.degrade import degrade
from deploy.model.figures import a_figure
from deploy.model.shapes import a_pin, an_odd_thing

ImageBgr = NDArray[np.uint8]
Rng = np.random.Generator
WIDTH, HEIGHT = 320, 240
"""What the network sees of a 640x480 frame; rows are added above and below afterwards."""
VISIBLE_MIN = 0.40
IN_PICTURE_MIN = 0.25
HIDDEN_BELOW = 0.05
"""Of which nothing shows at all is not there."""
HEIGHT_MIN_PX = 13.0
RACK_PITCH = 1.1
"""Ten-pins stand 12 inches apart at 15 inches height (0.8), duckpins 12 at 9.4 (1.28); here in between, varied."""


@dataclass(frozen=True, eq=False)
class Scene:
    """`boxes` (N, 4): left, top, right, bottom in pixels, beyond the borders where the pin goes on; so `ignored`."""

    image_bgr: ImageBgr
    boxes: NDArray[np.float32]
    ignored: NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Bank:
    """What scenes are put together from."""

    pins: list[Sprite]
    odd: list[Sprite]
    backgrounds: list[ImageBgr]


def make_bank(rng: Rng, pins: int, odd: int, backgrounds: int) -> Bank:
    figures = odd // 3
    return Bank(
        [a_pin(rng) for _ in range(pins)],
        [an_odd_thing(rng) for _ in range(odd - figures)] + [a_figure(rng) for _ in range(figures)],
        [a_background(rng) for _ in range(backgrounds)],
    )


@dataclass
class _Placed:
    sprite: Sprite
    foot_u: float
    foot_v: float
    height_px: float
    tilt_rad: float
    flip: bool
    upright: bool = True
    gain: float = 1.0


class _Painter:
    """The picture and, per pixel, the number of the thing seen there (0: none)."""

    def __init__(self, picture: NDArray[np.float32]) -> None:
        self.picture = picture
        self.owner = np.zeros(picture.shape[:2], np.uint8)
        self.areas: list[tuple[float, float]] = []
        """Of each thing: pixels of all of it, and of what lies in the picture."""

    def paint(self, thing: _Placed, number: int, reflection: float) -> None:
        if reflection > 0.0:
            self._warp(thing, 0, reflection)
        self._warp(thing, number, 0.0)

    def _warp(self, thing: _Placed, number: int, reflection: float) -> None:
        sprite = thing.sprite
        scale = thing.height_px / sprite.height_px
        level = 0
        while scale < 0.75 and level + 1 < len(sprite.levels):
            scale, level = 2.0 * scale, level + 1
        patch = sprite.levels[level]
        size = np.array([patch.shape[1], patch.shape[0]], float)
        shrink = size / np.array([sprite.levels[0].shape[1], sprite.levels[0].shape[0]])
        foot = np.array(sprite.foot) * shrink
        cos, sin = math.cos(thing.tilt_rad) * scale, math.sin(thing.tilt_rad) * scale
        mirror = -1.0 if thing.flip else 1.0
        turn = np.array([[cos * mirror, -sin], [sin * mirror, cos]])
        if reflection:
            turn[1] *= -1.0
        shift = np.array([thing.foot_u, thing.foot_v]) - turn @ foot
        corners = np.array([(0, 0), (size[0], 0), size, (0, size[1])]) @ turn.T + shift
        x0, y0 = np.floor(corners.min(axis=0)).astype(int) - 1
        x1, y1 = np.ceil(corners.max(axis=0)).astype(int) + 1
        rows, columns = self.owner.shape
        cx0, cy0, cx1, cy1 = max(x0, 0), max(y0, 0), min(x1, columns), min(y1, rows)
        alpha_all = float(patch[:, :, 3].sum()) / 255.0 * scale * scale
        inside = 0.0
        if cx1 > cx0 and cy1 > cy0:
            # warpAffine counts from the middle of the first pixel
            matrix = np.column_stack([turn, shift - (cx0, cy0) + turn @ (0.5, 0.5) - 0.5])
            warped = cv2.warpAffine(patch, matrix, (cx1 - cx0, cy1 - cy0), flags=cv2.INTER_LINEAR).astype(
                np.float32
            )
            alpha = warped[:, :, 3:] / 255.0
            if reflection:
                fade = np.clip(1.0 - (np.arange(cy0, cy1) - thing.foot_v) / (0.9 * thing.height_px), 0.0, 1.0)
                strength = (reflection * fade).astype(np.float32)[:, None, None]
                warped, alpha = warped * strength, alpha * strength
            region = self.picture[cy0:cy1, cx0:cx1]
            region[:] = region * (1.0 - alpha) + warped[:, :, :3] * thing.gain
            if not reflection:
                solid = alpha[:, :, 0] > 0.5
                inside = float(alpha.sum())
                self.owner[cy0:cy1, cx0:cx1][solid] = number
        if not reflection:
            self.areas.append((max(alpha_all, 1.0), inside))


def make_scene(bank: Bank, rng: Rng) -> Scene:
    """One picture of WIDTH x HEIGHT with its boxes."""
    picture = _background(bank, rng)
    camera = _Ground(rng)
    things = _arrange(bank, rng, camera)
    things.sort(key=lambda thing: thing.foot_v if thing.upright else -1e9)
    painter = _Painter(picture)
    reflection = float(rng.uniform(0.05, 0.5)) if rng.random() < 0.35 else 0.0
    shadow = float(rng.uniform(0.0, 0.7)) if rng.random() < 0.7 else 0.0
    for number, thing in enumerate(things, 1):
        if shadow and thing.upright:
            _shadow(picture, thing, shadow, rng)
        painter.paint(thing, number, reflection if thing.upright else 0.0)
    _occluders(painter, bank, rng)
    seen = np.bincount(painter.owner.ravel(), minlength=256)
    boxes, ignored = [], []
    for number, (thing, area) in enumerate(zip(things, painter.areas), 1):
        if thing.sprite.is_pin:
            box = _box_of(thing)
            if area[1] < 2.0 or seen[number] < HIDDEN_BELOW * area[1]:
                continue
            good = thing.upright and box[3] - box[1] >= HEIGHT_MIN_PX
            good = good and area[1] / area[0] >= IN_PICTURE_MIN and seen[number] >= VISIBLE_MIN * area[1]
            (boxes if good else ignored).append(box)
    image = degrade(np.clip(picture, 0, 255).astype(np.uint8), rng)
    return Scene(image, _array(boxes), _array(ignored))


def _array(boxes: list[NDArray[np.float32]]) -> NDArray[np.float32]:
    return np.array(boxes, np.float32).reshape(-1, 4)


def _background(bank: Bank, rng: Rng) -> NDArray[np.float32]:
    source = bank.backgrounds[int(rng.integers(len(bank.backgrounds)))]
    scale = float(rng.uniform(0.82, 1.0))
    w, h = int(WIDTH / scale * 1.0), int(HEIGHT / scale * 1.0)
    w, h = min(w, source.shape[1]), min(h, source.shape[0])
    x, y = int(rng.integers(0, source.shape[1] - w + 1)), int(rng.integers(0, source.shape[0] - h + 1))
    crop = source[y : y + h, x : x + w]
    if rng.random() < 0.5:
        crop = crop[:, ::-1]
    picture = cv2.resize(crop, (WIDTH, HEIGHT), interpolation=cv2.INTER_LINEAR).astype(np.float32)
    if rng.random() < 0.5:
        picture = picture[:, :, rng.permutation(3)]
    return np.ascontiguousarray(picture * float(np.exp(rng.normal(0.0, 0.3))))


class _Ground:
    """A floor seen by a camera: where a foot at a depth is, and how tall a pin is there (in pin heights and pixels)."""

    def __init__(self, rng: Rng) -> None:
        self.focal = float(rng.uniform(0.7, 2.2)) * WIDTH
        self.height = float(np.exp(rng.uniform(math.log(0.3), math.log(4.0))))
        self.horizon = float(rng.uniform(-0.3, 0.75)) * HEIGHT if rng.random() < 0.6 else 0.5 * HEIGHT

    def scale_at(self, depth: float) -> float:
        return self.focal / depth

    def foot_v(self, depth: float) -> float:
        return self.horizon + self.focal * self.height / depth


def _log_height(rng: Rng, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(math.log(low), math.log(high))))


def _arrange(bank: Bank, rng: Rng, ground: _Ground) -> list[_Placed]:
    things: list[_Placed] = []
    kind = rng.random()
    if kind < 0.10:
        pass
    elif kind < 0.35:
        things += _rack(bank, rng)
        things += [_anywhere(_pick(bank.pins, rng), rng) for _ in range(int(rng.integers(0, 3)))]
    elif kind < 0.65:
        things += [_on_ground(_pick(bank.pins, rng), rng, ground) for _ in range(int(rng.integers(1, 9)))]
    else:
        things += [_anywhere(_pick(bank.pins, rng), rng) for _ in range(int(rng.integers(1, 8)))]
    for _ in range(int(rng.choice([0, 2, 5, 9, 14], p=[0.1, 0.25, 0.3, 0.25, 0.1]))):
        sprite = _pick(bank.odd, rng)
        things.append(_on_ground(sprite, rng, ground) if rng.random() < 0.4 else _anywhere(sprite, rng))
    if rng.random() < 0.12:
        lying = _anywhere(_pick(bank.pins, rng), rng)
        lying.tilt_rad = float(rng.choice([-1, 1])) * float(rng.uniform(0.9, 2.3))
        lying.upright = False
        things.append(lying)
    return things[:60]


def _pick(sprites: list[Sprite], rng: Rng) -> Sprite:
    return sprites[int(rng.integers(len(sprites)))]


def _on_ground(sprite: Sprite, rng: Rng, ground: _Ground) -> _Placed:
    scale = _log_height(rng, 14.0, 110.0) if rng.random() < 0.85 else _log_height(rng, 110.0, 330.0)
    depth = ground.focal / scale
    u = float(rng.uniform(-0.05, 1.05)) * WIDTH
    size = 1.0 if sprite.is_pin else float(np.exp(rng.normal(0.0, 0.5)))
    v = min(ground.foot_v(depth), HEIGHT + 0.7 * scale)
    return _Placed(
        sprite, u, v, scale * size, float(rng.normal(0, 0.025)), bool(rng.random() < 0.5), gain=_gain(rng)
    )


def _anywhere(sprite: Sprite, rng: Rng) -> _Placed:
    height = _log_height(rng, 14.0, 130.0) if rng.random() < 0.85 else _log_height(rng, 130.0, 420.0)
    u = float(rng.uniform(-0.03, 1.03)) * WIDTH
    if height > 0.8 * HEIGHT:
        v = float(rng.uniform(0.5 * HEIGHT + 0.3 * height, 0.5 * HEIGHT + 0.75 * height))
    else:
        v = float(rng.uniform(0.35 * height, HEIGHT + 0.6 * height))
    return _Placed(
        sprite, u, v, height, float(rng.normal(0, 0.04)), bool(rng.random() < 0.5), gain=_gain(rng)
    )


def _rack(bank: Bank, rng: Rng) -> list[_Placed]:
    """A triangle of equal pins, some of them gone, seen from the front and a little from above."""
    first = int(rng.integers(len(bank.pins)))
    many = [bank.pins[first]] if rng.random() < 0.7 else [_pick(bank.pins, rng) for _ in range(3)]
    front = _log_height(rng, 20.0, 110.0)
    pitch_px = front * RACK_PITCH * float(rng.uniform(0.7, 1.35))
    rise = front * float(rng.uniform(0.05, 0.6))
    shrink = float(rng.uniform(0.84, 0.97))
    u, v = float(rng.uniform(0.2, 0.8)) * WIDTH, float(rng.uniform(0.35, 1.0)) * HEIGHT
    keep = float(rng.uniform(0.5, 1.0))
    fall = float(rng.uniform(0.75, 1.0))
    gain, tilt = _gain(rng), float(rng.normal(0, 0.02))
    things = []
    factor, row_v = 1.0, v
    for row in range(int(rng.integers(2, 5))):
        for k in range(row + 1):
            if rng.random() > keep:
                continue
            offset = (k - 0.5 * row) * pitch_px * factor + float(rng.normal(0, 0.02 * front))
            height = front * factor
            things.append(
                _Placed(_pick(many, rng), u + offset, row_v + float(rng.normal(0, 0.01 * front)), height,
                        tilt + float(rng.normal(0, 0.015)), bool(rng.random() < 0.5), gain=gain * fall**row)
            )  # fmt: skip
        row_v -= rise * factor
        factor *= shrink
    return things


def _gain(rng: Rng) -> float:
    return float(np.clip(np.exp(rng.normal(-0.1, 0.25)), 0.4, 1.25))


def _shadow(picture: NDArray[np.float32], thing: _Placed, strength: float, rng: Rng) -> None:
    radius = 0.22 * thing.height_px
    if radius < 1.5:
        return
    shift = float(rng.normal(0, 0.1)) * thing.height_px
    u0, u1 = int(thing.foot_u + shift - 2 * radius), int(thing.foot_u + shift + 2 * radius)
    v0, v1 = int(thing.foot_v - 0.6 * radius), int(thing.foot_v + 0.6 * radius)
    u0, v0, u1, v1 = max(u0, 0), max(v0, 0), min(u1, WIDTH), min(v1, HEIGHT)
    if u1 <= u0 or v1 <= v0:
        return
    y, x = np.mgrid[v0:v1, u0:u1].astype(np.float32)
    off = ((x - thing.foot_u - shift) / (1.6 * radius)) ** 2 + ((y - thing.foot_v) / (0.5 * radius)) ** 2
    picture[v0:v1, u0:u1] *= (1.0 - strength * np.clip(1.0 - off, 0, 1))[:, :, None]


def _occluders(painter: _Painter, bank: Bank, rng: Rng) -> None:
    """Bars, boards and things right before the camera; they hide, and what they hide is counted."""
    if rng.random() > 0.25:
        return
    rows, columns = painter.owner.shape
    for _ in range(int(rng.integers(1, 3))):
        w, h = int(rng.uniform(3, 60)), int(rng.uniform(20, 240))
        x, y = int(rng.integers(0, columns)), int(rng.integers(0, rows))
        shade = np.clip(rng.uniform(0, 255) + rng.normal(0, 20, 3), 0, 255)
        region = (slice(y, min(y + h, rows)), slice(x, min(x + w, columns)))
        painter.picture[region] = shade
        painter.owner[region] = 0


def _box_of(thing: _Placed) -> NDArray[np.float32]:
    cos, sin = math.cos(thing.tilt_rad), math.sin(thing.tilt_rad)
    mirror = -1.0 if thing.flip else 1.0
    points = thing.sprite.outline @ np.array([[cos * mirror, -sin], [sin * mirror, cos]], np.float32).T
    points = points * thing.height_px + np.array([thing.foot_u, thing.foot_v], np.float32)
    return np.array([*points.min(axis=0), *points.max(axis=0)], np.float32)

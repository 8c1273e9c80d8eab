"""Pins and things that look like pins, as cut-out pictures: surfaces of revolution seen from any height.

The tables (radius, colour, normal by height) are the simulator's own; here the camera may look down, as a person's or a
lane's camera does, so every pixel's ray is followed in steps until it meets the surface.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from target_nav.sim.render_revolved import Revolved

Float32Array = NDArray[np.float32]
STEPS = 18
SUPERSAMPLE = 2
MARGIN = 0.06
"""Free border of the cut-out, of its height."""


@dataclass(frozen=True)
class Light:
    """One lamp and what comes from everywhere. Directions in the camera's frame: right, up, towards the camera."""

    ambient: float = 0.5
    diffuse: float = 0.5
    right: float = 0.3
    up: float = 0.6
    toward: float = 0.6
    gloss: float = 0.1
    gloss_power: float = 20.0


@dataclass(frozen=True, eq=False)
class Sprite:
    """A cut-out: `levels` are premultiplied BGRA uint8 pictures, each half as large as the one before.

    `outline` (N, 2) are points on its edge relative to its foot, v down, as shares of its standing height.
    """

    levels: tuple[NDArray[np.uint8], ...]
    foot: tuple[float, float]
    height_px: float
    outline: Float32Array
    is_pin: bool


def draw_sprite(
    body: Revolved,
    pitch_rad: float,
    distance: float,
    light: Light,
    height_px: int,
    is_pin: bool,
    grain: Float32Array | None = None,
) -> Sprite:
    """`distance` in heights of the body; the camera looks at its middle, `pitch_rad` down.

    `grain` is a picture of factors around 1 (any size) laid over the surface: dirt, wear, print.
    """  # fmt: skip
    scale = height_px * SUPERSAMPLE
    half_width = body.max_radius_m / body.height_m
    reach = half_width * abs(math.sin(pitch_rad))
    rows = math.ceil((math.cos(pitch_rad) + 2.2 * reach + 2 * MARGIN) * scale / SUPERSAMPLE) * SUPERSAMPLE
    columns = math.ceil((2.3 * half_width + 2 * MARGIN) * scale / SUPERSAMPLE) * SUPERSAMPLE
    v = (0.5 * rows - np.arange(rows, dtype=np.float32) - 0.5)[:, None] / (scale * distance)
    u = (np.arange(columns, dtype=np.float32) + 0.5 - 0.5 * columns)[None, :] / (scale * distance)
    colours, cover = _trace(body, pitch_rad, distance, u, v, light, grain)
    bgra = np.dstack([np.minimum(colours, 255.0) * cover[:, :, None], 255.0 * cover])
    bgra = cv2.resize(bgra, (columns // SUPERSAMPLE, rows // SUPERSAMPLE), interpolation=cv2.INTER_AREA)
    picture = np.rint(bgra).astype(np.uint8)
    levels = [picture]
    while min(levels[-1].shape[:2]) > 6:
        small = levels[-1]
        levels.append(
            cv2.resize(small, (small.shape[1] // 2, small.shape[0] // 2), interpolation=cv2.INTER_AREA)
        )
    foot_v = 0.5 * picture.shape[0] + height_px * 0.5 * math.cos(pitch_rad)
    foot = (0.5 * picture.shape[1], foot_v)
    return Sprite(tuple(levels), foot, float(height_px), _outline(picture, foot, height_px), is_pin)


def _trace(
    body: Revolved,
    pitch_rad: float,
    distance: float,
    u: Float32Array,
    v: Float32Array,
    light: Light,
    grain: Float32Array | None,
) -> tuple[Float32Array, Float32Array]:
    """Colours (rows, columns, 3) and hits (rows, columns). Lengths are in heights of the body."""
    sin, cos = math.sin(pitch_rad), math.cos(pitch_rad)
    forward = cos + v * sin
    rise_all = -sin + v * cos
    level = np.sqrt(forward * forward + u * u)
    # The camera sits `distance` from the body's middle; its ground distance to the axis:
    ground, camera_h = np.float32(distance * cos), np.float32(0.5 + distance * sin)
    sin_a, cos_a = u / level, forward / level
    b, abeam = ground * sin_a, ground * cos_a
    rise = rise_all / level
    radii = body.radii_m / np.float32(body.height_m)
    top = np.float32(radii.size - 1)
    r_max = float(radii.max())

    def index_at(s: Float32Array) -> NDArray[np.int32]:
        return np.clip((camera_h + (abeam + s) * rise) * top, 0.0, top).astype(np.int32)

    def inside(s: Float32Array) -> Float32Array:
        height = camera_h + (abeam + s) * rise
        value = radii[index_at(s)] ** 2 - b * b - s * s
        return np.where((height < 0.0) | (height > 1.0), np.float32(-1e-3), value)

    shape = np.broadcast_shapes(u.shape, v.shape)
    hit = np.zeros(shape, bool)
    entry = np.zeros(shape, np.float32)
    before = np.full(shape, -1e-3, np.float32)
    step = np.float32(2.0 * r_max / STEPS)
    for i in range(STEPS + 1):
        s = np.full(shape, -r_max + i * float(step), np.float32)
        value = inside(s)
        new = (value >= 0.0) & ~hit
        share = before / np.minimum(before - value, -1e-9)
        entry = np.where(new, s - step * (1.0 - np.clip(share, 0.0, 1.0)), entry)
        hit |= new
        before = value
    index = index_at(entry)
    radius = np.maximum(radii[index], 1e-4)
    side, toward = np.clip(b / radius, -1.0, 1.0), np.clip(-entry / radius, -1.0, 1.0)
    flat, up = body.flat[index], body.up[index]
    norm = math.sqrt(light.right**2 + light.up**2 + light.toward**2)
    lr, lu, lt = light.right / norm, light.up / norm, light.toward / norm
    lambert = np.maximum(flat * (side * lr + toward * lt) + up * lu, 0.0)
    half = np.array([lr, lu, lt + 1.0])
    half /= np.linalg.norm(half)
    mirror = np.maximum(flat * (side * half[0] + toward * half[2]) + up * half[1], 0.0) ** light.gloss_power
    shade = light.ambient + light.diffuse * lambert
    if grain is not None:
        shade = shade * cv2.resize(grain, (shape[1], shape[0]), interpolation=cv2.INTER_LINEAR)
    colours = body.colours_bgr[index] * shade[:, :, None] + (255.0 * light.gloss * mirror)[:, :, None]
    return colours.astype(np.float32), hit.astype(np.float32)


def _outline(picture: NDArray[np.uint8], foot: tuple[float, float], height_px: float) -> Float32Array:
    """The outermost half-covered places of every row and column, to a part of a pixel."""
    alpha = picture[:, :, 3].astype(np.float32) / 255.0
    rows = np.flatnonzero(alpha.max(axis=1) > 0.5)
    columns = np.flatnonzero(alpha.max(axis=0) > 0.5)
    points: list[tuple[float, float]] = []
    for row in rows:
        where = np.flatnonzero(alpha[row] > 0.5)
        for column, sign in ((where[0], -1), (where[-1], 1)):
            beyond = column + sign
            part = float(alpha[row, beyond]) if 0 <= beyond < alpha.shape[1] else 0.0
            points.append((column + 0.5 + sign * (0.5 + part), row + 0.5))
    for column in columns:
        where = np.flatnonzero(alpha[:, column] > 0.5)
        for row, sign in ((where[0], -1), (where[-1], 1)):
            beyond = row + sign
            part = float(alpha[beyond, column]) if 0 <= beyond < alpha.shape[0] else 0.0
            points.append((column + 0.5, row + 0.5 + sign * (0.5 + part)))
    if not points:
        return np.zeros((0, 2), np.float32)
    return ((np.array(points) - np.array(foot)) / height_px).astype(np.float32)

"""What the bodies look like: pins of many makes, and upright things that must not be taken for one."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from deploy.model.bodies import Light, Sprite, draw_sprite
from target_nav.sim.render_revolved import PROFILES, Revolved, revolved_from
from target_nav.utils import bowling_pin

Rng = np.random.Generator
Bgr = tuple[float, float, float]
FloatArray = NDArray[np.float64]

SHARES = np.linspace(0.0, 1.0, 257)
TEN_PIN = bowling_pin.width_at(SHARES)
_DUCK = np.array(
    [(0.0, 0.36), (0.05, 0.55), (0.12, 0.76), (0.20, 0.92), (0.28, 0.99), (0.33, 1.0), (0.42, 0.95), (0.52, 0.78),
     (0.60, 0.56), (0.66, 0.42), (0.71, 0.36), (0.76, 0.36), (0.82, 0.40), (0.88, 0.43), (0.93, 0.42), (0.97, 0.31),
     (0.99, 0.18), (1.0, 0.0)]
)  # fmt: skip
"""A duckpin's outline: squatter than a ten-pin's, thick neck, small head. Heights and widths as shares."""
DUCK_PIN = np.interp(SHARES, _DUCK[:, 0], _DUCK[:, 1])
PIN_WIDTHS = ((0.27, 0.36), (0.36, 0.47))
"""Width to height of slim pins (ten-pins, toys) and of squat ones."""

ODD_PROFILES = {
    "tall bottle": [(0, 0.9), (0.03, 1), (0.5, 1), (0.62, 0.7), (0.7, 0.36), (0.95, 0.34), (0.96, 0.42), (1, 0.4)],
    "squat bottle": [(0, 0.95), (0.05, 1), (0.6, 1), (0.75, 0.8), (0.85, 0.4), (1, 0.4)],
    "candle": [(0, 1), (0.95, 1), (0.96, 0.15), (1, 0.05)],
    "lamp": [(0, 0.5), (0.03, 0.5), (0.05, 0.12), (0.6, 0.12), (0.61, 1.0), (1, 0.6)],
    "goblet": [(0, 0.7), (0.04, 0.6), (0.08, 0.14), (0.45, 0.14), (0.6, 0.7), (0.8, 1.0), (1, 0.9)],
    "pawn": [(0, 1), (0.08, 1), (0.15, 0.75), (0.3, 0.45), (0.55, 0.32), (0.6, 0.55), (0.64, 0.55), (0.66, 0.36),
             (0.76, 0.58), (0.86, 0.62), (0.95, 0.42), (1, 0)],
    "hydrant": [(0, 1), (0.08, 1), (0.1, 0.7), (0.7, 0.7), (0.72, 0.9), (0.76, 0.9), (0.8, 0.65), (0.95, 0.4),
                (1, 0.1)],
    "bollard": [(0, 1), (0.9, 1), (0.97, 0.8), (1, 0.3)],
    "pear": [(0, 0.5), (0.1, 0.85), (0.3, 1.0), (0.6, 0.75), (0.9, 0.5), (1, 0)],
    "bulb": [(0, 0.42), (0.25, 0.42), (0.4, 0.6), (0.7, 1.0), (0.9, 0.8), (1, 0)],
    "upside pin": [(1 - h, w) for h, w in zip(bowling_pin.PROFILE_HEIGHTS[::-1], bowling_pin.PROFILE_WIDTHS[::-1])],
    "double": [(0, 0.8), (0.15, 1), (0.4, 0.9), (0.5, 0.75), (0.6, 0.9), (0.85, 0.95), (1, 0.5)],
    "snowman": [(0, 0.5), (0.1, 0.85), (0.28, 1), (0.46, 0.8), (0.54, 0.55), (0.62, 0.75), (0.72, 0.85),
                (0.82, 0.7), (0.9, 0.6), (1, 0)],
}  # fmt: skip
ODD_WIDTHS = {"cone": (0.5, 1.0), "ball": (0.95, 1.0), "cup": (0.6, 1.1), "vase": (0.35, 0.7), "candle": (0.08, 0.4),
              "bollard": (0.15, 0.5), "lamp": (0.3, 0.7), "bulb": (0.5, 0.7), "goblet": (0.35, 0.6)}  # fmt: skip


def a_pin(rng: Rng, height_px: int = 224) -> Sprite:
    """A pin of any make, clean or worn, in any light, from a level view to 35 degrees from above."""
    squat = rng.random() < 0.45
    mix = rng.beta(0.5, 0.5) if rng.random() < 0.3 else float(squat)
    widths = TEN_PIN + mix * (DUCK_PIN - TEN_PIN)
    widths = widths * (1.0 + 0.05 * _wobble(rng))
    low, high = PIN_WIDTHS[int(squat)]
    aspect = float(rng.uniform(low, high))
    colours = _pin_colours(rng)
    body = revolved_from(SHARES, widths / widths.max(), colours, 1.0, 0.5 * aspect)
    grain = _grain(rng, 0.10) if rng.random() < 0.7 else None
    return draw_sprite(body, _pitch(rng), _distance(rng), _light(rng), height_px, True, grain)


def an_odd_thing(rng: Rng, height_px: int = 160) -> Sprite:
    """Bottles, cones, candles, pawns, pins on their head, turned things of no name; many are red and white."""
    names = [*ODD_PROFILES, "bottle", "cup", "vase", "ball", "cone"]
    name = names[int(rng.integers(len(names)))]
    if rng.random() < 0.2:
        name, widths = "any", _any_profile(rng)
    elif name in ODD_PROFILES:
        points = np.array(ODD_PROFILES[name])
        widths = np.interp(SHARES, points[:, 0], points[:, 1])
    else:
        widths = np.interp(SHARES, *PROFILES[name])
    widths = np.maximum(widths * (1.0 + 0.05 * _wobble(rng)), 0.0)
    low, high = ODD_WIDTHS.get(name, (0.22, 0.5))
    body = revolved_from(
        SHARES, widths / widths.max(), _odd_colours(rng), 1.0, 0.5 * float(rng.uniform(low, high))
    )
    grain = _grain(rng, 0.25) if rng.random() < 0.5 else None
    return draw_sprite(body, _pitch(rng), _distance(rng), _light(rng), height_px, False, grain)


def _any_profile(rng: Rng) -> FloatArray:
    """A smooth outline of no pin: those too near to one are thrown away."""
    while True:
        knots = int(rng.integers(4, 9))
        widths = np.interp(SHARES, np.linspace(0, 1, knots), rng.uniform(0.15, 1.0, knots))
        widths = np.convolve(
            np.pad(widths, 16, mode="edge"), np.hanning(33) / np.hanning(33).sum(), mode="valid"
        )
        widths /= widths.max()
        if min(float(np.abs(widths - pin).mean()) for pin in (TEN_PIN, DUCK_PIN)) > 0.16:
            return widths


def _pin_colours(rng: Rng) -> FloatArray:
    value = rng.uniform(205, 252)
    tint = rng.normal(0.0, 4.0, 3) + (
        np.array([-14.0, -3.0, 4.0]) * rng.random() if rng.random() < 0.5 else 0.0
    )
    colours = np.tile(np.clip(value + tint, 120, 255), (SHARES.size, 1))
    kind = rng.random()
    if kind < 0.08:
        return colours
    stripe = _stripe_colour(rng)
    if kind < 0.45:
        bands = [
            (rng.uniform(0.63, 0.70), rng.uniform(0.03, 0.06)),
            (rng.uniform(0.72, 0.78), rng.uniform(0.03, 0.06)),
        ]
    elif kind < 0.85:
        bands = [(rng.uniform(0.63, 0.76), rng.uniform(0.05, 0.12))]
    else:
        bands = [(rng.uniform(0.60, 0.80), rng.uniform(0.015, 0.05)) for _ in range(int(rng.integers(1, 4)))]
    for center, thickness in bands:
        colours[np.abs(SHARES - center) <= 0.5 * thickness] = stripe
    if rng.random() < 0.2:
        colours[rng.uniform(0.01, 0.06) > SHARES] *= rng.uniform(0.3, 0.9)
    if rng.random() < 0.12:
        center, thickness = rng.uniform(0.25, 0.5), rng.uniform(0.02, 0.1)
        colours[np.abs(SHARES - center) <= 0.5 * thickness] = _stripe_colour(rng)
    return colours


def _stripe_colour(rng: Rng) -> FloatArray:
    if rng.random() < 0.8:
        return np.array([rng.uniform(20, 90), rng.uniform(15, 80), rng.uniform(130, 235)])
    return rng.uniform(0, 255, 3)


def _odd_colours(rng: Rng) -> FloatArray:
    def colour() -> FloatArray:
        kind = rng.random()
        if kind < 0.3:
            return np.full(3, rng.uniform(200, 250)) + rng.normal(0, 5, 3)
        if kind < 0.5:
            return _stripe_colour(rng)
        if kind < 0.65:
            return np.full(3, rng.uniform(10, 120)) + rng.normal(0, 8, 3)
        return rng.uniform(0, 255, 3)

    colours = np.tile(np.clip(colour(), 0, 255), (SHARES.size, 1))
    for _ in range(int(rng.integers(0, 5))):
        center, thickness = rng.uniform(0, 1), rng.uniform(0.02, 0.3)
        colours[np.abs(SHARES - center) <= 0.5 * thickness] = np.clip(colour(), 0, 255)
    return colours


def _wobble(rng: Rng) -> FloatArray:
    phase = rng.uniform(0, 2 * math.pi, 3)
    size = rng.normal(0, [0.6, 0.4, 0.25])
    return sum(s * np.sin((k + 1) * math.pi * SHARES + p) for k, (s, p) in enumerate(zip(size, phase)))  # type: ignore[return-value]


def _grain(rng: Rng, strength: float) -> NDArray[np.float32]:
    """Scratches round the body, blotches, now and then a printed emblem."""
    rows = rng.normal(0, 0.5 * strength, (48, 1)) + rng.normal(0, 0.6 * strength, (48, 16))
    grain = 1.0 + np.asarray(rows, np.float32)
    if rng.random() < 0.35:
        center = (int(rng.integers(4, 12)), int(rng.integers(22, 42)))
        axes = (int(rng.integers(1, 4)), int(rng.integers(2, 6)))
        cv2.ellipse(grain, center, axes, 0, 0, 360, float(rng.uniform(0.2, 0.9)), -1)
    return np.clip(grain, 0.1, 1.4).astype(np.float32)


def _light(rng: Rng) -> Light:
    ambient = float(rng.uniform(0.25, 0.85))
    return Light(
        ambient, float(rng.uniform(0.1, 1.0 - 0.6 * ambient)), float(rng.normal(0, 0.7)), float(rng.uniform(-0.1, 1.2)),
        float(rng.uniform(0.0, 1.0)) + 0.05, float(rng.uniform(0, 0.5)) * float(rng.random() < 0.6),
        float(rng.uniform(5, 60)),
    )  # fmt: skip


def _pitch(rng: Rng) -> float:
    if rng.random() < 0.5:
        return math.radians(float(rng.normal(0.0, 3.0)))
    return math.radians(float(rng.uniform(-4.0, 35.0)))


def _distance(rng: Rng) -> float:
    return float(np.exp(rng.uniform(math.log(1.1), math.log(20.0))))


__all__ = ["Revolved", "a_pin", "an_odd_thing"]

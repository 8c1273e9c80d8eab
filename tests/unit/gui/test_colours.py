"""Colours are told apart with every kind of colour vision, and letters stand out from what they are written on."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from target_nav.gui.panels import style
from target_nav.gui.panels.style import Colour

# Machado, Oliveira and Fernandes, "A Physiologically-based Model for Simulation of Color Vision Deficiency"
# (IEEE TVCG 2009), severity 1.0, on linear RGB.
VISION = {
    "normal": np.eye(3),
    "protanopia": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    ),
    "deuteranopia": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
    "tritanopia": np.array(
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]
    ),
}
RADAR = {"scan": style.SKY, "obstacles": style.ORANGE, "target": style.YELLOW, "ground": style.PANE}
JUST_NOTICEABLE = 2.3
"""CIE76 difference; colours of one picture are asked to differ six times as much."""


def linear(colour: Colour) -> np.ndarray:
    c = np.array(colour)
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def lab(rgb: np.ndarray) -> np.ndarray:
    """CIE L*a*b* of linear sRGB, D65."""
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    t = to_xyz @ np.clip(rgb, 0.0, 1.0) / np.array([0.9505, 1.0, 1.089])
    f = np.where(t > 216 / 24389, np.cbrt(t), (24389 / 27 * t + 16) / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def difference(one: Colour, other: Colour, vision: str) -> float:
    seen = [lab(VISION[vision] @ linear(colour)) for colour in (one, other)]
    return float(np.linalg.norm(seen[0] - seen[1]))


def contrast(one: Colour, other: Colour) -> float:
    """WCAG 2: 4.5 for text, 3 for large text."""
    weights = np.array([0.2126, 0.7152, 0.0722])
    low, high = sorted(float(weights @ linear(colour)) for colour in (one, other))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("vision", VISION)
@pytest.mark.parametrize("palette", [style.STATUS_COLOUR, RADAR], ids=["statuses", "radar"])
def test_what_means_different_things_looks_different_to_everybody(
    vision: str, palette: dict[str, Colour]
) -> None:
    for (name, one), (other_name, other) in combinations(palette.items(), 2):
        assert difference(one, other, vision) > 6 * JUST_NOTICEABLE, (name, other_name)


@pytest.mark.parametrize(
    "ink", [style.TEXT, style.GREY, style.SKY, style.GREEN, style.ORANGE, style.YELLOW], ids=str
)
def test_letters_stand_out_from_the_ground(ink: Colour) -> None:
    assert contrast(ink, style.PANE) >= 4.5
    assert contrast(ink, style.BACKGROUND) >= 4.5


@pytest.mark.parametrize("ground", [style.VERMILION, style.BLUE], ids=["STOP", "GO"])
def test_the_large_keys_can_be_read(ground: Colour) -> None:
    assert contrast(style.TEXT, ground) >= 3.0


def test_an_alarm_is_dark_on_bright() -> None:
    assert contrast(style.BACKGROUND, style.ORANGE) >= 7.0

"""What a room looks like beyond its geometry: colours, wall papers, pictures on the walls, floor, light, the sensor.

One number chooses all of it, so that a campaign sees another room in every run and the same in a repeated one. 0 is the
plain room of the documentation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

Bgr = tuple[float, float, float]
PLAIN_WALLS: tuple[Bgr, ...] = (
    (206.0, 212.0, 214.0),
    (190.0, 200.0, 206.0),
    (200.0, 204.0, 198.0),
    (196.0, 196.0, 206.0),
)
PLAIN_CEILING: Bgr = (196.0, 200.0, 202.0)
PLAIN_FLOOR: Bgr = (104.0, 118.0, 126.0)
FLOORS = ("tiles", "boards", "carpet")
BOARDS_BGR: Bgr = (92.0, 132.0, 168.0)


@dataclass(frozen=True)
class Look:
    """`seed` draws what is not listed: where pictures hang, how plaster is mottled."""

    seed: int = 0
    walls_bgr: tuple[Bgr, ...] = PLAIN_WALLS
    ceiling_bgr: Bgr = PLAIN_CEILING
    floor: str = "tiles"
    floor_bgr: Bgr = PLAIN_FLOOR
    wall_things: float = 0.25
    """Pictures, doors and shelves, for each metre of wall."""
    gain: float = 1.0
    tint_bgr: Bgr = (1.0, 1.0, 1.0)
    """Brightness and white balance of the sensor."""
    noise_sigma: float = 2.5
    blur_sigma_px: float = 0.6

    @classmethod
    def of(cls, seed: int) -> Look:
        """Of any seed from 0 on.

        Raises:
            ValueError: the seed is negative.
        """
        if seed < 0:
            raise ValueError(f"the seed of a look is {seed}; it must be 0 or more")
        if seed == 0:
            return cls()
        rng = np.random.default_rng([seed, 77])
        wall = rng.uniform(110.0, 225.0) + rng.normal(0.0, 12.0, 3)
        floor = FLOORS[int(rng.integers(len(FLOORS)))]
        base = np.array(BOARDS_BGR if floor == "boards" else PLAIN_FLOOR) * rng.uniform(0.6, 1.35)
        return cls(
            seed,
            tuple(_bgr(wall * rng.uniform(0.9, 1.08)) for _ in range(4)),
            _bgr(np.full(3, rng.uniform(150.0, 225.0)) + rng.normal(0.0, 6.0, 3)),
            floor,
            _bgr(base + rng.normal(0.0, 10.0, 3)),
            float(rng.uniform(0.0, 0.7)),
            float(np.exp(rng.normal(0.0, 0.12))),
            _bgr(np.exp(rng.normal(0.0, 0.05, 3)), 2.0),
            float(rng.uniform(1.5, 5.0)),
            float(rng.uniform(0.4, 1.0)),
        )


def _bgr(values: np.ndarray, limit: float = 250.0) -> Bgr:
    blue, green, red = (float(value) for value in np.clip(values, 0.0, limit))
    return blue, green, red

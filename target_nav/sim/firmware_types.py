"""What the simulator asks of a firmware: the compiled one, or one that a test has scripted."""

from __future__ import annotations

from enum import Enum
from typing import Protocol

Ticks = tuple[int, int, int, int]
"""Encoder counts: front left, front right, rear left, rear right."""

Pwm = tuple[int, int, int, int]
"""The same wheels, each -255 ... 255."""


class Mode(Enum):
    IDLE = "idle"
    VELOCITY = "velocity"
    MOVE = "move"
    MOTOR = "motor"


class Firmware(Protocol):
    """Call `feed` with what the host sends, and `step` at least every 10 ms with the encoders' counts.

    Times are the caller's, in seconds, and do not go back.
    """

    @property
    def pwm(self) -> Pwm:
        """What the motors get now."""

    @property
    def mode(self) -> Mode: ...

    @property
    def has_output(self) -> bool: ...

    def feed(self, data: bytes, now_s: float) -> None:
        """Bytes from the host."""

    def step(self, now_s: float, ticks: Ticks) -> Pwm:
        """The PWM of each motor from now on."""

    def take_output(self) -> bytes:
        """What the firmware has sent since the last call."""

"""A measured figure and the limit it is held to."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Figure:
    """`low` and `high` are inclusive limits; a NaN, which is a figure of nothing, holds none."""

    name: str
    value: float
    low: float = float("-inf")
    high: float = float("inf")
    unit: str = ""
    note: str = ""

    @property
    def limited(self) -> bool:
        return self.low != float("-inf") or self.high != float("inf")

    @property
    def holds(self) -> bool:
        return not self.limited or self.low <= self.value <= self.high

    def text(self) -> str:
        limit = ""
        if self.limited:
            low = f">= {self.low:g}" if self.low != float("-inf") else ""
            high = f"<= {self.high:g}" if self.high != float("inf") else ""
            limit = (
                f"{' and '.join(part for part in (low, high) if part)}: {'holds' if self.holds else 'MISSED'}"
            )
        return f"{self.name:<46} {self.value:9.4f} {self.unit:<4} {limit:<28} {self.note}".rstrip()

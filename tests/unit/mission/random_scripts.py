"""Random scripts for `random_trees`. Entries have one kind each, by the first letter of their names, so that a script
fails now and then and not always:

    d  a double        i  a whole number     t  a text        b  true or false
    p  what ports read (a whole number)      s  what SetBlackboard writes       c  what it copies
    u  what is watched for updates           x  what is removed again           q, j, r  what loops give
    v  what a Switch looks at (a whole number that only scripts write)
    k  the number of the tick, so that what is asked changes
"""

from __future__ import annotations

import random
from dataclasses import dataclass

START: dict[str, float | int | str | bool] = {
    "k0": 0,
    "d0": 1.5,
    "d1": -2.0,
    "i0": 1,
    "i1": 3,
    "t0": "a",
    "b0": True,
    "p0": 2,
    "p1": 2,
}
"""What the main tree's blackboard holds to begin with."""

PRELUDE = (
    """<Script code="d2 := 0.5; d3 := 3.5; t1 := 'b'; u0 := 0.0; x0 := 1.0; v0 := 1; v1 := 2"/>"""
    """<Script code="q0 := 0.0; j0 := 0; r0 := 'r'"/><SetBlackboard output_key="s0" value="s"/>"""
)
"""What makes the rest, in most missions; in the others scripts fail sooner or later."""


@dataclass
class Scope:
    """What scripts of one tree may name. `own` says that removing an entry removes one of this tree's own."""

    names: tuple[str, ...]
    own: bool = True

    def some(self, rng: random.Random, letters: str) -> str:
        names = [name for name in self.names if name.lstrip("@")[0] in letters]
        return rng.choice(names) if names else f"@{letters[0]}0"


MAIN = Scope(tuple(sorted((*START, "d2", "t1", "s0", "c0", "u0", "x0", "q0", "j0", "r0", "v0", "v1"))))


@dataclass
class Expressions:
    """Scripts. All of an operator's parts are in parentheses: how they associate is an intended difference."""

    rng: random.Random
    mixes: bool = True
    """Whether operators of two kinds may stand side by side, which is an error, there as here."""

    def number(self, scope: Scope, depth: int = 2) -> str:
        roll = self.rng.random()
        if depth <= 0 or roll < 0.3:
            if self.rng.random() < 0.5:
                return self.rng.choice(("0", "1", "2", "3", "0.5", "(-1)", "+2", "1e1", "0x3", "true"))
            return scope.some(
                self.rng,
                self.rng.choice(("ddiiipuxv", "ddiiipuxv", "qj")) if self.rng.random() < 0.3 else "di",
            )
        if roll < 0.65:
            operator = self.rng.choice(("+", "-", "+", "*"))
            return f"({self.number(scope, depth - 1)} {operator} {self.number(scope, depth - 1)})"
        if roll < 0.72:
            return self.unary(f"-({self.number(scope, depth - 1)})")
        if roll < 0.8:
            operator = self.rng.choice("&|^")
            return f"({self.whole(scope)} {operator} {self.whole(scope)})"
        if roll < 0.84:
            return self.unary(f"~{self.whole(scope)}")
        if roll < 0.9:
            return f"({self.number(scope, depth - 1)} / {self.rng.choice(('2', '4.0', '-8'))})"
        return f"({self.condition(scope, 1)} ? {self.number(scope, depth - 1)} : {self.number(scope, depth - 1)})"

    def unary(self, text: str) -> str:
        return text if self.mixes and self.rng.random() < 0.05 else f"({text})"

    def whole(self, scope: Scope) -> str:
        return self.rng.choice((scope.some(self.rng, "i"), str(self.rng.randint(0, 9)), "0x0F"))

    def text(self, scope: Scope, depth: int = 1) -> str:
        """None begins with a digit: a Switch takes `5a` for 5 there, and not here."""
        roll = self.rng.random()
        if depth <= 0 or roll < 0.6:
            return self.rng.choice(
                ("'a'", "'b'", '"c d"', "''", scope.some(self.rng, "tr"), scope.some(self.rng, "t"))
            )
        if roll < 0.8:
            right = self.rng.choice((self.text(scope, 0), scope.some(self.rng, "id")))
            return f"({self.rng.choice(('x', 'y'))!r} .. {right})"
        return f"({self.text(scope, 0)} + {self.text(scope, 0)})"

    def condition(self, scope: Scope, depth: int = 2) -> str:
        roll = self.rng.random()
        comparison = self.rng.choice(("==", "!=", "<", ">", "<=", ">="))
        if roll < 0.35:
            return self.in_time()
        if roll < 0.55 or depth <= 0:
            return f"{self.number(scope, 1)} {comparison} {self.number(scope, 1)}"
        if roll < 0.65:
            left = self.text(scope) if self.rng.random() < 0.8 else scope.some(self.rng, "s")
            return f"{left} {comparison} {self.text(scope)}"
        if roll < 0.7:
            return f"'{self.rng.randint(0, 3)}' {comparison} {self.number(scope, 1)}"
        if roll < 0.75:
            return self.rng.choice(("@b0", "true", "false", "1", "0"))
        if roll < 0.8:
            return f"!({self.condition(scope, depth - 1)})"
        if roll < 0.9:
            operator = self.rng.choice(("&&", "||"))
            return f"({self.condition(scope, depth - 1)}) {operator} ({self.condition(scope, depth - 1)})"
        return f"0 <= {self.number(scope, 1)} < {self.number(scope, 1)}"

    def in_time(self) -> str:
        """True in some ticks and not in others."""
        return self.rng.choice(
            ("@k0 & 1", "(@k0 & 2) == 2", "(@k0 & 2) == 0", "!(@k0 & 1)", f"@k0 < {self.rng.randint(1, 8)}",
             f"@k0 > {self.rng.randint(1, 8)}", f"@k0 != {self.rng.randint(0, 8)}")
        )  # fmt: skip

    def statement(self, scope: Scope) -> str:
        roll = self.rng.random()
        assign = self.rng.choice((":=", ":=", ":=", "="))
        if roll < 0.3:
            operator = self.rng.choice((assign, assign, "+=", "-="))
            return f"{scope.some(self.rng, 'd')} {operator} {self.number(scope)}"
        if roll < 0.5:
            operator = self.rng.choice((assign, "+=", "-="))
            return f"{scope.some(self.rng, 'i')} {operator} {self.whole(scope)}"
        if roll < 0.65:
            return f"{scope.some(self.rng, 't')} {assign} {self.text(scope)}"
        if roll < 0.8:
            return f"{scope.some(self.rng, 'u')} := {self.number(scope, 1)}"
        if roll < 0.85:
            return f"{scope.some(self.rng, 'b')} {assign} ({self.condition(scope)})"
        if roll < 0.9:
            return f"{scope.some(self.rng, 'x')} {assign} {self.number(scope, 1)}"
        return f"{self.rng.choice(('@v0', '@v1'))} := {self.rng.randint(0, 3)}"

    def script(self, scope: Scope) -> str:
        return "; ".join(self.statement(scope) for _ in range(self.rng.choice((1, 1, 2))))

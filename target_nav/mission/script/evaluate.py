"""A parsed script bound to blackboard entries: a function to be called at every tick.

Each expression becomes a closure over its parts, so running a script neither looks names up nor walks a tree, and
nothing is ever handed to Python's own `eval`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol, TypeAlias

from target_nav.mission.script.arithmetic import (
    CALCULATE,
    COMPARE_DOUBLES,
    LARGEST_EXACT,
    Enums,
    assigned,
    binary,
    chooses,
    compare,
    described,
    unary,
)
from target_nav.mission.script.syntax import (
    Assign,
    Binary,
    Choice,
    Compare,
    Constant,
    Expression,
    Script,
    ScriptError,
    Unary,
    Variable,
)

Run: TypeAlias = Callable[[], Any]

_QUICK: dict[str, Callable[[float, float], float]] = {
    **CALCULATE,
    "&&": lambda left, right: 1.0 if left and right else 0.0,
    "||": lambda left, right: 1.0 if left or right else 0.0,
}
_EXACT = (float, int, bool)
_LARGE = float(LARGEST_EXACT)


class ScriptEntry(Protocol):
    """A blackboard entry as scripts use it."""

    @property
    def exists(self) -> bool:
        """Whether `=` may write to it: it has a value, or a port is bound to it."""

    @property
    def has_type(self) -> bool:
        """Whether a port says what it holds; `write` then converts."""

    def read(self) -> Any:
        """Its value. KeyError when it has none."""

    def write(self, value: Any) -> Any:
        """Stores the value and returns it, converted to the entry's type if it has one. ValueError: it does not fit."""


def bind(script: Script, entry_of: Callable[[str], ScriptEntry], enums: Enums) -> Run:
    """The script as a function: it runs all statements and returns the last one's value.

    The function raises ScriptError when an entry has no value yet or a value does not fit its operator.
    """
    binder = _Binder(entry_of, enums)
    runs = [binder.bind(statement) for statement in script.statements]
    if len(runs) == 1:
        return runs[0]

    def run() -> Any:
        value = None
        for each in runs:
            value = each()
        return value

    return run


class _Binder:
    def __init__(self, entry_of: Callable[[str], ScriptEntry], enums: Enums) -> None:
        self._entry_of = entry_of
        self._enums = enums

    def bind(self, expression: Expression) -> Run:
        if isinstance(expression, Constant):
            constant = expression.value
            return lambda: constant
        if isinstance(expression, Variable):
            return self._variable(expression)
        if isinstance(expression, Unary):
            return self._unary(expression)
        if isinstance(expression, Binary):
            return self._binary(expression)
        if isinstance(expression, Compare):
            return self._compare(expression)
        if isinstance(expression, Choice):
            return self._choice(expression)
        return self._assign(expression)

    def _variable(self, variable: Variable) -> Run:
        name = variable.name
        if name in self._enums:
            constant = float(self._enums[name])
            return lambda: constant
        read = self._entry_of(name).read

        def value() -> Any:
            try:
                found = read()
            except KeyError:
                found = None
            if found is None:
                raise ScriptError(f"{name} has no value yet")
            return found

        return value

    def _unary(self, expression: Unary) -> Run:
        operator, operand = expression.operator, self.bind(expression.operand)
        return lambda: unary(operator, operand())

    def _binary(self, expression: Binary) -> Run:
        sign = expression.operator
        left, right = self.bind(expression.left), self.bind(expression.right)
        quick = _QUICK.get(sign)
        if quick is None:
            return lambda: binary(sign, left(), right())

        def value() -> Any:
            first, second = left(), right()
            # what results of other operators are: the rules of `binary` without asking what is what
            if type(first) is float and type(second) is float:
                return quick(first, second)
            return binary(sign, first, second)

        return value

    def _compare(self, expression: Compare) -> Run:
        enums = self._enums
        first, *others = map(self.bind, expression.operands)
        pairs = list(zip(expression.operators, others))
        if len(pairs) == 1:
            return self._compare_two(pairs[0][0], first, pairs[0][1])

        def value() -> float:
            left = first()
            for operator, operand in pairs:
                right = operand()
                if not compare(operator, left, right, enums):
                    return 0.0
                left = right
            return 1.0

        return value

    def _compare_two(self, sign: str, first: Run, second: Run) -> Run:
        enums, holds = self._enums, COMPARE_DOUBLES[sign]

        def value() -> float:
            left, right = first(), second()
            if (
                type(left) in _EXACT
                and type(right) in _EXACT
                and -_LARGE < left < _LARGE
                and -_LARGE < right < _LARGE
            ):
                return 1.0 if holds(left, right) else 0.0
            return 1.0 if compare(sign, left, right, enums) else 0.0

        return value

    def _choice(self, expression: Choice) -> Run:
        condition, then, otherwise = map(
            self.bind, (expression.condition, expression.then, expression.otherwise)
        )
        return lambda: then() if chooses(condition()) else otherwise()

    def _assign(self, expression: Assign) -> Run:
        name, operator, enums = expression.name, expression.operator, self._enums
        entry, value_of = self._entry_of(name), self.bind(expression.value)
        creates, calculates = operator == ":=", operator not in (":=", "=")

        def old_value() -> Any:
            try:
                return entry.read()
            except KeyError:
                return None

        def assign() -> Any:
            if not creates and not entry.exists:
                raise ScriptError(f"there is no entry {name} yet; to make one, write {name} := ...")
            value, old = value_of(), old_value()
            if calculates:
                if old is None:
                    raise ScriptError(f"{name} has no value yet")
                value = _calculated(operator[0], old, value)
            try:
                if old is not None and not entry.has_type:
                    value = assigned(old, value, enums)
                return entry.write(value)
            except ValueError as error:
                raise ScriptError(f"{name} {operator} {described(value)}: {error}") from None

        return assign


def _calculated(operator: str, old: object, value: object) -> Any:
    if isinstance(old, str) != isinstance(value, str):
        raise ScriptError(f"{operator}= cannot be used with {described(old)} and {described(value)}")
    return binary(operator, old, value)

"""What a script is made of, after parsing. The grammar is BehaviorTree.CPP's; see `grammar`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, TypeAlias

Value: TypeAlias = "bool | int | float | str"
"""What a literal can be. `true` and `false` count as 1 and 0; a whole number stays one until it is calculated with."""

UnaryOperator = Literal["-", "~", "!"]
BinaryOperator = Literal["+", "-", "*", "/", "..", "&", "|", "^", "&&", "||"]
Comparison = Literal["==", "!=", "<", ">", "<=", ">="]
Assignment = Literal[":=", "=", "+=", "-=", "*=", "/="]


class ScriptError(ValueError):
    """What is wrong with a script, or goes wrong when it runs. `at` counts its characters from 1; 0: nowhere in it."""

    def __init__(self, message: str, at: int = 0) -> None:
        super().__init__(message)
        self.message = message
        self.at = at

    def __str__(self) -> str:
        return f"character {self.at}: {self.message}" if self.at else self.message


@dataclass(frozen=True)
class Constant:
    value: Value
    at: int


@dataclass(frozen=True)
class Variable:
    """A name: an enum's constant where there is one, else a blackboard entry."""

    name: str
    at: int


@dataclass(frozen=True)
class Unary:
    operator: UnaryOperator
    operand: Expression
    at: int


@dataclass(frozen=True)
class Binary:
    operator: BinaryOperator
    left: Expression
    right: Expression
    at: int


@dataclass(frozen=True)
class Compare:
    """`a < b <= c`: each operand with the next; 1 if all hold."""

    operands: tuple[Expression, ...]
    operators: tuple[Comparison, ...]
    at: int


@dataclass(frozen=True)
class Choice:
    condition: Expression
    then: Expression
    otherwise: Expression
    at: int


@dataclass(frozen=True)
class Assign:
    """`:=` may make a new entry, the others need one. Its value is what the entry then holds."""

    operator: Assignment
    name: str
    value: Expression
    at: int


Expression: TypeAlias = "Constant | Variable | Unary | Binary | Compare | Choice | Assign"


def parts_of(expression: Expression) -> tuple[Expression, ...]:
    if isinstance(expression, Unary):
        return (expression.operand,)
    if isinstance(expression, Binary):
        return (expression.left, expression.right)
    if isinstance(expression, Compare):
        return expression.operands
    if isinstance(expression, Choice):
        return (expression.condition, expression.then, expression.otherwise)
    if isinstance(expression, Assign):
        return (expression.value,)
    return ()


@dataclass(frozen=True)
class Script:
    """Statements, run in order; the last one's value is the script's."""

    text: str
    statements: tuple[Expression, ...]

    def walk(self) -> Iterator[Expression]:
        stack = list(reversed(self.statements))
        while stack:
            expression = stack.pop()
            yield expression
            stack.extend(reversed(parts_of(expression)))

    @cached_property
    def reads(self) -> tuple[str, ...]:
        """The names whose values are used, enums' constants included; each once."""
        names = [each.name for each in self.walk() if isinstance(each, Variable)]
        names += [
            each.name for each in self.walk() if isinstance(each, Assign) and each.operator not in (":=", "=")
        ]
        return tuple(dict.fromkeys(names))

    @cached_property
    def writes(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(each.name for each in self.walk() if isinstance(each, Assign)))

    @cached_property
    def creates(self) -> tuple[str, ...]:
        """Those of the written names that need not be there before."""
        return tuple(
            dict.fromkeys(
                each.name for each in self.walk() if isinstance(each, Assign) and each.operator == ":="
            )
        )

    @cached_property
    def constants_written(self) -> tuple[tuple[str, Value], ...]:
        """(name, value) of each assignment of a literal, which can be checked before it runs."""
        return tuple(
            (each.name, each.value.value)
            for each in self.walk()
            if isinstance(each, Assign) and each.operator in (":=", "=") and isinstance(each.value, Constant)
        )

"""What can be said of a script before it runs: operators that cannot work with what they are given.

Only literals and results have a kind that is known; an entry may hold anything.
"""

from __future__ import annotations

from typing import Literal

from target_nav.mission.script.arithmetic import Enums, text_as_number
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

Kind = Literal["a number", "text", "anything"]


def check_kinds(script: Script, enums: Enums, decides: bool) -> None:
    """Raises ScriptError for the first thing in a script that would fail whenever it is reached.

    Args:
        script: what was parsed
        enums: names of constants
        decides: whether the script's value must be true or false
    """
    kinds = [_kind(statement, enums) for statement in script.statements]
    if decides and kinds[-1] == "text":
        raise ScriptError("its value is text; it must be true or false", script.statements[-1].at)


def _kind(expression: Expression, enums: Enums) -> Kind:
    if isinstance(expression, Constant):
        return "text" if isinstance(expression.value, str) else "a number"
    if isinstance(expression, Variable):
        return "a number" if expression.name in enums else "anything"
    if isinstance(expression, Unary):
        if _kind(expression.operand, enums) == "text":
            raise ScriptError(f"{expression.operator} cannot be used with text", expression.at)
        return "a number"
    if isinstance(expression, Binary):
        return _binary(expression, enums)
    if isinstance(expression, Compare):
        return _compare(expression, enums)
    if isinstance(expression, Choice):
        _kind(expression.condition, enums)
        then, otherwise = _kind(expression.then, enums), _kind(expression.otherwise, enums)
        return then if then == otherwise else "anything"
    return _assign(expression, enums)


def _binary(expression: Binary, enums: Enums) -> Kind:
    operator = expression.operator
    left, right = _kind(expression.left, enums), _kind(expression.right, enums)
    both = {left, right}
    if operator == "..":
        if both == {"a number"}:
            raise ScriptError(".. joins texts, and both sides are numbers", expression.at)
        return "text"
    if operator == "+" and both != {"a number", "text"}:
        return left if left == right else next(iter(both - {"anything"}), "anything")
    if "text" in both:
        raise ScriptError(f"{operator} cannot be used with text", expression.at)
    return "a number"


def _compare(expression: Compare, enums: Enums) -> Kind:
    kinds = [_kind(operand, enums) for operand in expression.operands]
    for index, operand in enumerate(expression.operands):
        neighbours = kinds[max(index - 1, 0) : index] + kinds[index + 1 : index + 2]
        if isinstance(operand, Constant) and isinstance(operand.value, str) and "a number" in neighbours:
            try:
                text_as_number(operand.value, enums)
            except ScriptError as error:
                raise ScriptError(f"{error}, and it is compared with a number", operand.at) from None
    return "a number"


def _assign(expression: Assign, enums: Enums) -> Kind:
    if expression.name in enums:
        raise ScriptError(
            f"{expression.name} is a constant ({enums[expression.name]}) and cannot be written", expression.at
        )
    kind = _kind(expression.value, enums)
    if expression.operator not in (":=", "=", "+=") and kind == "text":
        raise ScriptError(f"{expression.operator} cannot be used with text", expression.at)
    return kind if expression.operator == ":=" else "anything"

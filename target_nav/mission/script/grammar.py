"""Scripts as BehaviorTree.CPP writes them, parsed by precedence climbing.

    script      = expression { ";" expression }
    expression  = choice [ (":=" | "=" | "+=" | "-=" | "*=" | "/=") choice ]
    choice      = logic [ "?" expression ":" logic ]
    logic       = comparison { ("&&" | "||") comparison }
    comparison  = operand { ("==" | "!=" | "<" | ">" | "<=" | ">=") operand }
    operand     = arithmetic, bits or text:
                  + -  over  * /  over  unary -
                  | ^  over  &    over  unary ~ !
                  ..
    atom        = "(" expression ")" | true | false | name | number | 'text' | "text"

Operators of arithmetic, of bits (`!` is one of them) and of text do not mix within one expression; parentheses and the
middle of a choice begin a new one. That is BehaviorTree.CPP's rule, and a script that parses here does so there.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Final, cast

from target_nav.mission.script.syntax import (
    Assign,
    Assignment,
    Binary,
    BinaryOperator,
    Choice,
    Compare,
    Comparison,
    Constant,
    Expression,
    Script,
    ScriptError,
    Unary,
    UnaryOperator,
    Variable,
    parts_of,
)
from target_nav.mission.script.tokens import Token, tokens_of

MAX_DEPTH = 40
"""How deep expressions may nest: scripts are evaluated by recursion, inside trees that nest themselves."""

_ASSIGNMENTS: Final = (":=", "=", "+=", "-=", "*=", "/=")
_COMPARISONS: Final = ("==", "!=", "<", ">", "<=", ">=")
_LOGIC: Final = ("&&", "||")
_LEVELS: Final = {"+": 1, "-": 1, "*": 2, "/": 2, "..": 1, "|": 1, "^": 1, "&": 2}
_GROUPS: Final = {
    **dict.fromkeys(("+", "-", "*", "/"), "arithmetic"),
    **dict.fromkeys(("&", "|", "^", "~", "!"), "bit operators"),
    "..": "joining of texts",
}
_PREFIXES: Final = ("-", "~", "!")


@lru_cache(maxsize=4096)
def parse_script(text: str) -> Script:
    """A script ready to be bound to blackboard entries.

    Raises:
        ScriptError: it is none, or empty.
    """
    tokens = tokens_of(text)
    if tokens[0].kind == "end":
        raise ScriptError("the script is empty")
    return _Parser(text, tokens).script()


class _Parser:
    def __init__(self, text: str, tokens: list[Token]) -> None:
        self._text = text
        self._tokens = tokens
        self._position = 0
        self._open = 0
        self._group = ""
        """Which kind of operators the present expression has used."""

    def script(self) -> Script:
        statements = [self._expression()]
        while self._take(";"):
            if self._next.kind == "end":
                raise ScriptError("nothing follows the last ;, leave it out", self._next.at)
            statements.append(self._expression())
        if self._next.kind != "end":
            raise ScriptError(
                f"{_shown(self._next)} cannot stand here; statements have ; between", self._next.at
            )
        for statement in statements:
            _check_depth(statement)
        return Script(self._text, tuple(statements))

    # -- tokens ------------------------------------------------------------------------------------------------------

    @property
    def _next(self) -> Token:
        return self._tokens[self._position]

    def _take(self, *operators: str) -> Token | None:
        token = self._next
        if token.kind == "operator" and token.text in operators:
            self._position += 1
            return token
        return None

    def _need(self, operator: str, opened: Token) -> None:
        if self._take(operator) is None:
            raise ScriptError(
                f'"{operator}" is missing for the {opened.text} of character {opened.at}', self._next.at
            )

    # -- expressions -------------------------------------------------------------------------------------------------

    def _expression(self) -> Expression:
        if self._open > MAX_DEPTH:
            raise _too_deep(self._next.at)
        group, self._group = self._group, ""
        self._open += 1
        target = self._choice()
        operator = self._take(*_ASSIGNMENTS)
        if operator is not None:
            if not isinstance(target, Variable):
                raise ScriptError(
                    f"what stands before {operator.text} must be the name of an entry", operator.at
                )
            value = self._choice()
            self._not_again(_ASSIGNMENTS)
            target = Assign(cast(Assignment, operator.text), target.name, value, operator.at)
        self._open -= 1
        self._group = group
        return target

    def _choice(self) -> Expression:
        condition = self._logic()
        question = self._take("?")
        if question is None:
            return condition
        then = self._expression()
        self._need(":", question)
        otherwise = self._logic()
        self._not_again(("?",))
        return Choice(condition, then, otherwise, question.at)

    def _not_again(self, operators: tuple[str, ...]) -> None:
        token = self._next
        if token.kind == "operator" and token.text in operators:
            raise ScriptError(f"{token.text} cannot follow another one; use parentheses", token.at)

    def _logic(self) -> Expression:
        left = self._comparison()
        while operator := self._take(*_LOGIC):
            left = Binary(cast(BinaryOperator, operator.text), left, self._comparison(), operator.at)
        return left

    def _comparison(self) -> Expression:
        first = self._operand(1)
        operands, operators = [first], []
        at = self._next.at
        while operator := self._take(*_COMPARISONS):
            operators.append(cast(Comparison, operator.text))
            operands.append(self._operand(1))
        return Compare(tuple(operands), tuple(operators), at) if operators else first

    def _operand(self, level: int) -> Expression:
        left = self._prefixed()
        while True:
            operator = self._next
            if operator.kind != "operator" or _LEVELS.get(operator.text, 0) < level:
                return left
            self._position += 1
            self._use(operator)
            right = self._operand(_LEVELS[operator.text] + 1)
            left = Binary(cast(BinaryOperator, operator.text), left, right, operator.at)

    def _prefixed(self) -> Expression:
        operators = []
        while operator := self._take(*_PREFIXES):
            self._use(operator)
            operators.append(operator)
            if len(operators) > MAX_DEPTH:
                raise _too_deep(operator.at)
        operand = self._atom()
        for operator in reversed(operators):
            operand = Unary(cast(UnaryOperator, operator.text), operand, operator.at)
        return operand

    def _use(self, operator: Token) -> None:
        group = _GROUPS[operator.text]
        if self._group and group != self._group:
            raise ScriptError(
                f"{operator.text}: {self._group} and {group} cannot be mixed; use parentheses", operator.at
            )
        self._group = group

    def _atom(self) -> Expression:
        token = self._next
        self._position += token.kind != "end"
        if token.kind == "literal":
            return Constant(token.value, token.at)
        if token.kind == "name":
            return Variable(token.text, token.at)
        if token.text == "(":
            inner = self._expression()
            self._need(")", token)
            return inner
        if token.text == "+" and _is_decimal(self._next) and self._next.at == token.at + 1:
            # the sign of a literal: `+5` is one, `+ 5` is not
            self._position += 1
            return Constant(self._tokens[self._position - 1].value, token.at)
        raise ScriptError(f"{_shown(token)} cannot stand here; a value must", token.at)


def _is_decimal(token: Token) -> bool:
    return (
        token.kind == "literal"
        and not isinstance(token.value, (bool, str))
        and token.text[:2] not in ("0x", "0X")
    )


def _shown(token: Token) -> str:
    return "the end" if token.kind == "end" else f'"{token.text}"'


def _too_deep(at: int) -> ScriptError:
    return ScriptError(f"it is nested more than {MAX_DEPTH} deep; use several statements", at)


def _check_depth(expression: Expression) -> None:
    # Left to right, `a + b + c` nests as deep as it is long.
    stack: list[tuple[Expression, int]] = [(expression, 1)]
    while stack:
        each, depth = stack.pop()
        if depth > MAX_DEPTH:
            raise _too_deep(each.at)
        stack.extend((part, depth + 1) for part in parts_of(each))

"""A script's text as tokens."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Literal

from target_nav.mission.script.syntax import ScriptError, Value

MAX_CHARACTERS = 10_000
LARGEST_INTEGER = 2**63 - 1

_BLANK = re.compile(r"(?:[ \t\r\n]|\\\r?\n)+")
_HEX = re.compile(r"0[xX]([0-9a-fA-F]*)")
_NUMBER = re.compile(r"[0-9]+(?P<real>\.[0-9]+(?:[eE][+-]?[0-9]+)?|[eE][+-]?[0-9]+)?")
_OPERATOR = re.compile(r":=|==|!=|<=|>=|&&|\|\||\+=|-=|\*=|/=|\.\.|[=<>+\-*/&|^~!?:;()]")
_COMMENT = re.compile(r"//|/\*|#")
_BOOLEANS = {"true": True, "false": False}


@dataclass(frozen=True)
class Token:
    """`text` is the operator or the name; `value` is that of a literal. `at` counts characters from 1."""

    kind: Literal["literal", "name", "operator", "end"]
    text: str
    at: int
    value: Value = 0


def tokens_of(text: str) -> list[Token]:
    """The tokens, with one of kind `end` behind them.

    Raises:
        ScriptError: something that is no part of a script.
    """
    if len(text) > MAX_CHARACTERS:
        raise ScriptError(f"it is longer than {MAX_CHARACTERS} characters; use several scripts")
    tokens: list[Token] = []
    position = 0
    while True:
        blank = _BLANK.match(text, position)
        position = blank.end() if blank else position
        if position == len(text):
            return [*tokens, Token("end", "", position + 1)]
        token, position = _token(text, position)
        tokens.append(token)


def _token(text: str, begin: int) -> tuple[Token, int]:
    character = text[begin]
    at = begin + 1
    if character in "'\"":
        return _quoted(text, begin)
    if character.isascii() and character.isdigit():
        return _number(text, begin)
    if character in "@_" or character.isidentifier():
        return _name(text, begin)
    if _COMMENT.match(text, begin):
        raise ScriptError("a script has no comments; write an XML comment beside the node", at)
    operator = _OPERATOR.match(text, begin)
    if operator is None:
        raise ScriptError(f'"{character}" is no part of a script', at)
    return Token("operator", operator.group(), at), operator.end()


def _quoted(text: str, begin: int) -> tuple[Token, int]:
    quote, at = text[begin], begin + 1
    end = text.find(quote, begin + 1)
    if end < 0:
        raise ScriptError(f"the text that begins here has no {quote} at its end", at)
    content = text[begin + 1 : end]
    for offset, character in enumerate(content):
        if not character.isascii():
            raise ScriptError(f'"{character}" is not ASCII; a script has no other text', at + 1 + offset)
    return Token("literal", content, at, content), end + 1


def _number(text: str, begin: int) -> tuple[Token, int]:
    at = begin + 1
    value: int | float
    hexadecimal = _HEX.match(text, begin)
    if hexadecimal is not None:
        if not hexadecimal.group(1):
            raise ScriptError("a digit of a hexadecimal number is missing", hexadecimal.end() + 1)
        value, end = int(hexadecimal.group(1), 16), hexadecimal.end()
    else:
        number = _NUMBER.match(text, begin)
        assert number is not None, "it begins with a digit"
        end = number.end()
        value = float(number.group()) if number.group("real") else _integer(number.group())
    if text[end : end + 1] == "." or text[end : end + 1] == "_" or text[end : end + 1].isalpha():
        raise ScriptError(f'"{text[begin : end + 1]}" is no number; put a blank behind the number', at)
    if isinstance(value, int) and value > LARGEST_INTEGER:
        raise ScriptError(f"{text[begin:end]} is larger than {LARGEST_INTEGER}", at)
    if math.isinf(value):
        raise ScriptError(f"{text[begin:end]} is too large", at)
    return Token("literal", text[begin:end], at, value), end


def _integer(digits: str) -> int:
    # int() refuses texts of thousands of digits with an error of its own
    return int(digits) if len(digits.lstrip("0")) <= 19 else LARGEST_INTEGER + 1


def _name(text: str, begin: int) -> tuple[Token, int]:
    end = begin + 1
    while end < len(text) and f"_{text[end]}".isidentifier():
        end += 1
    name, at = text[begin:end], begin + 1
    if name == "@":
        raise ScriptError("a name must follow @", at)
    for word, value in _BOOLEANS.items():
        if name == word:
            return Token("literal", name, at, value), end
        if name.startswith(word):
            # BehaviorTree.CPP reads `true` and stops at the rest.
            raise ScriptError(f'a name cannot begin with "{word}", as "{name}" does', at)
    return Token("name", name, at), end

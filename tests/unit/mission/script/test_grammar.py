"""Which texts are scripts, and what they mean. Each was tried in BehaviorTree.CPP 4.8."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.mission.script import Script, ScriptError, parse_script
from target_nav.mission.script.grammar import MAX_DEPTH
from target_nav.mission.script.syntax import (
    Assign,
    Binary,
    Choice,
    Compare,
    Constant,
    Expression,
    Unary,
    Variable,
)
from target_nav.mission.script.tokens import MAX_CHARACTERS


def shown(expression: Expression) -> str:
    """With all parentheses."""
    if isinstance(expression, Constant):
        return repr(expression.value)
    if isinstance(expression, Variable):
        return expression.name
    if isinstance(expression, Unary):
        return f"({expression.operator}{shown(expression.operand)})"
    if isinstance(expression, Binary):
        return f"({shown(expression.left)} {expression.operator} {shown(expression.right)})"
    if isinstance(expression, Compare):
        first, *others = map(shown, expression.operands)
        return f"[{first}{''.join(f' {op} {each}' for op, each in zip(expression.operators, others))}]"
    if isinstance(expression, Choice):
        parts = shown(expression.condition), shown(expression.then), shown(expression.otherwise)
        return "({} ? {} : {})".format(*parts)
    assert isinstance(expression, Assign)
    return f"({expression.name} {expression.operator} {shown(expression.value)})"


@pytest.mark.parametrize(
    ("text", "meaning"),
    [
        ("a + b * c", "(a + (b * c))"),
        ("a * b + c", "((a * b) + c)"),
        ("a - b - c", "((a - b) - c)"),
        ("a / b * c", "((a / b) * c)"),
        ("-a * b", "((-a) * b)"),
        ("a - -b", "(a - (-b))"),
        ("--a", "(-(-a))"),
        ("a | b & c ^ d", "((a | (b & c)) ^ d)"),
        ("~a & b", "((~a) & b)"),
        ("!!a", "(!(!a))"),
        ("a .. b .. c", "((a .. b) .. c)"),
        ("a < b <= c", "[a < b <= c]"),
        ("a + 1 == b - 1", "[(a + 1) == (b - 1)]"),
        ("!a == b", "[(!a) == b]"),
        ("a == 1 && b == 2 || c", "(([a == 1] && [b == 2]) || c)"),
        ("a || b && c", "((a || b) && c)"),
        ("a > 1 ? b : c", "([a > 1] ? b : c)"),
        ("a ? b ? 1 : 2 : 3", "(a ? (b ? 1 : 2) : 3)"),
        ("a ? x := 1 : 2", "(a ? (x := 1) : 2)"),
        ("a + 1 ? !b : 0", "((a + 1) ? (!b) : 0)"),
        ("x := a ? b : c", "(x := (a ? b : c))"),
        ("x += (y -= 1)", "(x += (y -= 1))"),
        ("(x) := 1", "(x := 1)"),
        ("x=-1", "(x = (-1))"),
        ("a==-1", "[a == (-1)]"),
        ("a!=!b", "[a != (!b)]"),
        ("(a + 1) & 2", "((a + 1) & 2)"),
    ],
)
def test_precedence(text: str, meaning: str) -> None:
    (statement,) = parse_script(text).statements
    assert shown(statement) == meaning


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("5", 5),
        ("+5", 5),
        ("00012", 12),
        ("0x1F", 31),
        ("0X1f", 31),
        ("9223372036854775807", 2**63 - 1),
        ("1.5", 1.5),
        ("1e3", 1000.0),
        ("1.5E-3", 0.0015),
        ("true", True),
        ("false", False),
        ("'hello world '", "hello world "),
        ('"it\'s"', "it's"),
        ("'a\\n'", "a\\n"),
        ("'a;b'", "a;b"),
        ("''", ""),
    ],
)
def test_literals(text: str, value: object) -> None:
    (statement,) = parse_script(text).statements
    assert isinstance(statement, Constant)
    assert statement.value == value
    assert type(statement.value) is type(value)


@pytest.mark.parametrize("text", ["battery", "_mine", "@shared", "x1_y", "größe"])
def test_names(text: str) -> None:
    (statement,) = parse_script(text).statements
    assert statement == Variable(text, 1)


def test_statements_blanks_and_broken_lines() -> None:
    script = parse_script(" x := 1;\n\ty := (2 +\r\n 3) ; x \\\n += y ")
    assert [shown(each) for each in script.statements] == ["(x := 1)", "(y := (2 + 3))", "(x += y)"]


def test_what_a_script_reads_writes_and_makes() -> None:
    script = parse_script("x := y + y; z = x; n += 1; a ? (b := 'q') : c")
    assert (script.reads, script.writes, script.creates) == (
        ("y", "x", "a", "c", "n"),
        ("x", "z", "n", "b"),
        ("x", "b"),
    )
    assert script.constants_written == (("b", "q"),)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the script is empty"),
        ("  \n ", "the script is empty"),
        ("x :=", "character 5: the end cannot stand here; a value must"),
        (";x := 1", 'character 1: ";" cannot stand here; a value must'),
        ("x := 1;;y := 2", 'character 8: ";" cannot stand here; a value must'),
        ("x := 1;", "character 8: nothing follows the last ;, leave it out"),
        ("x := 1 y := 2", 'character 8: "y" cannot stand here; statements have ; between'),
        ("x := 1\ny := 2", 'character 8: "y" cannot stand here; statements have ; between'),
        ("x := 1)", 'character 7: ")" cannot stand here; statements have ; between'),
        ("x := (1", 'character 8: ")" is missing for the ( of character 6'),
        ("a ? b", 'character 6: ":" is missing for the ? of character 3'),
        ("x := y := 3", "character 8: := cannot follow another one; use parentheses"),
        ("x := 1 = 1", "character 8: = cannot follow another one; use parentheses"),
        ("1 := 2", "character 3: what stands before := must be the name of an entry"),
        ("a - b := 1", "character 7: what stands before := must be the name of an entry"),
        ("x := 1.", 'character 6: "1." is no number; put a blank behind the number'),
        ("x := .5", 'character 6: "." is no part of a script'),
        ("x := 1e", 'character 6: "1e" is no number; put a blank behind the number'),
        ("x := 0xg", "character 8: a digit of a hexadecimal number is missing"),
        ("x := 1_000", 'character 6: "1_" is no number; put a blank behind the number'),
        ("x := + 5", 'character 6: "+" cannot stand here; a value must'),
        ("x := +'5'", 'character 6: "+" cannot stand here; a value must'),
        ("x := 1e400", "character 6: 1e400 is too large"),
        ("x := 9223372036854775808", "character 6: 9223372036854775808 is larger than 9223372036854775807"),
        ("x@ := 1", "character 2: a name must follow @"),
        ("@ := 1", "character 1: a name must follow @"),
        ("falsey := 2", 'character 1: a name cannot begin with "false", as "falsey" does'),
        ("true := 1", "character 6: what stands before := must be the name of an entry"),
        ("x := [1]", 'character 6: "[" is no part of a script'),
        ("x := 1 // one", "character 8: a script has no comments; write an XML comment beside the node"),
        ("x := a and b", 'character 8: "and" cannot stand here; statements have ; between'),
        ("x := 2 ** 3", 'character 9: "*" cannot stand here; a value must'),
        ("x => 1", 'character 4: ">" cannot stand here; a value must'),
        ("!-1", "character 2: -: bit operators and arithmetic cannot be mixed; use parentheses"),
    ],
)
def test_what_is_no_script(text: str, message: str) -> None:
    with pytest.raises(ScriptError) as caught:
        parse_script(text)
    assert str(caught.value) == message


@pytest.mark.parametrize(
    "text",
    [
        "1 + 2 & 3",
        "-1 & 3",
        "~1 + 2",
        "'a' .. 1 + 2",
        "1 + 1 == 2 && 2 & 2 == 2",
        "!a && b + 1",
        "a == -1 && !b",
        "'q' .. a == 'z' && !b",
        "!a ? b + 1 : b - 1",
    ],
)
def test_kinds_of_operators_do_not_mix(text: str) -> None:
    with pytest.raises(ScriptError, match=r"cannot be mixed; use parentheses$"):
        parse_script(text)


def test_long_and_deep_scripts_are_refused() -> None:
    parse_script("(" * MAX_DEPTH + "1" + ")" * MAX_DEPTH)
    parse_script(" + ".join(["1"] * MAX_DEPTH))
    for text in (
        "(" * (MAX_DEPTH + 1) + "1" + ")" * (MAX_DEPTH + 1),
        " + ".join(["1"] * (MAX_DEPTH + 1)),
        "-" * 5000 + "1",
        "(" * 5000,
        "a ? " * 300 + "1",
    ):
        with pytest.raises(ScriptError, match=f"nested more than {MAX_DEPTH} deep"):
            parse_script(text)
    with pytest.raises(ScriptError, match=f"longer than {MAX_CHARACTERS} characters"):
        parse_script("x" * (MAX_CHARACTERS + 1))


ATOMS = (
    "x",
    "1",
    "2.5",
    "'a'",
    "true",
    "(",
    ")",
    "?",
    ":",
    ";",
    ":=",
    "=",
    "+=",
    "+",
    "-",
    "*",
    "/",
    "&",
    "|",
    "~",
    "!",
)
WORDS = (*ATOMS, "==", "<", "&&", "||", "..", "@", '"', "'", ".", "0x", "\\\n", "é", "\0")


@given(st.lists(st.sampled_from(WORDS), max_size=12).map(" ".join) | st.text(max_size=40))
def test_any_text_is_a_script_or_a_script_error(text: str) -> None:
    try:
        script = parse_script(text)
    except ScriptError:
        return
    assert isinstance(script, Script)
    assert script.statements

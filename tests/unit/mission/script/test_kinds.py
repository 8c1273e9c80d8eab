"""What of a script is known to fail before it runs."""

from __future__ import annotations

import pytest

from target_nav.mission.script import ScriptError, check_kinds, parse_script


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x := 'a' * 2", "character 10: * cannot be used with text"),
        ("x := 'a' + 2 - 'b'", "character 10: + cannot be used with text"),
        ("x := -'a'", "character 6: - cannot be used with text"),
        ("x := y && 'a'", "character 8: && cannot be used with text"),
        ("x := 1 .. 2", "character 8: .. joins texts, and both sides are numbers"),
        ("x := 2 == 'red'", "character 11: text 'red' is no number, and it is compared with a number"),
        ("x -= 'a'", "character 3: -= cannot be used with text"),
        ("x := (1 ? 'a' : 'b') + 1", "character 22: + cannot be used with text"),
    ],
)
def test_operators_that_cannot_work(text: str, message: str) -> None:
    with pytest.raises(ScriptError) as caught:
        check_kinds(parse_script(text), {}, decides=False)
    assert str(caught.value) == message


@pytest.mark.parametrize(
    "text",
    [
        "x + 'a'",
        "x .. 1",
        "x == 'red'",
        "2 == '2'",
        "RED == 'RED'",
        "2 == 'RED'",
        "x := 'a' + y",
        "(1 ? 'a' : 2) + 1",
    ],
)
def test_what_may_work_is_let_through(text: str) -> None:
    check_kinds(parse_script(text), {"RED": 1}, decides=False)


def test_a_condition_must_be_able_to_be_true() -> None:
    for text in ("'yes'", "x .. 'a'", "x := 'a'"):
        check_kinds(parse_script(text), {}, decides=False)
        with pytest.raises(ScriptError, match="its value is text; it must be true or false"):
            check_kinds(parse_script(text), {}, decides=True)
    check_kinds(parse_script("x := 'a'; x == 'a'"), {}, decides=True)

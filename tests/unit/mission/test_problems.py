from __future__ import annotations

import pytest

from target_nav.mission.problems import MAX_PROBLEMS, Position, Problem, Report, TooManyProblems, did_you_mean


def test_a_problem_reads_like_a_compilers() -> None:
    assert str(Problem("a.xml", 3, 5, "error", "wrong")) == "a.xml:3:5: error: wrong"


def test_problems_come_in_the_order_of_reading_and_once() -> None:
    report = Report()
    main, part = "main.xml", "a_part.xml"
    for at in (Position(main, 9, 1), Position(part, 2, 2), Position(main, 3, 7), Position(main, 3, 7)):
        report.error(at, "wrong")
    report.warning(Position(main, 3, 2), "odd")
    assert [(p.file, p.line, p.column) for p in report.problems()] == [
        (main, 3, 2),
        (main, 3, 7),
        (main, 9, 1),
        (part, 2, 2),
    ]


def test_warnings_are_no_errors() -> None:
    report = Report()
    report.warning(Position("a.xml"), "odd")
    assert not report.has_errors
    report.error(Position("a.xml"), "wrong")
    assert report.has_errors


def test_a_hopeless_file_is_not_read_to_its_end() -> None:
    report = Report()
    for line in range(MAX_PROBLEMS):
        report.error(Position("a.xml", line + 1), "wrong")
    with pytest.raises(TooManyProblems):
        report.error(Position("a.xml", MAX_PROBLEMS + 1), "wrong")
    assert len(report.problems()) == MAX_PROBLEMS + 1
    assert report.problems()[-1].message == "more problems, not looked for"


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("Sequense", '; did you mean "Sequence"?'),
        ("SEQUENCE", '; did you mean "Sequence"?'),
        ("Elephant", ""),
    ],
)
def test_the_nearest_name(name: str, hint: str) -> None:
    assert did_you_mean(name, ("Fallback", "Sequence")) == hint

"""Warnings: all counted, few logged. Logs of many processes: one file, in order."""

from __future__ import annotations

import logging
from pathlib import Path

import pytest

from target_nav.app.log_merge import LogMerger, last_lines
from target_nav.app.logs import CountedWarnings


def test_a_kind_is_logged_once_in_a_while_and_always_counted(caplog: pytest.LogCaptureFixture) -> None:
    now_s = 0.0
    warnings = CountedWarnings(logging.getLogger("test"), every_s=5.0, clock=lambda: now_s)
    for now_s in (0.0, 1.0, 2.0, 5.5, 6.0):
        warnings.warn("scan.empty", f"at {now_s}")
    warnings.warn("other", "another kind")
    assert [record.message for record in caplog.records] == [
        "at 0.0",
        "at 5.5 (2 more like it before)",
        "another kind",
    ]
    assert warnings.counts == {"scan.empty": 5, "other": 1}


def test_lines_are_merged_by_time_and_tracebacks_stay_together(tmp_path: Path) -> None:
    first, second = tmp_path / "a.log", tmp_path / "b.log"
    first.write_text("10:00:00.100 INFO a: one\n10:00:00.300 ERROR a: broke\nTraceback\n  line\n")
    second.write_text("10:00:00.200 INFO b: two\n10:00:00.400 INFO b: four\n")
    merger = LogMerger({"a": first, "bb": second}, tmp_path / "run.log")
    merger.pump()
    assert (tmp_path / "run.log").read_text().splitlines() == [
        "a  | 10:00:00.100 INFO a: one",
        "bb | 10:00:00.200 INFO b: two",
        "a  | 10:00:00.300 ERROR a: broke",
        "a  | Traceback",
        "a  |   line",
        "bb | 10:00:00.400 INFO b: four",
    ]


def test_a_line_is_copied_once_and_whole(tmp_path: Path) -> None:
    source = tmp_path / "a.log"
    merger = LogMerger({"a": source}, tmp_path / "run.log")
    merger.pump()
    for piece in ("one\ntw", "o\n", "", "three"):
        with source.open("a") as out:
            out.write(piece)
        merger.pump()
    assert list(merger.recent) == ["a | one", "a | two"]
    merger.pump(final=True)
    assert (tmp_path / "run.log").read_text() == "a | one\na | two\na | three\n"


def test_bytes_that_are_no_text_do_not_stop_the_log(tmp_path: Path) -> None:
    (tmp_path / "a.log").write_bytes(b"\xff\xfe\x00\n")
    LogMerger({"a": tmp_path / "a.log"}, tmp_path / "run.log").pump()
    assert (tmp_path / "run.log").read_text(encoding="utf-8").startswith("a | ")


def test_the_end_of_a_log(tmp_path: Path) -> None:
    path = tmp_path / "a.log"
    assert last_lines(path, 3) == []
    path.write_text("".join(f"line {n}\n" for n in range(10_000)))
    assert last_lines(path, 3) == ["line 9997", "line 9998", "line 9999"]


def test_a_log_that_logrotate_has_emptied_is_read_from_its_begin(tmp_path: Path) -> None:
    source = tmp_path / "a.log"
    source.write_text("12:00:00.000 INFO one, which is a long line\n12:00:00.100 half")
    merger = LogMerger({"a": source}, tmp_path / "run.log")
    merger.pump()
    source.write_text("")
    merger.pump()
    source.write_text("12:00:01.000 INFO two\n")
    merger.pump()
    assert [line.split("INFO ")[1] for line in merger.recent] == ["one, which is a long line", "two"]

"""Mission files: those of the folder can be changed, and nothing else on the machine."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.errors import MissionError
from target_nav.web.mission_files import MOST_BYTES, MissionFolder


@pytest.fixture
def folder(tmp_path: Path) -> MissionFolder:
    (tmp_path / "secret.xml").write_text("not yours")
    trees = tmp_path / "trees"
    (trees / "subtrees").mkdir(parents=True)
    (trees / "scenarios").mkdir()
    (trees / "one.xml").write_text("<root/>")
    (trees / "subtrees" / "part.yaml").write_text("tree: x")
    (trees / "scenarios" / "one.yaml").write_text("a test")
    (trees / "notes.txt").write_text("no mission")
    (trees / "link.xml").symlink_to(tmp_path / "secret.xml")
    (trees / "away").symlink_to(tmp_path)
    return MissionFolder(trees)


OUTSIDE = [
    "../secret.xml", "subtrees/../../secret.xml", "/etc/passwd.xml", "link.xml", "away/secret.xml", "./one.xml",
    ".hidden.xml", "one.txt", "one", "", "a\0b.xml", "nowhere/new.xml", "subtrees\\part.yaml", "x" * 400 + ".xml",
    "~root/x.xml", "one.xml/two.xml",
]  # fmt: skip


@pytest.mark.parametrize("name", OUTSIDE)
def test_no_name_leads_out_of_the_folder(folder: MissionFolder, name: str) -> None:
    with pytest.raises(MissionError):
        folder.read(name)
    with pytest.raises(MissionError):
        folder.save(name, "mine now", None)
    assert (folder.folder.parent / "secret.xml").read_text() == "not yours"


@given(st.text(alphabet="./\\ab_\0~ -", max_size=12).map(lambda stem: f"{stem}.xml"))
def test_whatever_is_a_name_lies_in_the_folder(tmp_path_factory: pytest.TempPathFactory, name: str) -> None:
    place = MissionFolder(tmp_path_factory.getbasetemp())
    try:
        path = place.path_of(name)
    except MissionError:
        return
    assert os.path.normpath(path).startswith(f"{place.folder}{os.sep}")


def test_missions_come_first_and_tests_and_links_not_at_all(folder: MissionFolder) -> None:
    assert folder.names() == ["one.xml", "subtrees/part.yaml"]


def test_a_file_that_was_read_can_be_saved_and_nothing_is_left_beside_it(folder: MissionFolder) -> None:
    text = folder.read("one.xml")
    os.chmod(folder.folder / "one.xml", 0o640)
    saved = folder.save("one.xml", "<root>ä</root>", text.version)
    assert folder.read("one.xml") == saved
    assert saved.version != text.version
    assert (folder.folder / "one.xml").stat().st_mode & 0o777 == 0o640
    assert sorted(p.name for p in folder.folder.iterdir() if p.name.startswith(".")) == []


def test_a_file_that_changed_meanwhile_is_not_overwritten(folder: MissionFolder) -> None:
    text = folder.read("one.xml")
    (folder.folder / "one.xml").write_text("somebody else's work")
    with pytest.raises(MissionError, match="has changed on disk"):
        folder.save("one.xml", "mine", text.version)
    with pytest.raises(MissionError, match="exists already"):
        folder.save("one.xml", "mine", None)
    assert folder.read("one.xml").text == "somebody else's work"


def test_a_new_file_is_made_only_where_there_is_none(folder: MissionFolder) -> None:
    assert folder.save("two.xml", "<root/>", None).text == "<root/>"
    with pytest.raises(MissionError, match="has changed on disk"):
        folder.save("three.xml", "<root/>", "0123456789abcdef")


def test_what_is_too_large_or_no_text_is_told(folder: MissionFolder) -> None:
    with pytest.raises(MissionError, match="bytes"):
        folder.save("two.xml", "x" * (MOST_BYTES + 1), None)
    (folder.folder / "bad.xml").write_bytes(b"\xff\xfe<root/>")
    with pytest.raises(MissionError, match="not UTF-8"):
        folder.read("bad.xml")
    os.mkfifo(folder.folder / "pipe.xml")
    with pytest.raises(MissionError):
        folder.read("pipe.xml")

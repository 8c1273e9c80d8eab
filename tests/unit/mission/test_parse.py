"""XML into elements with positions."""

from __future__ import annotations

import os
from pathlib import Path

from target_nav.mission.parse import MAX_BYTES, MAX_DEPTH, MAX_ELEMENTS, Element, parse_bytes, parse_file
from target_nav.mission.problems import Report


def parsed(data: bytes) -> Element:
    report = Report()
    root = parse_bytes(data, "m.xml", report)
    assert root is not None, report.problems()
    return root


def complaint(data: bytes) -> str:
    report = Report()
    assert parse_bytes(data, "m.xml", report) is None
    (problem,) = report.problems()
    return str(problem)


def place(element: Element) -> tuple[int, int]:
    return element.position.line, element.position.column


def places(element: Element) -> dict[str, tuple[int, int]]:
    return {each.name: (each.position.line, each.position.column) for each in element.attributes}


def test_tags_and_attributes_know_where_they_stand() -> None:
    root = parsed(
        b"""<root a="1">
  <!-- > "quotes" and <tags> in a comment -->
  <Node  first = 'a > b "c"'
     second="&lt;'&#10;'"/>
</root>"""
    )
    node = root.children[0]
    assert (place(root), place(node)) == ((1, 1), (3, 3))
    assert places(node) == {"first": (3, 10), "second": (4, 6)}
    assert [each.value for each in node.attributes] == ['a > b "c"', "<'\n'"]


def test_columns_are_characters_and_lines_end_in_any_way() -> None:
    root = parsed('<root\r\n  größe="ü"\r  zweite="€" dritte="x">\n<Nöde/></root>'.encode())
    assert places(root) == {"größe": (2, 3), "zweite": (3, 3), "dritte": (3, 14)}
    assert place(root.children[0]) == (4, 1)


def test_a_byte_order_mark_is_no_character() -> None:
    assert place(parsed(b"\xef\xbb\xbf<root/>")) == (1, 1)


def test_text_is_what_stands_between_tags() -> None:
    root = parsed(b"<root> one <a/>\n <![CDATA[two]]> </root>")
    assert (root.text, root.children[0].text) == ("onetwo", "")


def test_what_is_not_utf8_is_told_with_its_place() -> None:
    assert (
        complaint(b'<root>\n  <a b="\xfc"/></root>')
        == "m.xml:2:9: error: is not UTF-8 (byte 0xfc); save the file as UTF-8"
    )
    assert "is not UTF-8" in complaint("<root/>".encode("utf-16"))


def test_too_large_a_file_is_refused() -> None:
    assert complaint(b"<root>" + b" " * MAX_BYTES + b"</root>").endswith(
        f"is larger than {MAX_BYTES} bytes, the most a mission file may have"
    )


def test_too_many_tags_are_refused() -> None:
    fits = b"<a/>" * (MAX_ELEMENTS - 1)
    assert len(parsed(b"<root>" + fits + b"</root>").children) == MAX_ELEMENTS - 1
    assert complaint(b"<root>" + fits + b"<a/></root>").endswith(
        f"has more than {MAX_ELEMENTS} tags, the most a mission file may have"
    )


def test_too_deep_a_file_is_refused() -> None:
    fits = b"<a>" * MAX_DEPTH + b"</a>" * MAX_DEPTH
    assert parsed(fits).tag == "a"
    assert complaint(b"<a>" + fits + b"</a>").endswith(f"is nested more than {MAX_DEPTH} deep; use a SubTree")


def test_entities_are_never_expanded() -> None:
    bomb = (
        b'<!DOCTYPE x [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]><root>&b;&b;&b;</root>'
    )
    assert complaint(bomb) == "m.xml:1:1: error: has a <!DOCTYPE>; missions have none, take it out"
    external = b'<?xml version="1.0"?>\n<!DOCTYPE root SYSTEM "file:///etc/passwd"><root/>'
    assert complaint(external) == "m.xml:2:1: error: has a <!DOCTYPE>; missions have none, take it out"
    assert complaint(b"<root>&secret;</root>") == "m.xml:1:7: error: is not well-formed XML: undefined entity"


def test_a_file_that_cannot_be_read_is_told(tmp_path: Path) -> None:
    fifo = tmp_path / "pipe.xml"
    os.mkfifo(fifo)
    for path in (tmp_path / "missing.xml", tmp_path, fifo, Path("nul\0.xml")):
        report = Report()
        assert parse_file(path, "m.xml", report) is None
        (problem,) = report.problems()
        assert problem.message in ("there is no such file", "cannot be read: embedded null byte")

"""One notation into the other, without loss: what was written is read again and compared before it is kept."""

from __future__ import annotations

from pathlib import Path

from target_nav.errors import MissionError
from target_nav.mission.convert_comments_xml import source_of_xml
from target_nav.mission.convert_comments_yaml import source_of_yaml
from target_nav.mission.convert_source import Source, same_mission
from target_nav.mission.document import read_document
from target_nav.mission.notations import Notation, required_notation
from target_nav.mission.parse import Element, parse_bytes, read_bytes
from target_nav.mission.problems import Report, TooManyProblems
from target_nav.mission.xml_writer import write_xml
from target_nav.mission.yaml_reader import decoded, read_yaml
from target_nav.mission.yaml_writer import write_yaml


def convert(path: Path, to: Notation) -> str:
    """A mission file's text in a notation; in its own, that is the same file tidied.

    Only the file itself is rewritten: what it includes stays where it is and as it is.

    Raises:
        MissionError: the file cannot be read, is no mission, or has what the other notation cannot say.
    """
    report = Report()
    data = read_bytes(path, str(path), report)
    if data is None:
        raise MissionError("\n".join(map(str, report.problems())))
    source = read_source(data, required_notation(path), str(path))
    text = write_xml(source) if to is Notation.XML else write_yaml(source)
    again = read_source(text.encode("utf-8"), to, f"{path} as {to.value}")
    if not same_mission(source.root, again.root):
        raise MissionError(f"{path}: cannot be written as {to.value} without a change of its meaning")
    return text


def read_source(data: bytes, notation: Notation, shown: str) -> Source:
    """A file's content with its comments.

    Raises:
        MissionError: it is not well-formed, or not a mission; one line a problem.
    """
    report = Report()
    try:
        source = _read(data, notation, shown, report)
    except TooManyProblems:
        source = None
    if source is None or report.has_errors:
        raise MissionError("\n".join(str(each) for each in report.problems() if each.severity == "error"))
    return source


def _read(data: bytes, notation: Notation, shown: str, report: Report) -> Source | None:
    if notation is Notation.XML:
        root = parse_bytes(data, shown, report)
        if root is None or not _is_mission(root, shown, report):
            return None
        return source_of_xml(data, root)
    text = decoded(data, shown, report)
    mission = read_yaml(data, shown, report)
    if text is None or mission is None or not _is_mission(mission.root, shown, report):
        return None
    return source_of_yaml(text, mission)


def _is_mission(root: Element, shown: str, report: Report) -> bool:
    read_document(root, Path(shown), shown, report)
    return not report.has_errors

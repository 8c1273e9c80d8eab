"""Which notation a mission file is in, by its suffix, and the reader for it."""

from __future__ import annotations

from enum import Enum
from pathlib import Path

from target_nav.errors import MissionError
from target_nav.mission.parse import Element, parse_bytes, read_bytes
from target_nav.mission.problems import Report
from target_nav.mission.yaml_reader import SUFFIXES as YAML_SUFFIXES
from target_nav.mission.yaml_reader import parse_yaml_bytes


class Notation(str, Enum):
    XML = "XML"
    YAML = "YAML"


def notation_of(path: Path) -> Notation | None:
    """None for a suffix that is neither's."""
    suffix = path.suffix.lower()
    if suffix in YAML_SUFFIXES:
        return Notation.YAML
    return Notation.XML if suffix == ".xml" else None


def required_notation(path: Path) -> Notation:
    """
    Raises:
        MissionError: the suffix tells of no notation.
    """
    notation = notation_of(path)
    if notation is None:
        shown = f'suffix "{path.suffix}"' if path.suffix else "no suffix"
        raise MissionError(f"{path}: has {shown}; a mission file ends in .xml, .yaml or .yml")
    return notation


def parse_mission_file(path: Path, shown: str, report: Report) -> Element | None:
    """The root element of a file in either notation, or None after reporting why there is none.

    A file whose suffix says nothing is taken for XML.
    """
    data = read_bytes(path, shown, report)
    if data is None:
        return None
    if notation_of(path) is Notation.YAML:
        return parse_yaml_bytes(data, shown, report)
    return parse_bytes(data, shown, report)

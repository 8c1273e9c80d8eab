"""Whatever a YAML file holds, it loads or it is a MissionError; and what loads can be converted, or it is one too."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from py_trees.blackboard import Blackboard

from target_nav.errors import MissionError
from target_nav.mission import load_mission
from target_nav.mission.check import check_file
from target_nav.mission.convert import convert
from target_nav.mission.notations import Notation
from tests.unit.mission.fuzzing import FUZZ, mutilated
from tests.unit.mission.vocabulary import registry

FOLDER = Path(__file__).parent / "broken_yaml"
REGISTRY = registry()
SEEDS = [
    path.read_bytes().decode("utf-8", "replace").split("# expect")[0]
    for path in sorted(FOLDER.glob("*.yaml"))
]


def load_or_refuse(data: bytes) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "mission.yaml"
        path.write_bytes(data)
        Blackboard.clear()
        errors = [problem for problem in check_file(path, REGISTRY) if problem.severity == "error"]
        assert all(problem.line >= 1 and problem.column >= 1 for problem in errors)
        assert all("\n" not in problem.message for problem in errors)
        if errors:
            with pytest.raises(MissionError):
                load_mission(path, REGISTRY)
        else:
            load_mission(path, REGISTRY)
        try:
            convert(path, Notation.XML)
        except MissionError:
            assert errors, "a mission that loads can be converted"


@FUZZ
@given(st.binary(max_size=400))
def test_any_bytes(data: bytes) -> None:
    load_or_refuse(data)


@FUZZ
@given(st.text(alphabet=st.sampled_from("aA:-?[]{},#&*!|>'\"%@`\n\t 1.<=~\\\x85\ufeffé"), max_size=60))
def test_any_punctuation_inside_a_mission(text: str) -> None:
    load_or_refuse(f"BTCPP_format: 4\ntrees:\n  Main:\n    Sequence:\n    - Drive: {text}\n".encode())


@FUZZ
@given(mutilated(SEEDS, ["\n", "  ", "- ", ": ", "#", "&a ", "*a", "!!int "]))
def test_missions_with_pieces_cut_out_doubled_and_swapped(text: str) -> None:
    load_or_refuse(text.encode())

"""Whatever a YAML file holds, it loads or it is a MissionError; and what loads can be converted, or it is one too."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from py_trees.blackboard import Blackboard

from target_nav.errors import MissionError
from target_nav.mission import load_mission
from target_nav.mission.check import check_file
from target_nav.mission.convert import convert
from target_nav.mission.notations import Notation
from tests.unit.mission.vocabulary import registry

QUICK = settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.too_slow])
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


@QUICK
@given(st.binary(max_size=400))
def test_any_bytes(data: bytes) -> None:
    load_or_refuse(data)


@QUICK
@given(st.text(alphabet=st.sampled_from("aA:-?[]{},#&*!|>'\"%@`\n\t 1.<=~\\\x85\ufeffé"), max_size=60))
def test_any_punctuation_inside_a_mission(text: str) -> None:
    load_or_refuse(f"BTCPP_format: 4\ntrees:\n  Main:\n    Sequence:\n    - Drive: {text}\n".encode())


@QUICK
@given(st.sampled_from(SEEDS), st.data())
def test_missions_with_pieces_cut_out_doubled_and_swapped(seed: str, data: st.DataObject) -> None:
    text = seed
    for _ in range(data.draw(st.integers(1, 4))):
        begin, end = sorted(data.draw(st.tuples(st.integers(0, len(text)), st.integers(0, len(text)))))
        piece = text[begin:end]
        insert = data.draw(
            st.sampled_from(["", piece * 2, piece[::-1], "\n", "  ", "- ", ": ", "#", "&a ", "*a", "!!int "])
        )
        text = text[:begin] + insert + text[end:]
    load_or_refuse(text.encode())

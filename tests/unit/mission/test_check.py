"""What the check does as a whole; each single message is in the corpus `broken/`."""

from __future__ import annotations

from pathlib import Path

from target_nav.mission import load_mission
from target_nav.mission.check import check_file
from target_nav.mission.problems import MAX_PROBLEMS
from tests.unit.mission.scripted import document
from tests.unit.mission.vocabulary import registry


def check(folder: Path, *trees: str) -> list[str]:
    path = folder / "mission.xml"
    path.write_text(document(*trees), encoding="utf-8")
    return [f"{problem.severity}: {problem.message}" for problem in check_file(path, registry())]


def test_a_good_mission_has_no_problems(tmp_path: Path) -> None:
    assert check(tmp_path, "<Sequence><Look/></Sequence>") == []


def test_a_warning_does_not_keep_a_mission_from_running(tmp_path: Path) -> None:
    path = tmp_path / "mission.xml"
    model = '<TreeNodesModel><Action ID="Look"><input_port name="x"/></Action></TreeNodesModel></root>'
    path.write_text(document("<Look/>").replace("</root>", model), encoding="utf-8")
    (problem,) = check_file(path, registry())
    assert (problem.severity, problem.message) == ("warning", "Look has no port x; its ports: none")
    load_mission(path, registry())


def test_trees_nobody_uses_are_checked_as_well(tmp_path: Path) -> None:
    (message,) = check(tmp_path, "<Look/>", '<BehaviorTree ID="Unused"><Lok/></BehaviorTree>')
    assert message.startswith("error: unknown node Lok")


def test_a_tree_used_twice_is_told_of_once(tmp_path: Path) -> None:
    twice = '<Sequence><SubTree ID="T"/><SubTree ID="T"/></Sequence>'
    assert check(tmp_path, twice, '<BehaviorTree ID="T"><Drive speed_mps="9"/></BehaviorTree>') == [
        'error: Drive: speed_mps is "9"; it must lie in 0.02 ... 5 m/s'
    ]


def test_an_error_is_not_told_again_in_its_consequences(tmp_path: Path) -> None:
    """Whoever writes {d} cannot be known while its node or its attribute is misspelt."""
    read = '<Drive speed_mps="{d}"/>'
    (node,) = check(tmp_path, f'<Sequence><Meassure distance_m="{{d}}"/>{read}</Sequence>')
    assert node.startswith("error: unknown node Meassure")
    (port,) = check(tmp_path, f'<Sequence><Measure distance="{{d}}"/>{read}</Sequence>')
    assert port.startswith("error: Measure has no attribute distance; did you mean")
    (subtree,) = check(tmp_path, f'<Sequence><SubTree ID="T" d="{{d}}"/>{read}</Sequence>')
    assert subtree.startswith('error: there is no tree "T"')


def test_a_writer_may_come_after_its_reader(tmp_path: Path) -> None:
    assert check(tmp_path, '<Sequence><Drive speed_mps="{d}"/><Measure distance_m="{d}"/></Sequence>') == []


def test_a_node_that_can_be_skipped_is_a_condition_only_if_it_says_so(tmp_path: Path) -> None:
    def skippable(condition: str) -> bool:
        return bool(check(tmp_path, f"<IfThenElse>{condition}<Look/></IfThenElse>"))

    assert skippable("<RunOnce><Look/></RunOnce>")
    assert skippable("<Sequence><RunOnce><Look/></RunOnce><RunOnce><Look/></RunOnce></Sequence>")
    assert skippable("<IfThenElse><Look/><RunOnce><Look/></RunOnce></IfThenElse>")
    assert not skippable('<RunOnce then_skip="false"><Look/></RunOnce>')
    assert not skippable("<Sequence><RunOnce><Look/></RunOnce><Look/></Sequence>")
    assert not skippable("<KeepRunningUntilFailure><RunOnce><Look/></RunOnce></KeepRunningUntilFailure>")


def test_a_hopeless_file_is_given_up(tmp_path: Path) -> None:
    found = check(tmp_path, f"<Sequence>{'<Nonsense/>' * 50}{'<N/>' * 10_000}</Sequence>")
    assert len(found) == MAX_PROBLEMS + 1

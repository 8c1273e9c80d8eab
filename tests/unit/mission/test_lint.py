"""What is allowed and hardly meant. The laws at the end hold the analysis against trees that really run."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from py_trees.blackboard import Blackboard
from py_trees.common import Status

from behaviours.motion import MotionLeaf
from target_nav.errors import MissionError
from target_nav.mission import NodeRegistry, default_registry, load_mission
from target_nav.mission.build import build
from target_nav.mission.check import analyse
from target_nav.mission.expand import Instance
from target_nav.mission.lint import lint
from target_nav.mission.lint_results import FAILURE, RUNNING, SKIPPED, SUCCESS, Reachability
from target_nav.mission.nodes.ticking import SKIPPED_MESSAGE
from target_nav.mission.tree_note import visited_by
from tests.unit.mission.oracle import TICKS, make_trial
from tests.unit.mission.scripted import document, scripted_leaves, set_clock
from tests.unit.mission.vocabulary import registry

TICK_S = 0.05


def warnings(folder: Path, *trees: str, words: NodeRegistry | None = None) -> list[str]:
    path = folder / "mission.xml"
    path.write_text(document(*trees), encoding="utf-8")
    analysis = analyse(path, words or registry())
    assert not analysis.errors, analysis.errors
    found = lint(analysis, TICK_S)
    assert all(problem.severity == "warning" for problem in found)
    return [problem.message for problem in found]


# -- nodes that are never ticked ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("tree", "why"),
    [
        ("<Fallback><AlwaysSuccess/><Look/></Fallback>", "AlwaysSuccess before it always succeeds"),
        (
            "<ReactiveFallback><Look/><AlwaysSuccess/><Look/></ReactiveFallback>",
            "AlwaysSuccess before it always succeeds",
        ),
        (
            "<Sequence><Inverter><AlwaysSuccess/></Inverter><Look/></Sequence>",
            "Inverter before it always fails",
        ),
        (
            "<Fallback><ForceSuccess><Look/></ForceSuccess><Look/></Fallback>",
            "ForceSuccess before it never fails",
        ),
        (
            "<Sequence><KeepRunningUntilFailure><Look/></KeepRunningUntilFailure><Look/></Sequence>",
            "KeepRunningUntilFailure before it never succeeds",
        ),
        (
            "<Sequence><Repeat num_cycles='-1'><Look/></Repeat><Look/></Sequence>",
            "Repeat before it never succeeds",
        ),
        (
            "<Fallback><RetryUntilSuccessful num_attempts='-1'><Look/></RetryUntilSuccessful><Look/></Fallback>",
            "RetryUntilSuccessful before it never fails",
        ),
        ("<Repeat num_cycles='0'><Look/></Repeat>", "num_cycles is 0"),
        (
            "<IfThenElse><AlwaysSuccess/><Look/><Look/></IfThenElse>",
            "its condition AlwaysSuccess always succeeds",
        ),
        ("<TryCatch><AlwaysSuccess/><Look/></TryCatch>", "nothing before it fails"),
        ("<TryCatch catch_on_halt='false'><AlwaysSuccess/><Look/></TryCatch>", "nothing before it fails"),
        (
            "<WhileDoElse><AlwaysFailure/><Look/><Look/></WhileDoElse>",
            "its condition AlwaysFailure always fails",
        ),
    ],
)
def test_unreachable(tree: str, why: str, tmp_path: Path) -> None:
    assert warnings(tmp_path, tree) == [f"Look is never ticked: {why}"]


def test_a_row_of_unreachable_nodes_is_told_of_once(tmp_path: Path) -> None:
    assert warnings(tmp_path, "<Sequence><AlwaysFailure/><Look/><Look/></Sequence>") == [
        "Look is never ticked, nor is the one after it: AlwaysFailure before it always fails"
    ]
    assert warnings(tmp_path, "<Sequence><AlwaysFailure/><Look/><Look/><Look/></Sequence>") == [
        "Look is never ticked, nor are the 2 after it: AlwaysFailure before it always fails"
    ]


@pytest.mark.parametrize(
    "tree",
    [
        "<Fallback><Look/><AlwaysSuccess/></Fallback>",
        "<Sequence><ForceSuccess><Look/></ForceSuccess><Look/></Sequence>",
        "<Sequence><Sleep msec='100'/><Look/></Sequence>",
        "<Fallback><RunOnce><AlwaysSuccess/></RunOnce><Look/></Fallback>",
        "<Sequence><Repeat num_cycles='3'><Look/></Repeat><Look/></Sequence>",
        "<Sequence><Timeout msec='100'><Repeat num_cycles='-1'><Look/></Repeat></Timeout><Look/></Sequence>"
        .replace("Sequence", "Fallback"),
        "<Parallel><AlwaysFailure/><Look/></Parallel>",
        "<TryCatch><Look/><Look/></TryCatch>",
        "<TryCatch catch_on_halt='true'><AlwaysSuccess/><Look/></TryCatch>",
        "<Fallback><AlwaysSuccess _skipIf='true'/><Look/></Fallback>",
        "<Sequence><AlwaysFailure _successIf='true'/><Look/></Sequence>",
        "<IfThenElse><Look/><AlwaysSuccess/></IfThenElse>",
    ],
)  # fmt: skip
def test_reachable(tree: str, tmp_path: Path) -> None:
    assert warnings(tmp_path, tree) == []


def test_what_comes_behind_a_leaf_that_never_ends(tmp_path: Path) -> None:
    tree = "<Sequence><Timeout msec='1000'><Idle/></Timeout><GiveUp/></Sequence>"
    (message,) = warnings(tmp_path, tree, words=default_registry())
    assert message == "GiveUp is never ticked: Timeout before it never succeeds"
    tree = "<Fallback><Idle/><GiveUp/></Fallback>"
    (message,) = warnings(tmp_path, tree, words=default_registry())
    assert message == "GiveUp is never ticked: Idle before it never ends"


def test_subtrees_are_looked_into(tmp_path: Path) -> None:
    main = "<Fallback><SubTree ID='T'/><Look/></Fallback>"
    assert warnings(tmp_path, main, '<BehaviorTree ID="T"><AlwaysSuccess/></BehaviorTree>') == [
        "Look is never ticked: T before it always succeeds"
    ]


# -- keys, searches, timeouts ------------------------------------------------------------------------------------------


def test_keys_that_nobody_reads(tmp_path: Path) -> None:
    measure = "<Measure distance_m='{far}'/>"
    assert warnings(tmp_path, measure) == ["Measure: distance_m writes {far} (/far), which nobody reads"]
    assert warnings(tmp_path, f"<Sequence>{measure}<Drive speed_mps='{{far}}'/></Sequence>") == []
    assert warnings(
        tmp_path,
        "<Sequence><SubTree ID='T' d='{far}'/><Drive speed_mps='{far}'/></Sequence>",
        "<BehaviorTree ID='T'><Measure distance_m='{d}'/></BehaviorTree>",
    ) == []  # fmt: skip


def test_scripts_and_named_entries_read_and_write_too(tmp_path: Path) -> None:
    script = "<Script code='far := 1'/>"
    assert warnings(tmp_path, script) == ["Script: code writes far (/far), which nobody reads"]
    assert warnings(tmp_path, f"<Sequence>{script}<ScriptCondition code='far > 2'/></Sequence>") == []
    assert warnings(tmp_path, f"<Sequence>{script}<Look _skipIf='far > 2'/></Sequence>") == []
    assert warnings(tmp_path, f"<Sequence>{script}<WasEntryUpdated entry='far'/></Sequence>") == []


def test_a_search_without_an_end(tmp_path: Path) -> None:
    def found(tree: str) -> list[str]:
        return warnings(tmp_path, tree, words=default_registry())

    message = (
        "TurnSearch has no time limit; give it time_limit_s, or put it into a Timeout; without, the robot's "
        "configuration decides"
    )
    assert found("<TurnSearch/>") == [message]
    assert found("<Timeout msec='0'><TurnSearch/></Timeout>") == [message]
    assert found("<TurnSearch time_limit_s='20'/>") == []
    assert found("<Timeout msec='20000'><Sequence><TurnSearch/></Sequence></Timeout>") == []


def test_a_timeout_of_less_than_a_tick(tmp_path: Path) -> None:
    def found(msec: int) -> list[str]:
        return warnings(tmp_path, f"<Timeout msec='{msec}'><Look/></Timeout>")

    message = "Timeout: msec is {}; a tick takes 50 ms, so its child gets one tick only"
    assert found(20) == [message.format(20)]
    assert found(50) == [message.format(50)]
    assert found(51) == []
    assert found(0) == []


def test_a_face_of_a_target_that_has_none(tmp_path: Path) -> None:
    def found(target: str, side: str = "face") -> list[str]:
        go = f"<NavigateToTarget from='{side}'/>"
        tree = f"<Sequence><SetBlackboard value='apriltag' output_key='d'/>{target}{go}</Sequence>"
        return [each for each in warnings(tmp_path, tree, words=default_registry()) if "face" in each]

    size = "height_m='0.16' width_m='0.16'"
    assert found(f"<SetTarget class='7' detector='apriltag' {size}/>") == []
    assert found(f"<SetTarget class='red' detector='hsv' {size}/>", "anywhere") == []
    assert found("") == []
    (message,) = found(f"<SetTarget class='red' detector='hsv' {size}/>")
    assert "the target of this mission (hsv) has none" in message
    (message,) = found(f"<SetTarget class='bowling_pin' {size}/>")
    assert "(network)" in message


def test_the_reference_mission_has_nothing_to_be_warned_of() -> None:
    path = Path(__file__).parents[3] / "trees" / "bowling_pin.xml"
    assert lint(analyse(path), TICK_S) == []


def test_a_mission_that_cannot_be_read_has_no_warnings(tmp_path: Path) -> None:
    assert lint(analyse(tmp_path / "nowhere.xml"), TICK_S) == []


# -- two leaves that move the robot ------------------------------------------------------------------------------------


def test_two_leaves_that_move_the_robot_at_once_are_an_error(tmp_path: Path) -> None:
    path = tmp_path / "m.xml"
    trees = (
        "<Parallel><Sequence><TargetTracked/><TurnSearch time_limit_s='9'/></Sequence><SubTree ID='T'/></Parallel>",
        "<BehaviorTree ID='T'><HoldStill/></BehaviorTree>",
    )
    path.write_text(document(*trees), encoding="utf-8")
    with pytest.raises(MissionError) as caught:
        load_mission(path)
    (line,) = str(caught.value).splitlines()
    assert "error: Parallel can run TurnSearch (" in line
    assert ") and HoldStill (" in line
    assert line.endswith(
        "at once, and each of them moves the robot; let them take turns, in a Sequence or a Fallback"
    )


@pytest.mark.parametrize(
    "tree",
    [
        "<Parallel><TargetTracked/><Fallback><TurnSearch time_limit_s='9'/><Idle/></Fallback></Parallel>",
        "<ReactiveFallback><TurnSearch time_limit_s='9'/><Idle/></ReactiveFallback>",
    ],
)
def test_one_branch_may_move_the_robot(tree: str, tmp_path: Path) -> None:
    path = tmp_path / "m.xml"
    path.write_text(document(tree), encoding="utf-8")
    load_mission(path)


def test_every_motion_leaf_is_known_as_one() -> None:
    from target_nav.mission.lint_motion import moves_the_robot
    from target_nav.mission.model import Form, NodeDef
    from target_nav.mission.problems import Position
    from target_nav.mission.scope import Scope

    for spec in default_registry().specs():
        definition = NodeDef(spec.name, Form.COMPACT, spec.name, False, (), (), Position("m"))
        assert moves_the_robot(Instance(definition, Scope(), spec)) == issubclass(spec.cls, MotionLeaf), (
            spec.name
        )


# -- laws --------------------------------------------------------------------------------------------------------------

LETTER = {Status.SUCCESS: SUCCESS, Status.FAILURE: FAILURE, Status.RUNNING: RUNNING, Status.INVALID: SKIPPED}


def _children_first(instance: Instance) -> Iterator[Instance]:
    """In the order in which py_trees iterates over behaviours."""
    for child in instance.children:
        yield from _children_first(child)
    yield instance


@pytest.mark.parametrize("chunk", range(4))
def test_what_is_found_holds_in_trees_that_run(chunk: int, tmp_path: Path) -> None:
    """No node returns what it is said never to return, and no node is ticked that is said never to be."""
    unreachable = 0
    for seed in range(chunk * 50, chunk * 50 + 50):
        Blackboard.clear()
        set_clock(0.0)
        trial = make_trial(seed)
        path = tmp_path / "trial.xml"
        path.write_text(trial.xml, encoding="utf-8")
        analysis = analyse(path, NodeRegistry(scripted_leaves(trial.scripts, [])))
        assert analysis.root is not None
        found = Reachability(analysis.root)
        never = {each for instances, _ in found.unreachable for top in instances for each in top.walk()}
        unreachable += len(never)
        root = build(analysis.root)
        instance_of = dict(
            zip([node.id for node in root.iterate()], _children_first(analysis.root), strict=True)
        )
        for _ in range(TICKS):
            root.tick_once()
            for node in visited_by(root):
                instance = instance_of[node.id]
                assert instance not in never, f"seed {seed}: {node.name} was ticked\n{trial.xml}"
                # INVALID without that message was halted later in the same tick
                if node.status is not Status.INVALID or node.feedback_message == SKIPPED_MESSAGE:
                    results = found.results[instance]
                    assert LETTER[node.status] in results, f"seed {seed}: {node.name}\n{trial.xml}"
    assert unreachable, "the trees must have something to find"

"""From a file to a tree: forms, names, ports, subtrees, keys."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import py_trees
import pytest
from py_trees.blackboard import Blackboard
from py_trees.common import Status
from py_trees.ports import PortInformation

from target_nav.errors import MissionError
from target_nav.mission import LoadedMission, NodeRegistry, load_mission
from target_nav.mission.expand import MAX_DEPTH, MAX_NODES
from target_nav.mission.nodes import MissionNode, Sequence, SubTree
from target_nav.state.types import Pose2D
from tests.unit.mission.scripted import document, leaf_class
from tests.unit.mission.vocabulary import registry

MISSIONS = Path(__file__).parents[3] / "trees"


def load(
    folder: Path, *trees: str, extra: NodeRegistry | None = None, provided: tuple[str, ...] = ()
) -> LoadedMission:
    path = folder / "mission.xml"
    path.write_text(document(*trees), encoding="utf-8")
    return load_mission(path, extra or registry(), provided)


def find(mission: LoadedMission, name: str) -> Any:
    return next(node for node in mission.root.iterate() if node.name == name)


def shape(node: py_trees.behaviour.Behaviour) -> Any:
    kind = type(node).__name__
    return (kind, node.name, *map(shape, node.children)) if node.children else (kind, node.name)


@pytest.mark.parametrize("path", sorted(MISSIONS.glob("*.xml")), ids=lambda path: path.name)
def test_every_mission_that_is_shipped_loads(path: Path) -> None:
    mission = load_mission(path)
    assert mission.files[0] == path.resolve()
    mission.root.setup_with_descendants()


def test_what_a_loaded_mission_says_of_itself(tmp_path: Path) -> None:
    mission = load(tmp_path, "<Look/>")
    assert (mission.path, mission.main_tree, mission.files) == (
        tmp_path / "mission.xml",
        "Main",
        (mission.path,),
    )


def test_compact_and_explicit_forms_are_the_same(tmp_path: Path) -> None:
    compact = (
        "<Sequence><Inverter><Look/></Inverter><Drive speed_mps='1' name='go'/><SubTree ID='T'/></Sequence>"
    )
    explicit = """<Control ID="Sequence"><Decorator ID="Inverter"><Condition ID="Look"/></Decorator>
        <Action ID="Drive" speed_mps="1" name="go"/><SubTree ID="T"/></Control>"""
    tree = '<BehaviorTree ID="T"><Look name="last"/></BehaviorTree>'
    expected = (
        "Sequence",
        "Sequence",
        ("Inverter", "Inverter", ("Look", "Look")),
        ("Drive", "go"),
        ("SubTree", "T", ("Look", "last")),
    )
    assert shape(load(tmp_path, compact, tree).root) == expected
    assert shape(load(tmp_path, explicit, tree).root) == expected


def test_the_only_tree_needs_no_name_and_need_not_be_told(tmp_path: Path) -> None:
    path = tmp_path / "mission.xml"
    path.write_text('<root BTCPP_format="4"><BehaviorTree><Look/></BehaviorTree></root>', encoding="utf-8")
    assert load_mission(path, registry()).main_tree == "BehaviorTree_0"


def test_editors_attributes_are_accepted(tmp_path: Path) -> None:
    path = tmp_path / "mission.xml"
    path.write_text(
        """<?xml version="1.0" encoding="UTF-8"?>
        <root BTCPP_format="4" project_name="p" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
              xsi:noNamespaceSchemaLocation="mission.xsd">
          <BehaviorTree ID="Main" _fullpath="" _favorite="true">
            <Sequence _uid="1" _description="all of it"><SubTree ID="T" _collapsed="true"/></Sequence>
          </BehaviorTree>
          <BehaviorTree ID="T"><Look _uid="2"/></BehaviorTree>
          <TreeNodesModel>
            <Action ID="Look" editable="true"/>
            <Action ID="SomebodyElses"><input_port name="x" type="int">what it is for</input_port></Action>
            <Control ID="Parallel"><input_port name="failure_count" default="1"/><MetadataFields/></Control>
          </TreeNodesModel>
        </root>""".replace('BTCPP_format="4"', 'BTCPP_format="4" main_tree_to_execute="Main"'),
        encoding="utf-8",
    )
    assert shape(load_mission(path, registry()).root)[0] == "Sequence"


def test_built_ins_know_where_they_are_defined(tmp_path: Path) -> None:
    root = load(tmp_path, "<Sequence>\n <Look/></Sequence>").root
    assert isinstance(root, MissionNode)
    assert root.origin.startswith(f"{tmp_path}/mission.xml:1:")


# -- ports ---------------------------------------------------------------------------------------------------


def test_literals_reach_a_leaf_in_their_types(tmp_path: Path) -> None:
    mission = load(
        tmp_path, '<Drive speed_mps="1.5" label="__DOT__ v1.2/3 {x} ." laps="3" careful="true" name="go"/>'
    )
    leaf = find(mission, "go")
    values = {port: leaf.get_input(port) for port in ("speed_mps", "label", "laps", "careful")}
    assert values == {"speed_mps": 1.5, "label": "__DOT__ v1.2/3 {x} .", "laps": 3, "careful": True}
    assert [type(value) for value in values.values()] == [float, str, int, bool]


def test_ports_that_are_not_given_have_their_defaults(tmp_path: Path) -> None:
    leaf = find(load(tmp_path, '<Drive speed_mps="1"/>'), "Drive")
    assert (leaf.get_input("label"), leaf.get_input("laps"), leaf.get_input("careful")) == (
        "drives",
        1,
        False,
    )
    assert leaf.get_input("goal", Pose2D()) == Pose2D()
    with pytest.raises(py_trees.ports.NoDataAvailable):
        leaf.get_input("goal")


def test_two_leaves_of_one_name_do_not_share_their_literals(tmp_path: Path) -> None:
    root = load(tmp_path, '<Sequence><Drive speed_mps="1"/><Drive speed_mps="2"/></Sequence>').root
    assert [leaf.get_input("speed_mps") for leaf in root.children] == [1.0, 2.0]


def test_a_key_connects_an_output_with_an_input(tmp_path: Path) -> None:
    mission = load(
        tmp_path,
        '<Sequence><Measure distance_m="{d}"/><Drive speed_mps="{d}"/><Drive speed_mps=" {d} "/></Sequence>',
    )
    measure, drive, _ = mission.root.children
    measure._set_output("distance_m", 2.5)
    assert Blackboard.get("/d") == 2.5
    assert drive.get_input("speed_mps") == 2.5


def test_the_ports_own_name_as_key(tmp_path: Path) -> None:
    mission = load(
        tmp_path, '<Sequence><Measure distance_m="{=}"/><Drive speed_mps="{distance_m}"/></Sequence>'
    )
    mission.root.children[0]._set_output("distance_m", 2.5)
    assert Blackboard.get("/distance_m") == 2.5


def test_the_table_of_keys_can_be_read(tmp_path: Path) -> None:
    mission = load(tmp_path, '<Drive speed_mps="1" goal="{robot/pose_in_odom}"/>')
    Blackboard.set("/robot/pose_in_odom", Pose2D(1.0, 2.0, 3.0))
    assert find(mission, "Drive").get_input("goal") == Pose2D(1.0, 2.0, 3.0)


def test_keys_that_somebody_else_writes_can_be_told(tmp_path: Path) -> None:
    with pytest.raises(MissionError, match=r"reads \{v\} \(/v\), which nobody writes"):
        load(tmp_path, '<Drive speed_mps="{v}"/>')
    mission = load(tmp_path, '<Drive speed_mps="{v}"/>', provided=("/v",))
    Blackboard.set("/v", 0.25)
    assert find(mission, "Drive").get_input("speed_mps") == 0.25


def test_built_ins_take_literals_keys_and_defaults(tmp_path: Path) -> None:
    tree = """<Sequence>
        <Repeat num_cycles="2"><Look/></Repeat>
        <RetryUntilSuccessful num_attempts="{n}"><Look/></RetryUntilSuccessful>
        <Parallel failure_count="2"><Look/><Look/></Parallel>
    </Sequence>"""
    mission = load(tmp_path, tree, provided=("/n",))
    Blackboard.set("/n", 7)
    repeat, retry, parallel = mission.root.children
    assert isinstance(repeat, MissionNode)
    assert isinstance(retry, MissionNode)
    assert isinstance(parallel, MissionNode)
    assert (repeat.input("num_cycles"), retry.input("num_attempts")) == (2, 7)
    assert (parallel.input("success_count"), parallel.input("failure_count")) == (-1, 2)


def test_what_a_script_writes_has_the_type_of_the_ports(tmp_path: Path) -> None:
    tree = """<Sequence>
        <Script code="v := 1; n := 6 / 2; ok := n == 3; t := n"/>
        <Drive speed_mps="{v}" laps="{n}" careful="{ok}" label="{t}" goal="{robot/pose_in_odom}"/>
    </Sequence>"""
    mission = load(tmp_path, tree)
    Blackboard.set("/robot/pose_in_odom", Pose2D())
    mission.root.tick_once()
    seen = {"speed_mps": 1.0, "laps": 3, "careful": True, "label": "3", "goal": Pose2D()}
    assert find(mission, "Drive").seen == seen


def test_what_a_script_writes_must_fit_the_ports_when_it_runs(tmp_path: Path) -> None:
    tree = """<Sequence><Script name="set it" code="v := w"/><Drive speed_mps="{v}"/></Sequence>"""
    mission = load(tmp_path, tree, provided=("/w",))
    for value in ("fast", float("nan")):
        Blackboard.set("/w", value)
        with pytest.raises(
            MissionError, match=r'set it: code is "v := w"; v := .*: it must be a finite number'
        ):
            mission.root.tick_once()


def test_another_tree_of_the_file_can_be_loaded(tmp_path: Path) -> None:
    path = tmp_path / "mission.xml"
    path.write_text(
        document("<Look/>", '<BehaviorTree ID="T"><Look name="other"/></BehaviorTree>'), encoding="utf-8"
    )
    mission = load_mission(path, registry(), main_tree="T")
    assert (mission.main_tree, mission.root.name) == ("T", "other")
    with pytest.raises(MissionError, match='there is no tree "U"; the trees are: Main, T'):
        load_mission(path, registry(), main_tree="U")


# -- subtrees ------------------------------------------------------------------------------------------------

APPROACH = (
    '<BehaviorTree ID="Approach"><Drive speed_mps="{speed}" label="{text}" reason="{why}"/></BehaviorTree>'
)


def test_a_subtree_is_a_decorator_with_the_trees_root_as_child(tmp_path: Path) -> None:
    mission = load(tmp_path, '<SubTree ID="Approach" name="go there" speed="1" text="x"/>', APPROACH)
    assert isinstance(mission.root, SubTree)
    assert (mission.root.name, mission.root.tree_id) == ("go there", "Approach")
    assert isinstance(mission.root, py_trees.decorators.Decorator)


def test_what_a_subtree_is_given(tmp_path: Path) -> None:
    """A constant, a key, `{=}`; and two uses of one tree do not meet."""
    tree = """<Sequence>
        <Measure distance_m="{v}"/>
        <SubTree ID="Approach" speed="0.5" text="first" why="{because}"/>
        <SubTree ID="Approach" speed="{v}" text="second"/>
    </Sequence>"""
    mission = load(tmp_path, tree, APPROACH)
    Blackboard.set("/v", 4.0)
    first, second = (node for node in mission.root.iterate() if node.name == "Drive")
    assert [(leaf.get_input("speed_mps"), leaf.get_input("label")) for leaf in (first, second)] == [
        (0.5, "first"),
        (4.0, "second"),
    ]
    first._set_output("reason", "one")
    second._set_output("reason", "two")
    assert (Blackboard.get("/because"), Blackboard.get("/Approach_2/why")) == ("one", "two")


def test_same_name_and_root_blackboard_and_autoremap_and_private(tmp_path: Path) -> None:
    inner = """<BehaviorTree ID="T"><Sequence>
        <Measure name="same" distance_m="{a}"/>
        <Measure name="root" distance_m="{@b}"/>
        <Measure name="auto" distance_m="{c}"/>
        <Measure name="private" distance_m="{_d}"/>
    </Sequence></BehaviorTree>"""
    for attributes, expected in (
        ('a="{=}"', ["/a", "/b", "/T/c", "/T/_d"]),
        ('_autoremap="true"', ["/a", "/b", "/c", "/T/_d"]),
        ('a="{other}" _autoremap="1"', ["/other", "/b", "/c", "/T/_d"]),
        ('_autoremap="false"', ["/T/a", "/b", "/T/c", "/T/_d"]),
    ):
        Blackboard.clear()
        mission = load(tmp_path, f'<SubTree ID="T" {attributes}/>', inner)
        for name in ("same", "root", "auto", "private"):
            find(mission, name)._set_output("distance_m", 1.0)
        assert sorted(Blackboard.storage) == sorted(expected), attributes


def test_a_constant_goes_through_several_subtrees(tmp_path: Path) -> None:
    middle = '<BehaviorTree ID="Middle"><SubTree ID="Approach" speed="{v}" text="x"/></BehaviorTree>'
    mission = load(tmp_path, '<SubTree ID="Middle" v="0.75"/>', middle, APPROACH)
    assert find(mission, "Drive").get_input("speed_mps") == 0.75


def test_a_constant_that_is_written_in_the_subtree_is_where_it_begins(tmp_path: Path) -> None:
    nodes = '<Sequence><Drive speed_mps="{d}"/><Measure distance_m="{d}"/></Sequence>'
    inner = f'<BehaviorTree ID="T">{nodes}</BehaviorTree>'
    mission = load(tmp_path, '<SubTree ID="T" d="0.5"/>', inner)
    assert find(mission, "Drive").get_input("speed_mps") == 0.5
    find(mission, "Measure")._set_output("distance_m", 1.25)
    assert find(mission, "Drive").get_input("speed_mps") == 1.25


def test_constants_for_built_ins(tmp_path: Path) -> None:
    inner = '<BehaviorTree ID="T"><Repeat num_cycles="{n}"><Look/></Repeat></BehaviorTree>'
    repeat = find(load(tmp_path, '<SubTree ID="T" n="4"/>', inner), "Repeat")
    assert repeat.input("num_cycles") == 4


def test_defaults_of_the_node_model_stand_in_for_what_a_subtree_is_not_given(tmp_path: Path) -> None:
    path = tmp_path / "mission.xml"
    model = """<TreeNodesModel><SubTree ID="Approach">
        <input_port name="speed" default="0.3"/><input_port name="text" default="{=}"/>
    </SubTree></TreeNodesModel></root>"""
    text = document('<SubTree ID="Approach"/>', APPROACH).replace("</root>", model)
    path.write_text(text, encoding="utf-8")
    mission = load_mission(path, registry(), provided_keys=["/text"])
    Blackboard.set("/text", "outside")
    assert (find(mission, "Drive").get_input("speed_mps"), find(mission, "Drive").get_input("label")) == (
        0.3,
        "outside",
    )


def test_a_key_read_as_two_types_from_one_constant(tmp_path: Path) -> None:
    reader = leaf_class(
        "Reader", {"count": PortInformation(int, True, "n"), "text": PortInformation(str, True, "t")}
    )
    inner = '<BehaviorTree ID="T"><Reader count="{n}" text="{n}"/></BehaviorTree>'
    leaf = find(load(tmp_path, '<SubTree ID="T" n="4"/>', inner, extra=NodeRegistry((reader,))), "Reader")
    leaf.tick_once()
    assert (leaf.status, leaf.seen) == (Status.SUCCESS, {"count": 4, "text": "4"})


# -- bounds --------------------------------------------------------------------------------------------------


def test_subtrees_that_multiply_are_stopped(tmp_path: Path) -> None:
    doubling = [
        f'<BehaviorTree ID="T{n}"><Sequence><SubTree ID="T{n + 1}"/><SubTree ID="T{n + 1}"/></Sequence></BehaviorTree>'
        for n in range(40)
    ]
    last = '<BehaviorTree ID="T40"><Look/></BehaviorTree>'
    with pytest.raises(MissionError, match=f'tree "Main" has more than {MAX_NODES} nodes'):
        load(tmp_path, '<SubTree ID="T0"/>', *doubling, last)


def test_subtrees_that_nest_too_deep_are_stopped_and_as_deep_as_allowed_can_be_ticked(tmp_path: Path) -> None:
    def chain(length: int) -> list[str]:
        links = [f'<BehaviorTree ID="T{n}"><SubTree ID="T{n + 1}"/></BehaviorTree>' for n in range(length)]
        return [*links, f'<BehaviorTree ID="T{length}"><Look/></BehaviorTree>']

    root = load(tmp_path, '<SubTree ID="T0"/>', *chain(MAX_DEPTH - 2)).root
    root.tick_once()
    assert root.status is Status.SUCCESS
    assert root.tip() is not None
    with pytest.raises(MissionError, match=f'tree "Main" is more than {MAX_DEPTH} nodes deep'):
        load(tmp_path, '<SubTree ID="T0"/>', *chain(MAX_DEPTH))


def test_a_thousand_trees_in_a_chain_are_looked_through(tmp_path: Path) -> None:
    chain = [f'<BehaviorTree ID="T{n}"><SubTree ID="T{(n + 1) % 1000}"/></BehaviorTree>' for n in range(1000)]
    with pytest.raises(MissionError, match="a tree cannot contain itself: T0 > T1 > T2"):
        load(tmp_path, "<Look/>", *chain)


def test_nothing_is_built_of_a_mission_with_errors(tmp_path: Path) -> None:
    with pytest.raises(MissionError):
        load(tmp_path, '<Sequence><Drive speed_mps="1"/><Nonsense/></Sequence>')
    assert not Blackboard.storage
    assert not Blackboard.clients


def test_a_sequence_made_by_hand_and_one_from_a_file_are_the_same_class(tmp_path: Path) -> None:
    assert type(load(tmp_path, "<Sequence><Look/></Sequence>").root) is Sequence

"""Behaviours by import path: any py_trees behaviour as a leaf, its arguments as attributes."""

from __future__ import annotations

import sys
from enum import Enum
from pathlib import Path

import py_trees
import pytest
from py_trees.blackboard import Blackboard
from py_trees.common import Status
from py_trees.ports import PortInformation, PortsMixin

from target_nav.errors import MissionError
from target_nav.mission import LoadedMission, NodeRegistry, load_mission
from target_nav.mission.import_path import ConstructedLeaf, ImportPathError, import_leaf, is_import_path
from tests.unit.mission.scripted import document


class Colour(Enum):
    RED = 1
    GREEN = 2


class Painter(py_trees.behaviour.Behaviour):
    """Takes something of each kind."""

    def __init__(
        self,
        name: str,
        colour: Colour,
        coats: int = 1,
        litres: float | None = None,
        rooms: list[str] | None = None,
        careful=False,
        label=None,
        *extra: int,
        **options: int,
    ) -> None:
        super().__init__(name)
        self.given = (colour, coats, litres, rooms, careful, label)

    def update(self) -> Status:
        return Status.SUCCESS


class Fussy(py_trees.behaviour.Behaviour):
    def __init__(self, name: str, count: int) -> None:
        super().__init__(name)
        if count > 3:
            raise ValueError("at most 3")

    def update(self) -> Status:
        return Status.SUCCESS


class Porter(PortsMixin, py_trees.behaviour.Behaviour, register=False):
    """Has ports, so it is wired as a leaf of `behaviours` is."""

    INPUT_PORTS = {"load_kg": PortInformation(float, True, "what it carries")}
    OUTPUT_PORTS = {"done": PortInformation(bool, False, "whether it is there")}

    def update(self) -> Status:
        self._set_output("done", self.get_input("load_kg") < 10.0)
        return Status.SUCCESS


HERE = __name__


def load(folder: Path, *trees: str, provided: tuple[str, ...] = ()) -> LoadedMission:
    path = folder / "mission.xml"
    path.write_text(document(*trees), encoding="utf-8")
    return load_mission(path, NodeRegistry(), provided)


@pytest.mark.parametrize(
    ("name", "is_path"),
    [
        ("a.b:C", True),
        ("a:C", True),
        ("a.b.C", True),
        ("a.b:C.D", True),
        ("Sequence", False),
        ("a..C", False),
        ("a:", False),
        (".a:C", False),
        ("a b:C", False),
        ("a-b:C", False),
        ("a:b:C", False),
    ],
)
def test_what_an_import_path_is(name: str, is_path: bool) -> None:
    assert is_import_path(name) is is_path


def test_a_behaviour_of_py_trees(tmp_path: Path) -> None:
    tree = '<Action ID="py_trees.behaviours:TickCounter" duration="2" completion_status="FAILURE"/>'
    root = load(tmp_path, tree).root
    assert type(root) is py_trees.behaviours.TickCounter
    assert root.name == "TickCounter"
    statuses = []
    for _ in range(3):
        root.tick_once()
        statuses.append(root.status)
    assert statuses == [Status.RUNNING, Status.RUNNING, Status.FAILURE]


def test_compact_forms_and_names(tmp_path: Path) -> None:
    tree = '<Sequence><py_trees.behaviours.Success/><py_trees.behaviours:Failure name="no"/></Sequence>'
    root = load(tmp_path, tree).root
    assert [(type(each), each.name) for each in root.children] == [
        (py_trees.behaviours.Success, "Success"),
        (py_trees.behaviours.Failure, "no"),
    ]
    root.tick_once()
    assert root.status is Status.FAILURE


def test_arguments_of_every_kind(tmp_path: Path) -> None:
    plain = f'<Action ID="{HERE}:Painter" colour="RED"/>'
    full = (
        f'<Action ID="{HERE}:Painter" colour="GREEN" coats="2" litres="0.5" rooms="hall;bath room" careful="true" '
        'label="x"/>'
    )
    root = load(tmp_path, f"<Sequence>{plain}{full}</Sequence>").root
    assert [each.given for each in root.children if isinstance(each, Painter)] == [
        (Colour.RED, 1, None, None, False, None),
        (Colour.GREEN, 2, 0.5, ["hall", "bath room"], True, "x"),
    ]


def test_a_subtree_can_give_an_argument(tmp_path: Path) -> None:
    inner = f'<BehaviorTree ID="T"><Action ID="{HERE}:Painter" colour="{{c}}"/></BehaviorTree>'
    root = load(tmp_path, '<SubTree ID="T" c="GREEN"/>', inner).root
    (painter,) = root.children
    assert isinstance(painter, Painter)
    assert painter.given[0] is Colour.GREEN


def test_conditions_and_halts_work_on_it(tmp_path: Path) -> None:
    tree = '<Fallback><Action ID="py_trees.behaviours:Running" _while="x == 0"/><AlwaysSuccess/></Fallback>'
    root = load(tmp_path, tree, provided=("/x",)).root
    for value, status in ((0, Status.RUNNING), (1, Status.SUCCESS)):
        Blackboard.set("/x", value)
        root.tick_once()
        assert root.status is status
    assert root.children[0].status is Status.INVALID


def test_a_class_with_ports_is_wired(tmp_path: Path) -> None:
    tree = f'<Sequence><Action ID="{HERE}:Porter" load_kg="5" done="{{d}}"/><ScriptCondition code="d"/></Sequence>'
    root = load(tmp_path, tree).root
    root.tick_once()
    assert root.status is Status.SUCCESS
    with pytest.raises(MissionError, match='Porter: load_kg is "heavy"; it must be a finite number'):
        load(tmp_path, f'<Action ID="{HERE}:Porter" load_kg="heavy"/>')


def test_a_constructor_that_fails_is_an_error_of_the_mission(tmp_path: Path) -> None:
    with pytest.raises(
        MissionError, match=r"mission.xml:1:\d+: error: .*:Fussy cannot be made: ValueError: at most 3"
    ):
        load(tmp_path, f'<Action ID="{HERE}:Fussy" count="4"/>')


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("raise RuntimeError('not today')", r"cannot be imported \(RuntimeError: not today\)"),
        ("raise SystemExit(3)", r"cannot be imported \(SystemExit: 3\)"),
        ("def f(:", r"cannot be imported \(SyntaxError"),
        ("x = 1", "has no Leaf"),
        ("Leaf = 1", "is not a py_trees behaviour"),
        ("Leaf = list[int]", "is not a py_trees behaviour"),
        ("def __getattr__(name): raise KeyError(name)", "has no Leaf"),
    ],
)
def test_modules_that_are_no_good(
    source: str, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "bad_module.py").write_text(source, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "bad_module", raising=False)
    with pytest.raises(MissionError, match=f"bad_module:Leaf: .*{message}"):
        load(tmp_path, '<Action ID="bad_module:Leaf"/>')


def test_paths_into_things_that_have_no_parts(tmp_path: Path) -> None:
    with pytest.raises(MissionError, match=r"os:sep.Leaf: os has no sep.Leaf"):
        load(tmp_path, '<Action ID="os:sep.Leaf"/>')


def test_what_a_constructor_takes() -> None:
    leaf = import_leaf(f"{HERE}:Painter")
    assert isinstance(leaf, ConstructedLeaf)
    assert {name: (port.required, port.default_value) for name, port in leaf.arguments.items()} == {
        "colour": (True, None),
        "coats": (False, 1),
        "litres": (False, None),
        "rooms": (False, None),
        "careful": (False, False),
        "label": (False, None),
    }
    with pytest.raises(ImportPathError, match="only leaves can be imported"):
        import_leaf("py_trees.decorators:Inverter")


def test_a_registered_word_comes_first() -> None:
    registry = NodeRegistry()
    assert registry.find("py_trees.behaviours:Success") is None, "only what is registered"
    spec = registry.resolve("py_trees.behaviours:Success")
    assert spec is not None
    assert registry.resolve("py_trees.behaviours:Success") is spec, "imported once"
    assert "py_trees.behaviours:Success" not in registry.names()

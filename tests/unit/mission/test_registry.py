from __future__ import annotations

import py_trees
import pytest
from py_trees.common import Status
from py_trees.ports import PortInformation

from target_nav.errors import MissionError
from target_nav.mission import NodeRegistry, default_registry
from target_nav.mission.btcpp import NOT_HERE
from target_nav.mission.registry import NodeKind
from tests.unit.mission.scripted import leaf_class
from tests.unit.mission.vocabulary import Drive, Look

PORT = PortInformation(float, False, "a number")


class Plain(py_trees.behaviour.Behaviour):
    """A behaviour without ports."""

    def update(self) -> Status:
        return Status.SUCCESS


def test_built_ins_and_leaves_are_words() -> None:
    registry = NodeRegistry((Drive,))
    sequence, timeout, drive = (registry.find(name) for name in ("Sequence", "Timeout", "Drive"))
    assert sequence is not None
    assert timeout is not None
    assert drive is not None
    assert (sequence.kind, sequence.children, sequence.built_in) == (NodeKind.CONTROL, (1, None), True)
    assert (timeout.kind, timeout.children, timeout.ports) == (NodeKind.DECORATOR, (1, 1), ("msec",))
    assert (drive.kind, drive.children, drive.built_in) == (NodeKind.LEAF, (0, 0), False)
    assert drive.limits["speed_mps"] == (0.02, 5.0)
    assert drive.doc == "Test leaf Drive."
    assert registry.find("Look") is None


def test_no_word_is_said_not_to_be_one() -> None:
    assert not set(NodeRegistry().names()) & set(NOT_HERE)


def test_a_leaf_can_have_another_name_and_be_registered_twice() -> None:
    registry = NodeRegistry()
    assert registry.register(Look, "LookAround") is registry.find("LookAround")
    registry.register(Look, "LookAround")


@pytest.mark.parametrize(
    ("leaf", "message"),
    [
        (Plain, "must be a py_trees behaviour with PortsMixin"),
        (
            leaf_class("Sequence"),
            "'Sequence' .* the name is taken by target_nav.mission.nodes.in_order.Sequence",
        ),
        (leaf_class("A", {"name": PORT}), "a port cannot be called 'name'"),
        (leaf_class("A", {"_speed": PORT}), "a port cannot be called '_speed'"),
        (leaf_class("A", outputs={"a b": PORT}), "a port cannot be called 'a b'"),
        (
            leaf_class("A", {"speed": PORT}, limits={"sped": (0, 1)}),
            "PORT_LIMITS names 'sped', which is no port",
        ),
    ],
)
def test_what_cannot_be_a_leaf(leaf: type[py_trees.behaviour.Behaviour], message: str) -> None:
    with pytest.raises(MissionError, match=message):
        NodeRegistry((leaf,))


def test_names_of_constants() -> None:
    registry = NodeRegistry(enums={"RED": 1})
    registry.register_enum("RED", 1)
    registry.register_enum("GREEN", 2)
    assert dict(registry.enums) == {"RED": 1, "GREEN": 2}
    for name, value, message in (
        ("RED", 3, "is 1 already, and cannot be 3"),
        ("a b", 1, "a script cannot have such a name"),
        ("falsehood", 1, "a script cannot have such a name"),
    ):
        with pytest.raises(MissionError, match=message):
            registry.register_enum(name, value)


def test_the_default_registry_has_the_leaves_of_behaviours_and_is_made_once() -> None:
    import behaviours

    registry = default_registry()
    assert registry is default_registry()
    assert {leaf.__name__ for leaf in behaviours.LEAVES} <= set(registry.names())

"""Which blackboard entry a key means. `main` is the main tree's scope."""

from __future__ import annotations

import pytest

from target_nav.mission.problems import Position
from target_nav.mission.scope import Constant, Reference, Scope

CONSTANT = Constant("0.1", Position("m.xml"))


def path(scope: Scope, key: str) -> str:
    return scope.resolve(key)[0].path


def test_each_subtree_has_keys_of_its_own() -> None:
    main = Scope()
    inner = main.child("Approach", {}, autoremap=False)
    assert [path(main, "x"), path(inner, "x")] == ["/x", "/Approach/x"]
    assert path(inner.child("Align", {}, autoremap=False), "x") == "/Approach/Align/x"


def test_remapping_goes_outwards_step_by_step() -> None:
    main = Scope()
    inner = main.child("a", {"x": Reference("y")}, autoremap=False)
    innermost = inner.child("b", {"z": Reference("x")}, autoremap=False)
    assert path(innermost, "z") == "/y"
    assert path(innermost, "x") == "/a/b/x"


def test_autoremap_takes_the_same_name_outside_except_private_ones() -> None:
    inner = Scope().child("a", {"x": Reference("y")}, autoremap=True)
    assert [path(inner, key) for key in ("x", "other", "_mine")] == ["/y", "/other", "/a/_mine"]
    assert path(inner.child("b", {}, autoremap=True), "x") == "/y"


def test_the_root_blackboard_from_anywhere() -> None:
    inner = (
        Scope()
        .child("a", {"x": Reference("@goal")}, autoremap=False)
        .child("b", {"x": Reference("x")}, False)
    )
    assert [path(inner, "@goal"), path(inner, "x")] == ["/goal", "/goal"]


def test_a_constant_belongs_to_the_subtree_it_was_given_to() -> None:
    inner = Scope().child("a", {"x": CONSTANT}, autoremap=True)
    entry, owner = inner.child("b", {"y": Reference("x")}, autoremap=False).resolve("y")
    assert (entry.path, entry.initial, owner) == ("/a/x", CONSTANT, inner)


def test_scopes_remember_which_keys_were_used() -> None:
    main = Scope()
    inner = main.child("a", {"x": Reference("y")}, autoremap=False)
    inner.resolve("x")
    assert (inner.used, main.used) == ({"x"}, {"y"})


@pytest.mark.parametrize(
    ("labels", "paths"),
    [
        (["a", "a", "a"], ["/a", "/a_2", "/a_3"]),
        (["a_2", "a", "a"], ["/a_2", "/a", "/a_3"]),
        (["a", "a", "a_2"], ["/a", "/a_2", "/a_2_2"]),
        (["go to it!", "go to it?"], ["/go_to_it", "/go_to_it_2"]),
        (["/", "..", "ß"], ["/subtree", "/subtree_2", "/subtree_3"]),
    ],
)
def test_no_two_subtrees_share_a_folder(labels: list[str], paths: list[str]) -> None:
    main = Scope()
    assert [main.child(label, {}, autoremap=False).path for label in labels] == paths

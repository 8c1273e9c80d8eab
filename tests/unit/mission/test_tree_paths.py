from __future__ import annotations

from target_nav.mission.tree_paths import paths_of, unique_paths
from tests.unit.mission.conftest import MakeTrace


def test_paths_are_unique_and_the_same_in_every_load(trace: MakeTrace) -> None:
    tree = "<Sequence><A/><A/><Sequence><A/></Sequence><Sequence><A/></Sequence></Sequence>"
    first, second = (paths_of(trace(tree, A="S").root) for _ in range(2))
    assert list(first.values()) == list(second.values())
    assert list(first.values()) == [
        "/Sequence",
        "/Sequence/A",
        "/Sequence/A#2",
        "/Sequence/Sequence",
        "/Sequence/Sequence/A",
        "/Sequence/Sequence#2",
        "/Sequence/Sequence#2/A",
    ]


def test_a_name_that_looks_like_the_second_of_its_kind_is_told_apart() -> None:
    names = {"root": ["a", "a", "a#2"]}
    found = [path for _, path in unique_paths("root", str, lambda name: names.get(name, []))]
    assert found == ["/root", "/root/a", "/root/a#2", "/root/a#2#2"]

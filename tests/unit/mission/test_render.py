from __future__ import annotations

import pytest

from target_nav.mission.render import paths_of, render_text
from tests.unit.mission.conftest import MakeTrace

TREE = "<Fallback name='either'><A/><Sequence><B/><B/></Sequence><Inverter><C/></Inverter></Fallback>"


@pytest.fixture(autouse=True)
def no_colours(monkeypatch: pytest.MonkeyPatch) -> None:
    """py_trees decides on colours when it is imported, by whether standard output is a terminal."""
    from py_trees import display

    for symbols in (display.unicode_symbols, display.ascii_symbols):
        for key, symbol in list(symbols.items()):
            plain = symbol
            for code in ("\x1b[0m", "\x1b[1m", *(f"\x1b[{n}m" for n in (30, 31, 32, 33, 34, 35, 36, 37))):
                plain = plain.replace(code, "")
            monkeypatch.setitem(symbols, key, plain)


def test_a_tree_before_its_first_tick(trace: MakeTrace) -> None:
    assert render_text(trace(TREE, A="F", B="R", C="S").root, unicode=False).splitlines() == [
        "{o} either",
        "    --> A",
        "    {-} Sequence",
        "        --> B",
        "        --> B",
        "    -^- Inverter",
        "        --> C",
    ]


def test_statuses_and_messages_as_they_are(trace: MakeTrace) -> None:
    tree = trace(TREE, A="F", B="R", C="S")
    tree.tick()
    tree.root.children[0].feedback_message = "no"
    assert render_text(tree.root, unicode=False).splitlines() == [
        "{o} either [*]",
        "    --> A [x] -- no",
        "    {-} Sequence [*]",
        "        --> B [*]",
        "        --> B",
        "    -^- Inverter",
        "        --> C",
    ]


def test_statuses_of_a_recording(trace: MakeTrace) -> None:
    tree = trace(TREE, A="F", B="R", C="S")
    tree.tick()
    recorded = {"/either": "SUCCESS", "/either/Inverter": "SUCCESS", "/either/Sequence/B#2": "FAILURE"}
    assert render_text(tree.root, recorded, unicode=False).splitlines() == [
        "{o} either [o]",
        "    --> A",
        "    {-} Sequence",
        "        --> B",
        "        --> B [x]",
        "    -^- Inverter [o]",
        "        --> C",
    ]


def test_unicode_marks(trace: MakeTrace) -> None:
    tree = trace("<A/>", A="S")
    tree.tick()
    assert render_text(tree.root) == "--> A [✓]\n"


def test_every_kind_of_node_is_drawn_the_same_from_a_recording(trace: MakeTrace) -> None:
    root = trace(
        "<Parallel><ReactiveSequence><A/></ReactiveSequence><ReactiveFallback><A/></ReactiveFallback></Parallel>",
        A="S",
    ).root
    assert render_text(root, {}) == render_text(root)


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

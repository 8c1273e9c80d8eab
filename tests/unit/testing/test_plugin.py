"""The pytest plugin, in a pytest of its own."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.unit.mission.scenarios import write

pytest_plugins = ["pytester"]

PLUGIN = ("-p", "target_nav.testing.plugin", "-p", "no:cacheprovider")


def test_scenarios_are_collected_and_run(pytester: pytest.Pytester) -> None:
    write(
        pytester.path,
        """
        - {name: waits for GO, expect: [{at: 1, leaf: Idle}]}
        - {name: searches, script: [{at: 0, say: GO}], expect: [{at: 1, leaf: Idle}]}
        """,
    )
    result = pytester.runpytest(*PLUGIN, "scenarios")
    result.assert_outcomes(passed=1, failed=1)
    result.stdout.fnmatch_lines(
        [
            "*some.yaml:4: expected at 1 s: leaf is Idle",
            "*at 1.00 s leaf is TurnSearch, not Idle",
            "*what happened:",
            "*0.00 s  SEARCHING *TurnSearch*",
        ]
    )
    assert "Traceback" not in result.stdout.str()


def test_one_scenario_can_be_chosen(pytester: pytest.Pytester) -> None:
    write(
        pytester.path,
        "- {name: a, expect: [{at: 1, leaf: Idle}]}\n- {name: b, expect: [{at: 1, leaf: Idle}]}",
    )
    result = pytester.runpytest(*PLUGIN, "scenarios/some.yaml::b")
    result.assert_outcomes(passed=1)


def test_what_is_wrong_with_a_file_is_told_without_a_traceback(pytester: pytest.Pytester) -> None:
    write(pytester.path, "- {name: a, expect: [{at: 1, laef: Idle}]}")
    result = pytester.runpytest(*PLUGIN, "scenarios")
    result.assert_outcomes(errors=1)
    result.stdout.fnmatch_lines(
        ["*some.yaml:3: error: an expectation has no key 'laef'; did you mean 'leaf'?"]
    )
    assert "Traceback" not in result.stdout.str()


def test_what_does_not_fit_the_mission_is_told_without_a_traceback(pytester: pytest.Pytester) -> None:
    write(pytester.path, "- {name: a, expect: [{at: 1, leaf: Idel}]}")
    result = pytester.runpytest(*PLUGIN, "scenarios")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*some.yaml:3: error: a: no behaviour of the mission is 'Idel'*"])


def test_other_projects_folders_are_left_alone(pytester: pytest.Pytester) -> None:
    folder = pytester.path / "scenarios"
    folder.mkdir()
    (folder / "load.yaml").write_text("users: 10\n", encoding="utf-8")
    outside = write(pytester.path, "- {name: a, expect: [{at: 1, leaf: Idle}]}")
    outside.rename(pytester.path / "elsewhere.yaml")
    assert pytester.runpytest(*PLUGIN).ret == pytest.ExitCode.NO_TESTS_COLLECTED


def test_the_fixture_ticks_a_mission_and_closes_it(pytester: pytest.Pytester) -> None:
    write(pytester.path, "- {name: a, expect: [{at: 1, leaf: Idle}]}").unlink()
    pytester.makepyfile(
        """
        from py_trees.blackboard import Blackboard

        def test_it_goes_to_what_it_sees(scripted_mission):
            mission = scripted_mission("mission.xml")
            mission.say("GO")
            mission.set(track={"range_m": 2.0})
            mission.run_for(0.5)
            assert mission.leaf == "NavigateToTarget"

        def test_afterwards_the_board_is_empty():
            assert not Blackboard.storage

        def test_one_after_the_other(scripted_mission):
            scripted_mission("mission.xml").tick()
            second = scripted_mission("mission.xml", drives=False)
            assert second.tick().leaf_name == "Idle"
        """
    )
    pytester.runpytest(*PLUGIN).assert_outcomes(passed=3)


def test_it_is_light_until_it_is_used(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(
        """
        import sys

        def test_nothing_of_a_mission_is_imported():
            assert "py_trees" not in sys.modules
            assert "numpy" not in sys.modules
        """
    )
    pytester.runpytest_subprocess(*PLUGIN).assert_outcomes(passed=1)


def test_the_plugin_is_named_as_its_module_so_that_it_is_not_loaded_twice() -> None:
    setup = Path(__file__).parents[3] / "setup.py"
    assert '"target_nav.testing.plugin = target_nav.testing.plugin"' in setup.read_text(encoding="utf-8")

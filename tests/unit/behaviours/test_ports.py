"""What a mission's author writes reaches the skill; what is left out is the configuration's."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from behaviours.motion import MotionLeaf
from target_nav.config import Config
from target_nav.mission import load_mission
from target_nav.nav.arrival import ConfirmArrival
from target_nav.nav.blind_approach import BlindApproach
from target_nav.nav.go_to_point import GoToPoint
from target_nav.nav.look_round import LookRound
from target_nav.nav.navigate import NavigateToTarget
from target_nav.nav.spiral_search import SpiralSearch
from target_nav.nav.turn_search import TurnSearch
from target_nav.state import keys
from target_nav.state.types import TargetSpec
from tests.unit.mission.scripted import document
from tests.utils.board import ScriptedBoard

SKILLS = (TurnSearch, LookRound, SpiralSearch, NavigateToTarget, BlindApproach, ConfirmArrival, GoToPoint)


def arguments_of(
    skill: type, attributes: dict[str, Any], folder: Path, monkeypatch: pytest.MonkeyPatch
) -> dict[str, Any]:
    """What the leaf of the skill's name gives to the skill, in a mission with these attributes."""
    said = "".join(f' {name}="{value}"' for name, value in attributes.items())
    path = folder / "mission.xml"
    path.write_text(
        document(f"""<Timeout msec="1000"><{skill.__name__}{said}/></Timeout>"""), encoding="utf-8"
    )
    (leaf,) = [node for node in load_mission(path).root.iterate() if isinstance(node, MotionLeaf)]
    given: dict[str, Any] = {}
    monkeypatch.setattr(skill, "__init__", lambda self, config, **kinds: given.update(kinds))
    leaf.make_skill()
    return given


@pytest.fixture
def _configured(board: ScriptedBoard) -> None:
    board.write(keys.CONFIG, Config())
    board.write(keys.SPEC, TargetSpec("pin", 0.28, 0.08))


def leaf_of(skill: type) -> type[MotionLeaf]:
    import behaviours

    leaf: type[MotionLeaf] = getattr(behaviours, skill.__name__)
    return leaf


@pytest.mark.usefixtures("_configured")
@pytest.mark.parametrize("skill", SKILLS)
def test_every_port_reaches_the_skill(skill: type, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    leaf = leaf_of(skill)
    # different numbers, each inside its limits
    attributes = {
        port: round(leaf.PORT_LIMITS[port][0] + 0.11 + 0.01 * number, 3)
        for number, port in enumerate(leaf.PORT_LIMITS)
    }
    given = arguments_of(skill, attributes, tmp_path, monkeypatch)
    assert set(attributes.values()) <= set(given.values()), given


@pytest.mark.usefixtures("_configured")
@pytest.mark.parametrize("skill", SKILLS)
def test_what_is_left_out_has_a_value_all_the_same(
    skill: type, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    required = {port: 1.5 for port, information in leaf_of(skill).INPUT_PORTS.items() if information.required}
    given = arguments_of(skill, required, tmp_path, monkeypatch)
    assert all(isinstance(value, float) for port, value in given.items() if port != "from_face"), given
    assert given.get("from_face", False) is False


@pytest.mark.usefixtures("_configured")
@pytest.mark.parametrize(("said", "wanted"), [("face", True), ("anywhere", False)])
def test_where_to_come_from_reaches_the_skill(
    said: str, wanted: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    given = arguments_of(NavigateToTarget, {"from": said}, tmp_path, monkeypatch)
    assert given["from_face"] is wanted


@pytest.mark.parametrize(("label", "radius_m"), [("pin", 0.04), ("apriltag:7", 0.0)])
def test_the_surface_of_a_flat_target_is_where_its_middle_is(
    label: str, radius_m: float, board: ScriptedBoard, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    board.write(keys.CONFIG, Config())
    board.write(keys.SPEC, TargetSpec(label, 0.28, 0.08))
    for skill in (BlindApproach, ConfirmArrival):
        given = arguments_of(skill, {}, tmp_path, monkeypatch)
        assert given["target_radius_m"] == radius_m
        assert given.get("target_width_m", 0.08) == 0.08

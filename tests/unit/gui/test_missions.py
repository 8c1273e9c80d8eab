"""What an operator can choose from: the missions that are shipped, and the targets they name."""

from __future__ import annotations

from pathlib import Path

from target_nav.gui.missions import MissionChoice, mission_folder, missions, targets
from target_nav.state.types import TargetSpec


def test_the_shipped_missions_are_found() -> None:
    names = {choice.name for choice in missions()}
    assert {"bowling_pin", "patrol"} <= names
    assert all(Path(choice.path).is_file() for choice in missions())
    assert mission_folder().name == "trees"


def test_targets_are_those_that_missions_name_each_once() -> None:
    found = targets(missions())
    assert TargetSpec("bowling_pin", 0.28, 0.08, 0.032) in found
    assert len(found) == len(set(found))


def test_a_folder_that_is_not_there_and_files_that_are_no_xml_offer_nothing(tmp_path: Path) -> None:
    assert missions(tmp_path / "none") == ()
    (tmp_path / "broken.xml").write_text("<root>")
    (tmp_path / "remapped.xml").write_text('<root><SetTarget class="{c}" height_m="{h}" width_m="1"/></root>')
    (tmp_path / "explicit.xml").write_text(
        '<root><Action ID="SetTarget" class="cone" height_m="0.3" width_m="0.2"/></root>'
    )
    assert targets(missions(tmp_path)) == (TargetSpec("cone", 0.3, 0.2),)
    assert targets([MissionChoice("gone", str(tmp_path / "gone.xml"))]) == ()

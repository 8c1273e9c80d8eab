"""Settings: made from the dataclasses, held to their limits, saved so that the processes read the same."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
import yaml

from target_nav.app.settings import load_config
from target_nav.config import Config
from target_nav.errors import ConfigError
from target_nav.gui.settings import CHOICE, NUMBER, SWITCH, TEXT, WHOLE, Settings, read_overrides

KEYS = [key for key, _, _ in Config().items()]


def test_every_parameter_of_the_configuration_is_there_once_with_unit_limits_and_help() -> None:
    shown = [s for section in Settings(Config(), None).sections() for s in section.settings]
    assert [s.key for s in shown] == KEYS
    for s in shown:
        assert s.help
        assert s.kind in (NUMBER, WHOLE, SWITCH, CHOICE, TEXT)
        if s.kind in (NUMBER, WHOLE):
            assert s.low is not None
            assert s.high is not None
            assert s.low <= s.value <= s.high


def test_a_change_is_saved_and_read_by_the_processes_as_the_same(tmp_path: Path) -> None:
    path = tmp_path / "deep" / "settings.yaml"
    settings = Settings(Config(), path)
    settings.change("approach.stand_off_m", 0.12)
    settings.change("robot.drive", "differential")
    settings.change("lidar.beams", 720)
    assert load_config(path) == settings.config
    assert load_config(path).approach.stand_off_m == 0.12


@pytest.mark.parametrize("value", [1e-5, 3.0, 0.1 + 0.2, 1e4])
def test_a_number_comes_back_from_the_file_to_the_last_bit(tmp_path: Path, value: float) -> None:
    path = tmp_path / "settings.yaml"
    key = "camera.focal_px" if value > 100 else "avoid.cost_target"
    Settings(Config(), path).change(key, value)
    assert read_overrides(path) == {key: value}


def test_back_to_the_default_leaves_the_file(tmp_path: Path) -> None:
    path = tmp_path / "settings.yaml"
    settings = Settings(Config(), path)
    settings.change("approach.stand_off_m", 0.12)
    change = settings.reset("approach.stand_off_m")
    assert change.value == Config().approach.stand_off_m
    assert yaml.safe_load(path.read_text()) == {}


def test_keys_that_others_put_into_the_file_stay(tmp_path: Path) -> None:
    path = tmp_path / "settings.yaml"
    path.write_text("search.time_limit_s: 20.0\n")
    settings = Settings(load_config(path), path)
    settings.change("approach.stand_off_m", 0.12)
    assert read_overrides(path) == {"search.time_limit_s": 20.0, "approach.stand_off_m": 0.12}


@pytest.mark.parametrize(
    ("key", "text", "value"),
    [
        ("approach.stand_off_m", " 0,12 ", 0.12),
        ("lidar.beams", "360", 360),
        ("robot.drive", "differential", "differential"),
        ("serial.port", "/dev/ttyACM1", "/dev/ttyACM1"),
    ],
)
def test_what_a_person_writes_becomes_a_value(key: str, text: str, value: object) -> None:
    assert Settings(Config(), None).parse(key, text) == value


@pytest.mark.parametrize(
    ("key", "text"),
    [
        ("approach.stand_off_m", "5"),
        ("approach.stand_off_m", "near"),
        ("approach.stand_off_m", "nan"),
        ("lidar.beams", "1.5"),
        ("robot.drive", "hover"),
    ],
)
def test_what_is_wrong_is_refused_with_its_limit_and_changes_nothing(
    tmp_path: Path, key: str, text: str
) -> None:
    settings = Settings(Config(), tmp_path / "settings.yaml")
    with pytest.raises(ConfigError, match=key):
        settings.change(key, settings.parse(key, text))
    assert settings.config == Config()
    assert not settings.path.exists()


def test_what_needs_a_restart_is_told_as_waiting(tmp_path: Path) -> None:
    settings = Settings(Config(), tmp_path / "settings.yaml")
    assert settings.change("approach.stand_off_m", 0.12).live
    assert not settings.change("camera.focal_px", 560.0).live
    assert settings.waiting_for_restart() == ("camera.focal_px",)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_refuses_is_told(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    with pytest.raises(ConfigError, match="cannot be written"):
        Settings(Config(), tmp_path / "settings.yaml").change("approach.stand_off_m", 0.12)


def test_a_file_that_is_no_mapping_is_told(tmp_path: Path) -> None:
    path = tmp_path / "settings.yaml"
    path.write_text("- 1\n")
    with pytest.raises(ConfigError, match="mapping"):
        Settings(Config(), path).change("approach.stand_off_m", 0.12)

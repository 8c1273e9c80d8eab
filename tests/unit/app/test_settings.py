"""The options every process has."""

from __future__ import annotations

import argparse
from pathlib import Path

import pytest

from target_nav.app.settings import (
    add_config_arguments,
    base_config_from,
    config_from,
    load_config,
    parse_arguments,
    update_config,
    write_config,
)
from target_nav.config import Config
from target_nav.errors import ConfigError


def parse(*argv: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    add_config_arguments(parser)
    return parse_arguments(parser, argv)


def test_without_options_it_is_the_reference_robot() -> None:
    assert config_from(parse()) == Config()


def test_later_options_win(tmp_path: Path) -> None:
    file = tmp_path / "robot.yaml"
    file.write_text("lidar.rate_hz: 8\nrobot.drive: differential\nipc.prefix: file\n")
    config = config_from(parse("--config", str(file), "--set", "lidar.rate_hz=9.5", "--prefix", "mine"))
    assert config.lidar.rate_hz == 9.5
    assert config.robot.drive == "differential"
    assert config.ipc.prefix == "mine"


def test_what_belongs_to_ros_is_left_to_ros() -> None:
    argv = ("--ros-args", "-p", "lidar.rate_hz:=9", "--", "--prefix", "mine", "--ros-args", "-r", "a:=b")
    assert parse(*argv).prefix == "mine"


def test_a_misspelt_option_is_an_error() -> None:
    with pytest.raises(SystemExit) as caught:
        parse("--prefx", "mine")
    assert caught.value.code == 2


@pytest.mark.parametrize(
    ("argv", "message"),
    [
        (("--set", "lidar.rate_hz"), "KEY=VALUE"),
        (("--set", "lidar.rate=5"), "did you mean"),
        (("--set", "lidar.rate_hz=-5"), "must lie in"),
        (("--set", "lidar.rate_hz=fast"), "finite number"),
        (("--config", "/nowhere/robot.yaml"), "cannot be read"),
    ],
)
def test_a_wrong_value_is_told(argv: tuple[str, ...], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        config_from(parse(*argv))


@pytest.mark.parametrize("text", ["[1, 2]", "just text", "1: 2", "a: [", "\x00"])
def test_a_file_that_is_no_configuration_is_told(tmp_path: Path, text: str) -> None:
    file = tmp_path / "robot.yaml"
    file.write_text(text)
    with pytest.raises(ConfigError, match=r"robot\.yaml"):
        load_config(file)


def test_a_configuration_survives_its_file(tmp_path: Path) -> None:
    config = Config().override({"lidar.rate_hz": 7.25, "robot.drive": "differential", "lidar.beams": 400})
    write_config(config, tmp_path / "c.yaml")
    assert load_config(tmp_path / "c.yaml") == config
    write_config(Config(), tmp_path / "same.yaml")
    assert load_config(tmp_path / "same.yaml") == Config()


def test_the_operators_saved_changes_lie_over_the_file_and_under_the_command_line(tmp_path: Path) -> None:
    base, saved = tmp_path / "config.yaml", tmp_path / "settings.yaml"
    base.write_text("lidar.rate_hz: 7.0\nlidar.beams: 720\nsearch.time_limit_s: 20.0\n")
    saved.write_text("lidar.rate_hz: 8.0\nsearch.time_limit_s: 25.0\n")
    parser = argparse.ArgumentParser()
    add_config_arguments(parser)
    given = ["--config", str(base), "--settings", str(saved), "--set", "search.time_limit_s=40"]
    config = config_from(parse_arguments(parser, given))
    assert (config.lidar.rate_hz, config.lidar.beams, config.search.time_limit_s) == (8.0, 720, 40.0)
    assert base_config_from(parse_arguments(parser, given)).lidar.rate_hz == 7.0


def test_a_file_of_saved_changes_need_not_exist(tmp_path: Path) -> None:
    parser = argparse.ArgumentParser()
    add_config_arguments(parser)
    given = ["--settings", str(tmp_path / "none.yaml")]
    assert config_from(parse_arguments(parser, given)) == Config()


def test_keys_are_set_in_a_file_and_the_rest_of_it_stays(tmp_path: Path) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text("# mine\nodometry.yaw_scale: 1.5\nlidar.rate_hz: 7.0\n")
    update_config(path, {"odometry.yaw_scale": 1.01, "odometry.forward_scale": 0.98}, "measured today")
    assert path.read_text() == (
        "# mine\nodometry.yaw_scale: 1.01  # measured today\nlidar.rate_hz: 7.0\n"
        "odometry.forward_scale: 0.98  # measured today\n"
    )
    assert load_config(path).odometry.yaw_scale == 1.01


def test_a_file_that_is_not_there_is_made(tmp_path: Path) -> None:
    update_config(tmp_path / "new.yaml", {"odometry.yaw_scale": 1.01}, "measured")
    assert load_config(tmp_path / "new.yaml").odometry.yaw_scale == 1.01


@pytest.mark.parametrize("text", ["[1, 2]\n", "odometry.yaw_skale: 1.0\n", "{odometry.yaw_scale: 1.0}\n"])
def test_a_file_that_cannot_be_kept_is_left_alone(tmp_path: Path, text: str) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text(text)
    with pytest.raises(ConfigError):
        update_config(path, {"odometry.yaw_scale": 1.01}, "measured")
    assert path.read_text() == text
    assert list(tmp_path.iterdir()) == [path]


def test_a_value_outside_its_limits_is_not_written(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="must lie in"):
        update_config(tmp_path / "new.yaml", {"odometry.yaw_scale": 7.0}, "measured")
    assert not (tmp_path / "new.yaml").exists()


def test_a_folder_that_is_not_there_is_told(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="cannot be written"):
        update_config(tmp_path / "none" / "robot.yaml", {"odometry.yaw_scale": 1.01}, "measured")

"""The options every process has: which configuration, which channels. Limits come from `config.py`."""

from __future__ import annotations

import argparse
import os
import re
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import yaml

from target_nav.config import Config
from target_nav.errors import ConfigError


def add_config_arguments(parser: argparse.ArgumentParser) -> None:
    """`--config FILE`, `--set KEY=VALUE` (again and again) and `--prefix NAME`."""
    parser.add_argument(
        "--config", metavar="FILE", type=Path, help="YAML file of dotted keys: lidar.rate_hz: 10.0"
    )
    parser.add_argument(
        "--settings",
        metavar="FILE",
        type=Path,
        help="YAML file of the operator's saved changes, over --config; it need not exist",
    )
    parser.add_argument(
        "--set",
        metavar="KEY=VALUE",
        action="append",
        default=[],
        help="one key, over the file; may be repeated",
    )
    parser.add_argument("--prefix", metavar="NAME", help="of the channels in /dev/shm (key ipc.prefix)")


def parse_arguments(parser: argparse.ArgumentParser, argv: Sequence[str] | None = None) -> argparse.Namespace:
    """`parser.parse_args` without what belongs to ROS (`--ros-args ... [--]`, which `ros2 run` and launch add)."""
    own: list[str] = []
    for_ros = False
    for argument in sys.argv[1:] if argv is None else argv:
        if argument == "--ros-args":
            for_ros = True
        elif for_ros and argument == "--":
            for_ros = False
        elif not for_ros:
            own.append(argument)
    return parser.parse_args(own)


def config_from(arguments: argparse.Namespace, base: Config | None = None) -> Config:
    """`base` (the reference robot) with the options applied: `--config`, `--settings`, `--set`, then `--prefix`.

    Raises:
        ConfigError: a file that cannot be read, an unknown key, a value outside its limits.
    """
    return _applied(arguments, base or Config(), settings_file_from(arguments))


def base_config_from(arguments: argparse.Namespace, base: Config | None = None) -> Config:
    """The same without the operator's saved changes: what they are changes of. Raises ConfigError."""
    return _applied(arguments, base or Config(), None)


def settings_file_from(arguments: argparse.Namespace) -> Path | None:
    path: Path | None = getattr(arguments, "settings", None)
    return path


def default_settings_file() -> Path:
    """Where a robot keeps what its operator has changed."""
    folder = os.environ.get("XDG_CONFIG_HOME") or str(Path.home() / ".config")
    return Path(folder) / "target_nav" / "settings.yaml"


def _applied(arguments: argparse.Namespace, config: Config, settings: Path | None) -> Config:
    if arguments.config is not None:
        config = load_config(arguments.config, config)
    if settings is not None and settings.exists():
        config = load_config(settings, config)
    for setting in arguments.set:
        key, equals, text = setting.partition("=")
        if not equals:
            raise ConfigError(f"--set {setting!r}: it must be KEY=VALUE, as in --set lidar.rate_hz=10.0")
        config = config.override({key.strip(): yaml.safe_load(text)}, source="--set")
    if arguments.prefix is not None:
        config = config.override({"ipc.prefix": arguments.prefix}, source="--prefix")
    return config


def load_config(path: Path, base: Config | None = None) -> Config:
    """`base` (the reference robot) with a YAML file of dotted keys applied.

    Raises:
        ConfigError: the file cannot be read, is not such a mapping, or has a wrong key or value.
    """
    try:
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError(f"configuration {path} cannot be read: {error.strerror}") from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise ConfigError(f"configuration {path} is not YAML: {error}") from error
    if data is None:
        data = {}
    if not isinstance(data, dict) or not all(isinstance(key, str) for key in data):
        raise ConfigError(
            f"configuration {path} must be a mapping of dotted keys, as in `lidar.rate_hz: 10.0`"
        )
    return (base or Config()).override(data, source=str(path))


def update_config(path: Path, values: Mapping[str, float], note: str) -> None:
    """Set dotted keys in a configuration file and leave the rest of it as it is; `note` becomes a comment.

    A file that is not there is made.

    Raises:
        ConfigError: the file cannot be read or written, or is none that `load_config` takes with these values.
    """
    try:
        old = path.read_text(encoding="utf-8") if path.exists() else ""
        Config().override(values, source="calibration")
        if old:
            load_config(path)
        fresh = path.with_name(f".{path.name}.{os.getpid()}")
        fresh.write_text(_with_keys(old, values, note), encoding="utf-8")
        try:
            # What could not be read again is not put in the place of what can.
            load_config(fresh)
            os.replace(fresh, path)
        finally:
            fresh.unlink(missing_ok=True)
    except OSError as error:
        raise ConfigError(f"configuration {path} cannot be written: {error.strerror}") from error


def _with_keys(text: str, values: Mapping[str, float], note: str) -> str:
    """`text` with these keys, each on the line where it was, or at the end."""
    lines = text.splitlines()
    for key, value in values.items():
        # Not repr: YAML 1.1 takes 5e-06 for text, and 5.0e-06 for a number.
        line = f"{key}: {yaml.safe_dump(value).splitlines()[0]}  # {note}"
        places = [i for i, old in enumerate(lines) if re.match(rf"{re.escape(key)}\s*:", old)]
        if places:
            lines[places[-1]] = line
        else:
            lines.append(line)
    return "\n".join(lines) + "\n"


def write_config(config: Config, path: Path) -> None:
    """The keys in which `config` differs from the reference robot, in the form `load_config` reads."""
    reference = {key: value for key, value, _ in Config().items()}
    changed = {key: value for key, value, _ in config.items() if value != reference[key]}
    path.write_text(yaml.safe_dump(changed, sort_keys=True), encoding="utf-8")

"""Every parameter of `config.py`, by section, as a screen needs it: made from the dataclasses, checked by their limits.

Changes go to a YAML file of overrides, the one that the stack's processes read when they start. Those that a running
nav process can take are marked `live` and are sent to it as well; the others count from the next start.
"""

from __future__ import annotations

import dataclasses
import os
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from target_nav.config import Config
from target_nav.errors import ConfigError
from target_nav.state.live_settings import is_live

NUMBER, WHOLE, SWITCH, CHOICE, TEXT = "number", "whole", "switch", "choice", "text"


@dataclass(frozen=True)
class Setting:
    """One parameter. `low` and `high` are inclusive, None where there is no number; `changed`: not the default."""

    key: str
    name: str
    kind: str
    value: Any
    default: Any
    unit: str
    low: float | None
    high: float | None
    options: tuple[str, ...]
    help: str
    live: bool
    changed: bool


@dataclass(frozen=True)
class Section:
    name: str
    help: str
    settings: tuple[Setting, ...]


@dataclass(frozen=True)
class Change:
    """A change that was taken: `live` ones are to be sent to the nav process."""

    key: str
    value: Any
    live: bool


class Settings:
    """The configuration as the operator sees and changes it.

    Args:
        config: what the processes were started with, the file's overrides included
        path: where changes are saved; None: nowhere
        base: what the overrides are on top of; the reference robot when None
    """

    def __init__(self, config: Config, path: Path | None, base: Config | None = None) -> None:
        self.config = config
        self.path = path
        self._started_with = config
        self._base = base or Config()

    def sections(self) -> tuple[Section, ...]:
        return tuple(self._section(spec.name) for spec in dataclasses.fields(self.config))

    def setting(self, key: str) -> Setting:
        section, _, name = key.partition(".")
        return next(s for s in self._section(section).settings if s.name == name)

    def waiting_for_restart(self) -> tuple[str, ...]:
        """Keys that were changed and count only from the next start."""
        then = {key: value for key, value, _ in self._started_with.items()}
        return tuple(k for k, v, _ in self.config.items() if v != then[k] and not is_live(k))

    def parse(self, key: str, text: str) -> Any:
        """What a person wrote, as a value of the key's type.

        Raises:
            ConfigError: not of its type, or outside its limits.
        """
        kind = self.setting(key).kind
        value: Any = text.strip()
        if kind in (NUMBER, WHOLE):
            try:
                value = float(value.replace(",", "."))
            except ValueError:
                raise ConfigError(f"{key} is {text!r}; it must be a number") from None
        elif kind == SWITCH:
            value = {"true": True, "on": True, "false": False, "off": False}.get(value.lower(), value)
        return self._value_in(self._overridden(key, value), key)

    def change(self, key: str, value: Any) -> Change:
        """Take a value and save it.

        Raises:
            ConfigError: a value outside its limits, or a file that cannot be written; nothing has changed then.
        """
        config = self._overridden(key, value)
        taken = self._value_in(config, key)
        self._save(key, taken)
        self.config = config
        return Change(key, taken, is_live(key))

    def reset(self, key: str) -> Change:
        """Back to the value without the operator's override."""
        return self.change(key, self._value_in(self._base, key))

    def _overridden(self, key: str, value: Any) -> Config:
        return self.config.override({key: value}, source="setting")

    def _save(self, key: str, value: Any) -> None:
        if self.path is None:
            return
        data = read_overrides(self.path)
        if value == self._value_in(self._base, key):
            data.pop(key, None)
        else:
            data[key] = value
        write_overrides(self.path, data)

    def _section(self, name: str) -> Section:
        group = getattr(self.config, name)
        defaults = {key: value for key, value, _ in self._base.items()}
        settings = []
        for spec in dataclasses.fields(group):
            key, value, meta = f"{name}.{spec.name}", getattr(group, spec.name), spec.metadata
            settings.append(
                Setting(
                    key=key,
                    name=spec.name,
                    kind=_kind(value, meta),
                    value=value,
                    default=defaults[key],
                    unit="" if meta.get("unit") == "1" else str(meta.get("unit", "")),
                    low=meta.get("low"),
                    high=meta.get("high"),
                    options=tuple(meta.get("options", ())),
                    help=str(meta.get("doc", "")),
                    live=is_live(key),
                    changed=value != defaults[key],
                )
            )
        own_words = (
            "" if (group.__doc__ or "").startswith(type(group).__name__ + "(") else group.__doc__ or ""
        )
        return Section(name, own_words, tuple(settings))

    @staticmethod
    def _value_in(config: Config, key: str) -> Any:
        section, _, name = key.partition(".")
        return getattr(getattr(config, section), name)


def read_overrides(path: Path) -> dict[str, Any]:
    """Dotted keys to values; nothing when there is no file.

    Raises:
        ConfigError: a file that cannot be read, or is no mapping.
    """
    try:
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return {}
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise ConfigError(f"settings {path} cannot be read: {error}") from error
    if data is None:
        return {}
    if not isinstance(data, dict):
        raise ConfigError(f"settings {path} must be a mapping of dotted keys, as in `lidar.rate_hz: 10.0`")
    return {str(key): value for key, value in data.items()}


def write_overrides(path: Path, data: Mapping[str, Any]) -> None:
    """Whole or not at all: a robot that is switched off meanwhile has the old file.

    Raises:
        ConfigError: the folder refuses.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile("w", dir=path.parent, prefix=f".{path.name}.", delete=False) as file:
            file.write(yaml.safe_dump(dict(data), sort_keys=True))
            file.flush()
            os.fsync(file.fileno())
        os.chmod(file.name, 0o644)
        os.replace(file.name, path)
    except OSError as error:
        raise ConfigError(
            f"settings {path} cannot be written: {error.strerror}; is the disk full or read-only?"
        ) from error


def _kind(value: Any, meta: Mapping[str, Any]) -> str:
    if isinstance(value, bool):
        return SWITCH
    if isinstance(value, str):
        return CHOICE if meta.get("options") else TEXT
    return WHOLE if isinstance(value, int) else NUMBER

"""What a recorded message means, in the words of its .msg file, so that a bag can be read where the package is not.

Every installed ROS package has its .msg files, and since Iron their hashes (REP-2016), under share/; the wheels from
PyPI and the interface packages of `deploy/` as well.
"""

from __future__ import annotations

import json
import os
import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from target_nav.errors import DeviceError

SEPARATOR = "=" * 80
"""Between the definition of a message and those of its parts, as rosbag2 and Foxglove want it."""

PRIMITIVES = frozenset(
    (
        "bool", "byte", "char", "float32", "float64", "int8", "uint8", "int16", "uint16", "int32", "uint32",
        "int64", "uint64", "string", "wstring",
    )
)  # fmt: skip

_FIELD = re.compile(r"^\s*([a-zA-Z][\w/]*)(?:<=\d+)?(?:\[[^\]]*\])?\s+\w+")


@dataclass(frozen=True)
class Definition:
    """`text` has the message and all its parts. `type_hash` is empty where the package does not tell it."""

    type_name: str
    text: str
    type_hash: str


class MessageDefinitions:
    """Finds definitions by name, as `sensor_msgs/msg/LaserScan`, and keeps them."""

    def __init__(self, folders: Sequence[Path]) -> None:
        self._folders = tuple(folders)
        self._known: dict[str, Definition] = {}

    def of(self, type_name: str) -> Definition:
        """The definition of a message.

        Raises:
            DeviceError: it, or a part of it, is not installed as a .msg file.
        """
        if type_name not in self._known:
            texts: dict[str, str] = {}
            self._collect(type_name, texts)
            first, *rest = texts.items()
            parts = [first[1]]
            for part, text in rest:
                package, _, name = part.split("/")
                parts.append(f"{SEPARATOR}\nMSG: {package}/{name}\n{text}")
            self._known[type_name] = Definition(type_name, "\n".join(parts), self._hash(type_name))
        return self._known[type_name]

    def _collect(self, type_name: str, texts: dict[str, str]) -> None:
        path = self._find(type_name, ".msg")
        if path is None:
            raise DeviceError(
                f"the definition of {type_name} is not installed ({_relative(type_name)}.msg in "
                f"{os.pathsep.join(map(str, self._folders))}); is its ROS package sourced?"
            )
        texts[type_name] = path.read_text(encoding="utf-8")
        for part in parts_of(texts[type_name], type_name.split("/")[0]):
            if part not in texts:
                self._collect(part, texts)

    def _hash(self, type_name: str) -> str:
        path = self._find(type_name, ".json")
        if path is None:
            return ""
        described = json.loads(path.read_text(encoding="utf-8"))
        hashes = {entry["type_name"]: entry["hash_string"] for entry in described["type_hashes"]}
        return str(hashes.get(type_name, ""))

    def _find(self, type_name: str, suffix: str) -> Path | None:
        for folder in self._folders:
            path = folder / (_relative(type_name) + suffix)
            if path.is_file():
                return path
        return None


def share_folders(environment: Mapping[str, str] | None = None) -> tuple[Path, ...]:
    """Where packages may be installed: the prefixes of a sourced ROS, and this environment."""
    listed = (os.environ if environment is None else environment).get("AMENT_PREFIX_PATH", "")
    prefixes = [*(prefix for prefix in listed.split(os.pathsep) if prefix), sys.prefix]
    return tuple(Path(prefix) / "share" for prefix in dict.fromkeys(prefixes))


def parts_of(text: str, package: str) -> list[str]:
    """The messages that the fields of a .msg file name, as `std_msgs/msg/Header`."""
    found: list[str] = []
    for line in text.splitlines():
        field = _FIELD.match(line.split("#", 1)[0])
        if field is None or field.group(1) in PRIMITIVES:
            continue
        names = field.group(1).split("/")
        owner = names[0] if len(names) > 1 else package
        found.append(f"{owner}/msg/{names[-1]}")
    return list(dict.fromkeys(found))


def _relative(type_name: str) -> str:
    package, _, name = type_name.split("/")
    return f"{package}/msg/{name}"

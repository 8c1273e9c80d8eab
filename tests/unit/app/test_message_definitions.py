"""Definitions of messages, put together from the .msg files of packages."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from target_nav.app.message_definitions import MessageDefinitions, parts_of, share_folders
from target_nav.errors import DeviceError


def add(share: Path, type_name: str, text: str, type_hash: str = "") -> None:
    package, _, name = type_name.split("/")
    folder = share / package / "msg"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.msg").write_text(text)
    if type_hash:
        hashes = [
            {"type_name": "x/msg/Other", "hash_string": "no"},
            {"type_name": type_name, "hash_string": type_hash},
        ]
        (folder / f"{name}.json").write_text(json.dumps({"type_hashes": hashes}))


@pytest.mark.parametrize(
    ("line", "parts"),
    [
        ("float32 x", []),
        ("string<=10[<=5] names  # Comment here", []),
        ("uint8 READY=1", []),
        ('string WORD = "a b"', []),
        ("# Pose pose", []),
        ("", []),
        ("Pose pose", ["own/msg/Pose"]),
        ("geometry_msgs/Pose[] poses", ["geometry_msgs/msg/Pose"]),
        ("geometry_msgs/Pose[<=3] poses", ["geometry_msgs/msg/Pose"]),
        ("  Pose[4] poses # four", ["own/msg/Pose"]),
        ("float64 w 1", []),
    ],
)
def test_fields_name_their_parts(line: str, parts: list[str]) -> None:
    assert parts_of(line, "own") == parts


def test_parts_of_parts_come_once_behind_the_message(tmp_path: Path) -> None:
    add(tmp_path, "a/msg/Top", "Mid first\nb/Leaf second\n", "RIHS01_x")
    add(tmp_path, "a/msg/Mid", "b/Leaf leaf\n")
    add(tmp_path, "b/msg/Leaf", "int32 value\n")
    definition = MessageDefinitions([tmp_path]).of("a/msg/Top")
    rule = "=" * 80
    assert definition.text == (
        f"Mid first\nb/Leaf second\n\n{rule}\nMSG: a/Mid\nb/Leaf leaf\n\n{rule}\nMSG: b/Leaf\nint32 value\n"
    )
    assert (definition.type_name, definition.type_hash) == ("a/msg/Top", "RIHS01_x")


def test_a_package_without_hashes_has_none(tmp_path: Path) -> None:
    add(tmp_path, "b/msg/Leaf", "int32 value\n")
    assert MessageDefinitions([tmp_path]).of("b/msg/Leaf").type_hash == ""


def test_the_first_folder_wins(tmp_path: Path) -> None:
    add(tmp_path / "one", "b/msg/Leaf", "int32 one\n")
    add(tmp_path / "two", "b/msg/Leaf", "int32 two\n")
    assert MessageDefinitions([tmp_path / "one", tmp_path / "two"]).of("b/msg/Leaf").text == "int32 one\n"


def test_what_is_not_installed_is_told(tmp_path: Path) -> None:
    add(tmp_path, "a/msg/Top", "b/Leaf second\n")
    with pytest.raises(
        DeviceError, match=r"definition of b/msg/Leaf is not installed .*is its ROS package sourced"
    ):
        MessageDefinitions([tmp_path]).of("a/msg/Top")


def test_sourced_prefixes_come_before_this_environment() -> None:
    folders = share_folders({"AMENT_PREFIX_PATH": "/opt/a:/opt/b"})
    assert folders[:2] == (Path("/opt/a/share"), Path("/opt/b/share"))
    assert len(folders) == 3
    assert len(share_folders({})) == 1

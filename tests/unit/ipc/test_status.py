"""`describe` tells the state of every file, whatever state it is in, and changes none."""

from __future__ import annotations

import math
import os

import pytest

from target_nav.errors import ConfigError
from target_nav.ipc import channels
from target_nav.ipc.channels import (
    CAMERA,
    DET,
    describe,
    open_command_reader,
    open_command_writer,
    open_writer,
)
from target_nav.ipc.files import path_of
from target_nav.ipc.header import FILE_HEADER, LAYOUT_VERSION
from target_nav.ipc.status import ChannelStatus
from target_nav.state.types import Command, CommandKind
from tests.unit.ipc.values import frame, picture


def status(prefix: str, name: str, now_s: float = 12.0) -> ChannelStatus:
    (found,) = [each for each in describe(prefix, now_s) if each.name == name]
    return found


def test_all_channels_are_listed_there_or_not(prefix: str) -> None:
    listed = describe(prefix)
    assert [each.name for each in listed] == [
        *("camera", "sim_camera", "detections", "calibration", "det", "nav", "laser"),
        *("avoid", "tree", "processes", "cmd", "cmd_ack"),
    ]
    assert not any(each.exists or each.alive for each in listed)
    assert all(each.age_s == math.inf and "is its writer running?" in each.problem for each in listed)
    assert listed[0].path == f"/dev/shm/{prefix}_camera"


def test_a_live_channel_tells_its_writer_age_and_count(prefix: str) -> None:
    with open_writer(DET, prefix) as writer:
        assert status(prefix, "det") == ChannelStatus(
            "det",
            str(path_of(prefix, "det")),
            True,
            os.getpid(),
            True,
            LAYOUT_VERSION,
            True,
            math.inf,
            0,
            DET.geometry.file_bytes,
        )
        for i in range(7):
            writer.write(frame(i, stamp_s=10.0))
        assert status(prefix, "det") == ChannelStatus(
            "det",
            str(path_of(prefix, "det")),
            True,
            os.getpid(),
            True,
            LAYOUT_VERSION,
            True,
            2.0,
            7,
            DET.geometry.file_bytes,
        )


def test_a_channel_whose_writer_has_gone_keeps_its_age(prefix: str) -> None:
    with open_writer(DET, prefix) as writer:
        writer.write(frame(1, stamp_s=10.0))
    found = status(prefix, "det")
    assert (found.alive, found.writer_pid, found.age_s, found.sequence) == (False, os.getpid(), 2.0, 1)
    assert f"its writer (pid {os.getpid()}) has gone" in found.problem


def test_pictures_and_commands_are_described_too(prefix: str) -> None:
    with (
        open_command_reader(prefix),
        open_command_writer(prefix) as commands,
        open_writer(CAMERA, prefix) as camera,
    ):
        camera.write(picture(1))
        commands.push(Command(11.0, CommandKind.GO))
        assert status(prefix, "camera").age_s == 2.0
        assert status(prefix, "cmd").age_s == 1.0
        assert status(prefix, "cmd_ack").alive


def test_every_odd_file_is_named_for_what_it_is(prefix: str) -> None:
    path = path_of(prefix, "det")
    path.write_bytes(b"")
    assert status(prefix, "det").problem.startswith("empty")
    path.write_bytes(b"somebody else's data" * 20)
    assert "not a channel of target_nav" in status(prefix, "det").problem
    path.unlink()
    with open_writer(DET, prefix):
        with path.open("r+b") as file:
            file.seek(FILE_HEADER["layout_version"].offset)
            file.write(bytes([7, 0, 0, 0]))
        found = status(prefix, "det")
        assert (found.version, found.compatible, found.alive) == (7, False, True)
        assert "layout version 7" in found.problem
        assert "restart its writer" in found.problem
    assert "its next writer replaces it" in status(prefix, "det").problem
    path.unlink()
    path.mkdir()
    assert "Is a directory" in status(prefix, "det").problem
    path.rmdir()


def test_a_bad_prefix_is_an_error_not_a_list(prefix: str) -> None:
    with pytest.raises(ConfigError):
        describe("a/b")
    assert channels.DEFAULT_PREFIX == "v2n"

"""The simulated serial line: raw bytes both ways, a link that is always whole."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from target_nav.app.serial_pty import SerialPty
from target_nav.errors import DeviceError
from target_nav.hardware.arduino_bridge import PORT_USE
from target_nav.hardware.serial_port import open_port

pytestmark = pytest.mark.linux

EVERY_BYTE = bytes(range(256))


def test_every_byte_passes_unchanged_in_both_directions(tmp_path: Path) -> None:
    with (
        SerialPty(tmp_path / "arduino") as line,
        open_port(str(tmp_path / "arduino"), 115200, PORT_USE, 1.0) as port,
    ):
        port.write(EVERY_BYTE)
        port.flush()
        assert line.read() == EVERY_BYTE
        line.write(EVERY_BYTE)
        got = b""
        while len(got) < 256:
            piece = port.read(256 - len(got))
            assert piece, "the port fell silent"
            got += piece
        assert got == EVERY_BYTE


def test_reading_never_blocks_and_needs_nobody() -> None:
    with SerialPty() as line:
        assert line.read() == b""


def test_what_nobody_reads_is_lost_and_counted() -> None:
    with SerialPty() as line:
        for _ in range(1000):
            line.write(b"ODOM,1,2,3\n" * 10)
        assert 0 < line.lost_bytes < 110_000


def test_the_far_end_may_come_and_go(tmp_path: Path) -> None:
    with SerialPty(tmp_path / "arduino") as line:
        for _ in range(3):
            with open_port(str(tmp_path / "arduino"), 115200, PORT_USE, 1.0) as port:
                port.write(b"STOP\n")
                port.flush()
            assert line.read() == b"STOP\n"
            assert line.read() == b""


def test_a_link_left_by_a_killed_process_is_replaced(tmp_path: Path) -> None:
    link = tmp_path / "arduino"
    link.symlink_to("/dev/pts/99999")
    with SerialPty(link) as line:
        assert os.readlink(link) == line.port
    assert not link.is_symlink()


def test_the_link_of_a_successor_is_left_alone(tmp_path: Path) -> None:
    link = tmp_path / "arduino"
    first, second = SerialPty(link), SerialPty(link)
    first.close()
    assert os.readlink(link) == second.port
    second.close()


def test_a_file_is_not_overwritten(tmp_path: Path) -> None:
    file = tmp_path / "arduino"
    file.write_text("precious")
    with pytest.raises(DeviceError, match="not a link"):
        SerialPty(file)
    assert file.read_text() == "precious"


def test_a_link_that_cannot_be_made_is_told() -> None:
    with pytest.raises(DeviceError, match="cannot be made"):
        SerialPty(Path("/proc/nowhere/arduino"))

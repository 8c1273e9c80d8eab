"""Opening a serial port: alone, empty, or with the reason why not."""

from __future__ import annotations

import errno
import os
import tty
from collections.abc import Iterator
from pathlib import Path

import pytest
import serial
from serial.tools import list_ports

from target_nav.errors import DeviceError
from target_nav.hardware import serial_port
from target_nav.hardware.serial_port import PortUse

pytestmark = pytest.mark.linux

USE = PortUse("gadget", "gadget.port", "another gadget node")


def open_port(port: str) -> serial.Serial:
    return serial_port.open_port(port, 115200, USE, timeout_s=0.1)


@pytest.fixture
def pty() -> Iterator[tuple[int, str]]:
    """A device's end of a line, and the name of the other."""
    master, slave = os.openpty()
    tty.setraw(slave)
    yield master, os.ttyname(slave)
    os.close(slave)
    os.close(master)


def test_what_was_sent_before_it_was_opened_is_forgotten(pty: tuple[int, str]) -> None:
    master, name = pty
    os.write(master, b"old line\n")
    with open_port(name) as port:
        assert port.in_waiting == 0
        os.write(master, b"new")
        assert port.read(3) == b"new"


def test_a_port_that_is_not_there(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(list_ports, "comports", list)
    with pytest.raises(DeviceError, match=r"no serial port .*ttyX0 for the gadget; .* gadget's USB cable"):
        open_port(str(tmp_path / "ttyX0"))


def test_a_port_another_process_has(pty: tuple[int, str]) -> None:
    with open_port(pty[1]), pytest.raises(DeviceError, match="in use; is another gadget node running"):
        open_port(pty[1])


def test_a_file_that_is_no_port(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_text("")
    for wrong in (path, tmp_path):
        with pytest.raises(DeviceError, match="not a serial port"):
            open_port(str(wrong))


def test_a_port_without_permission(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(_: serial.Serial) -> None:
        raise serial.SerialException(errno.EACCES, "could not open port: permission denied")

    monkeypatch.setattr(serial.Serial, "open", refuse)  # root, as tests often are, may open everything
    with pytest.raises(DeviceError, match=r"may not be opened .*usermod -aG dialout"):
        open_port("/dev/ttyX0")


def test_a_speed_that_is_none(pty: tuple[int, str]) -> None:
    with pytest.raises(DeviceError, match="cannot be opened at -1 baud"):
        serial_port.open_port(pty[1], -1, USE, timeout_s=0.1)

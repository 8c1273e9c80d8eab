"""What systemd hears, on a real socket."""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from target_nav.app.systemd_notify import SystemdNotifier
from target_nav.errors import DeviceError

pytestmark = pytest.mark.linux


@pytest.fixture
def listener(tmp_path: Path) -> Iterator[socket.socket]:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listener:
        listener.bind(str(tmp_path / "notify"))
        listener.settimeout(5.0)
        yield listener


def test_words_go_to_the_socket(listener: socket.socket) -> None:
    notifier = SystemdNotifier({"NOTIFY_SOCKET": listener.getsockname()})
    assert notifier.listened_to
    notifier.ready("the stack runs")
    notifier.alive()
    notifier.status("IDLE, 20.0 Hz")
    notifier.stopping()
    heard = [listener.recv(1000) for _ in range(4)]
    assert heard == [b"READY=1\nSTATUS=the stack runs", b"WATCHDOG=1", b"STATUS=IDLE, 20.0 Hz", b"STOPPING=1"]


def test_an_abstract_socket_is_found() -> None:
    name = f"target_nav_test_{os.getpid()}"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listener:
        listener.bind("\0" + name)
        listener.settimeout(5.0)
        SystemdNotifier({"NOTIFY_SOCKET": "@" + name}).alive()
        assert listener.recv(100) == b"WATCHDOG=1"


def test_without_systemd_nothing_happens() -> None:
    notifier = SystemdNotifier({})
    assert not notifier.listened_to
    notifier.ready("nobody hears this")


def test_a_systemd_that_is_gone_ends_nothing(tmp_path: Path) -> None:
    SystemdNotifier({"NOTIFY_SOCKET": str(tmp_path / "gone")}).alive()


def test_a_socket_that_is_full_does_not_block(listener: socket.socket) -> None:
    notifier = SystemdNotifier({"NOTIFY_SOCKET": listener.getsockname()})
    for _ in range(2000):
        notifier.alive()


def test_an_address_that_is_none_is_refused() -> None:
    with pytest.raises(DeviceError, match="neither a path nor an abstract name"):
        SystemdNotifier({"NOTIFY_SOCKET": "somewhere"})

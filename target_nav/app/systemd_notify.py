"""sd_notify without a library: datagrams to the socket that systemd names in $NOTIFY_SOCKET.

Source: sd_notify(3). Without that variable nothing happens, so a program needs not know whether systemd started it.
"""

from __future__ import annotations

import os
import socket
from collections.abc import Mapping

from target_nav.errors import DeviceError


class SystemdNotifier:
    """Tells systemd what state a service is in.

    Raises:
        DeviceError: $NOTIFY_SOCKET names something that cannot be a socket.
    """

    def __init__(self, environment: Mapping[str, str] | None = None) -> None:
        environment = os.environ if environment is None else environment
        address = environment.get("NOTIFY_SOCKET", "")
        if address and address[0] not in "/@":
            raise DeviceError(f"NOTIFY_SOCKET={address} is neither a path nor an abstract name")
        # An abstract name begins with a NUL byte, written as @.
        self._address = "\0" + address[1:] if address.startswith("@") else address

    @property
    def listened_to(self) -> bool:
        return bool(self._address)

    def ready(self, status: str) -> None:
        """The service has started (`Type=notify` waits for it)."""
        self._send(f"READY=1\nSTATUS={status}")

    def status(self, text: str) -> None:
        """One line for `systemctl status`."""
        self._send(f"STATUS={text}")

    def alive(self) -> None:
        """Feed the watchdog."""
        self._send("WATCHDOG=1")

    def stopping(self) -> None:
        self._send("STOPPING=1")

    def _send(self, text: str) -> None:
        if not self._address:
            return
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC) as sender:
            sender.setblocking(False)
            try:
                sender.sendto(text.encode("utf-8"), self._address)
            except OSError:
                # systemd is busy or gone: the next word comes soon, and a service does not end for that.
                return

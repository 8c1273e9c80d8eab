"""Which firmware is at the other end, before anything moves: asks VERSION until it is answered.

A firmware of another protocol would understand a velocity in its own way, so nothing but STOP and questions is sent
before the answer. One that does not answer at all is older than the question: it is driven, with a warning.
"""

from __future__ import annotations

from target_nav.errors import DeviceError
from target_nav.hardware.protocol import PROTOCOL_VERSION, VersionCommand, VersionLine, encode_command

ASK_EVERY_S = 1.0
ASK_TIMES = 4
"""An Arduino that was reset by the opening of its port answers after a second or two, and unasked."""

NOTHING = b""


class FirmwareCheck:
    """The dialogue over one connection; `restart` begins it anew. Reads no clock."""

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """The port was lost, or not opened yet: whoever is there next has not been asked."""
        self.version: VersionLine | None = None
        self.silent = False
        self._asked = 0
        self._asked_s = float("-inf")

    @property
    def may_drive(self) -> bool:
        return self.version is not None or self.silent

    def poll(self, now_s: float) -> bytes:
        """The line to send now, or NOTHING. To be called some times a second."""
        if self.may_drive or now_s - self._asked_s < ASK_EVERY_S:
            return NOTHING
        if self._asked == ASK_TIMES:
            self.silent = True
            return NOTHING
        self._asked += 1
        self._asked_s = now_s
        return encode_command(VersionCommand())

    def take(self, line: VersionLine, port: str) -> None:
        """An answer, or what a firmware says by itself after a reset.

        Raises:
            DeviceError: it speaks another protocol.
        """
        if line.protocol != PROTOCOL_VERSION:
            raise DeviceError(
                f"the firmware on {port} (version {line.firmware}) speaks protocol {line.protocol}, this program "
                f"{PROTOCOL_VERSION}; flash this checkout's: make -C deploy/firmware flash PORT={port}"
            )
        self.version = line

"""A pseudo-terminal with a simulated Arduino behind it, found under a name that stays the same."""

from __future__ import annotations

import contextlib
import errno
import os
import tty
from pathlib import Path

from target_nav.errors import DeviceError

READ_BYTES = 4096


class SerialPty:
    """The device's end of a serial line. Whoever opens `link` (or `port`) as a serial port has the other end.

    The other end is kept open here too: without it, reading fails whenever nobody is connected.

    Raises:
        DeviceError: `link` exists and is not a link.
    """

    def __init__(self, link: Path | None = None) -> None:
        self._link = link
        self._master, self._slave = os.openpty()
        try:
            tty.setraw(self._slave)
            os.set_blocking(self._master, False)
            self.port = os.ttyname(self._slave)
            if link is not None:
                _place_link(link, self.port)
        except BaseException:
            os.close(self._master)
            os.close(self._slave)
            raise
        self.lost_bytes = 0

    def fileno(self) -> int:
        """To wait on with `select`, for what the other side sends."""
        return self._master

    def read(self) -> bytes:
        """What has come in, empty if nothing."""
        try:
            return os.read(self._master, READ_BYTES)
        except BlockingIOError:
            return b""

    def write(self, data: bytes) -> None:
        """Send; what does not fit because nobody reads is lost and counted, as on a wire."""
        try:
            sent = os.write(self._master, data) if data else 0
        except BlockingIOError:
            sent = 0
        self.lost_bytes += len(data) - sent

    def close(self) -> None:
        """Close both ends and take the link away, if it is still this one's."""
        if self._link is not None:
            with contextlib.suppress(OSError):
                if os.readlink(self._link) == self.port:
                    self._link.unlink()
        os.close(self._master)
        os.close(self._slave)

    def __enter__(self) -> SerialPty:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _place_link(link: Path, port: str) -> None:
    """Point `link` at `port` in one step: whoever opens it meanwhile gets the old port or the new one."""
    if link.exists() and not link.is_symlink():
        raise DeviceError(f"{link} exists and is not a link to a serial port; choose another --serial-link")
    fresh = link.with_name(f".{link.name}.{os.getpid()}")
    try:
        link.parent.mkdir(parents=True, exist_ok=True)
        fresh.symlink_to(port)
        os.replace(fresh, link)
    except OSError as error:
        what = errno.errorcode.get(error.errno or 0, "")
        raise DeviceError(
            f"the link {link} to the serial port cannot be made ({what}: {error.strerror})"
        ) from error

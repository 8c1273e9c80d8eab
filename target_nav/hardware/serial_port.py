"""Opening a serial port: for this process alone, with nothing old in its buffers, or with the reason why not."""

from __future__ import annotations

import errno
from dataclasses import dataclass

import serial
from serial.tools import list_ports

from target_nav.errors import DeviceError


@dataclass(frozen=True)
class PortUse:
    """What a port is for, as its messages say it."""

    device: str
    """Whose port it is: Arduino, LiDAR."""
    key: str
    """Of the configuration, which names the port."""
    rivals: str
    """Who else might have it open."""


def open_port(port: str, baud: int, use: PortUse, timeout_s: float, dtr: bool = True) -> serial.Serial:
    """The port, opened exclusively, its input and output buffers emptied.

    Args:
        timeout_s: how long a read waits for its first byte, and at most ten times as long a write.
        dtr: the level of DTR from the moment it is opened. True resets an Arduino; a pty has no such line.

    Raises:
        DeviceError: with the reason, the ports there are, and what to do.
    """
    opened = serial.Serial(timeout=timeout_s, write_timeout=10.0 * timeout_s, exclusive=True)
    try:
        opened.port, opened.baudrate = port, baud
        # Before it is opened, so that nothing starts or stops in between; pyserial lets a pty refuse it.
        opened.dtr = dtr
        opened.open()
        opened.reset_input_buffer()
        opened.reset_output_buffer()
    except (serial.SerialException, OSError, ValueError) as error:
        opened.close()
        raise DeviceError(_explain(port, baud, use, error)) from error
    return opened


def _explain(port: str, baud: int, use: PortUse, error: Exception) -> str:
    code = getattr(error, "errno", None)
    if code == errno.ENOENT:
        return f"there is no serial port {port} for the {use.device}; {_found(use)}"
    if code in (errno.EACCES, errno.EPERM):
        return (
            f"serial port {port} of the {use.device} may not be opened by this user; "
            "add it to the port's group (sudo usermod -aG dialout $USER) and log in again"
        )
    if code in (errno.EBUSY, errno.EAGAIN, errno.EWOULDBLOCK) or "exclusively lock" in str(error):
        return f"serial port {port} is in use; is {use.rivals} running? {_found(use)}"
    if code == errno.EISDIR or "Could not configure port" in str(error):
        return f"{port} is not a serial port; {_found(use)}"
    return f"serial port {port} of the {use.device} cannot be opened at {baud} baud: {error}; {_found(use)}"


def _found(use: PortUse) -> str:
    ports = [
        f"{info.device} ({info.description})" if info.description not in (None, "n/a") else info.device
        for info in sorted(list_ports.comports())
    ]
    if not ports:
        return f"no serial port was found at all; is the {use.device}'s USB cable plugged in?"
    return f"found {', '.join(ports)}; choose one with --port or the key {use.key}"

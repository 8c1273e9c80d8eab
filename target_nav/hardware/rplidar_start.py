"""The dialogue with an RPLidar before its samples flow: opens the port, asks after its health, starts the scan.

The motor hangs on DTR: released it turns, asserted it stands.
"""

from __future__ import annotations

import contextlib
import time
from dataclasses import dataclass

import serial

from target_nav.errors import DeviceError
from target_nav.hardware.rplidar_protocol import (
    HEALTH_BYTES,
    HEALTH_DESCRIPTOR,
    INFO_BYTES,
    INFO_DESCRIPTOR,
    SCAN_DESCRIPTOR,
    DeviceInfo,
    Health,
    HealthStatus,
    Request,
    parse_health,
    parse_info,
)
from target_nav.hardware.serial_port import PortUse, open_port

READ_TIMEOUT_S = 0.1
"""How soon a reader notices that it shall end."""

PORT_USE = PortUse("LiDAR", "lidar.port", "another LiDAR driver")

ANSWER_S = 1.0
QUIET_S = 0.05
RESET_S = 2.0
"""An A1 takes so long to come back from a reset."""


@dataclass(frozen=True)
class Started:
    """A LiDAR that scans: from here on its port only sends samples."""

    port: serial.Serial
    info: DeviceInfo
    health: Health


def start_lidar(port: str, baud: int) -> Started:
    """Open the port and start motor and scan. Takes 0.1 s, with a reset 2 s more.

    Raises:
        DeviceError: the port is not there, may not be opened, belongs to another process; nothing answers as an
            RPLidar does, or it reports that it is broken.
    """
    # DTR released: the motor turns.
    opened = open_port(port, baud, PORT_USE, READ_TIMEOUT_S, dtr=False)
    try:
        health = _healthy(opened)
        info = parse_info(_ask(opened, Request.GET_INFO, INFO_DESCRIPTOR, INFO_BYTES))
        _ask(opened, Request.SCAN, SCAN_DESCRIPTOR, 0)
    except (serial.SerialException, OSError) as error:
        stop_lidar(opened)
        raise DeviceError(f"the LiDAR on {port} was lost while it was started: {error}") from error
    except DeviceError:
        stop_lidar(opened)
        raise
    return Started(opened, info, health)


def stop_lidar(port: serial.Serial) -> None:
    """Stop scan and motor as far as they can be reached, and close the port."""
    for step in (_send_stop, _stop_motor, serial.Serial.close):
        # A device that is gone takes no orders and leaves nothing to close.
        with contextlib.suppress(serial.SerialException, OSError):
            step(port)


def _healthy(port: serial.Serial) -> Health:
    _silence(port)
    health = _ask_health(port)
    if health.status is HealthStatus.ERROR:
        port.write(Request.RESET.encode())
        time.sleep(RESET_S)
        _silence(port)
        health = _ask_health(port)
    if health.status is HealthStatus.ERROR:
        raise DeviceError(
            f"the LiDAR on {port.port} stopped to protect itself (error {health.code:#06x}) and a reset did not help; "
            "take its power away for a moment, then look whether its head turns freely"
        )
    return health


def _ask_health(port: serial.Serial) -> Health:
    return parse_health(_ask(port, Request.GET_HEALTH, HEALTH_DESCRIPTOR, HEALTH_BYTES))


def _silence(port: serial.Serial) -> None:
    """End a scan that somebody left running and swallow what is still under way."""
    _send_stop(port)
    now_s = quiet_since_s = time.monotonic()
    deadline_s = now_s + ANSWER_S
    while now_s - quiet_since_s < QUIET_S and now_s < deadline_s:
        time.sleep(0.2 * QUIET_S)
        now_s = time.monotonic()
        if port.read(port.in_waiting):
            quiet_since_s = now_s


def _ask(port: serial.Serial, request: Request, descriptor: bytes, count: int) -> bytes:
    """Send a request; the `count` bytes behind its answer's descriptor. What comes before that is noise."""
    port.write(request.encode())
    deadline_s = time.monotonic() + ANSWER_S
    heard = b""
    while True:
        at = heard.find(descriptor)
        wanted = at + len(descriptor) + count if at >= 0 else len(heard) + 1
        if at >= 0 and len(heard) >= wanted:
            return heard[at + len(descriptor) : wanted]
        if time.monotonic() >= deadline_s:
            break
        heard += port.read(wanted - len(heard))
    said = f"{len(heard)} bytes that are no answer" if heard else "nothing"
    raise DeviceError(
        f"{port.port} answered {said} to {request.name} within {ANSWER_S:g} s at {port.baudrate} baud; "
        "is it an RPLidar A1, and has it power?"
    )


def _send_stop(port: serial.Serial) -> None:
    port.write(Request.STOP.encode())


def _stop_motor(port: serial.Serial) -> None:
    port.dtr = True

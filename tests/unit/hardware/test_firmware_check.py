"""Nothing drives before the firmware has told what it is."""

from __future__ import annotations

import pytest

from target_nav.errors import DeviceError
from target_nav.hardware.firmware_check import ASK_TIMES, NOTHING, FirmwareCheck
from target_nav.hardware.protocol import PROTOCOL_VERSION, VersionLine

OURS = VersionLine(PROTOCOL_VERSION, "0.1.0")


def asked(check: FirmwareCheck, seconds: float, begin_s: float = 100.0) -> list[bytes]:
    """What is sent in so many seconds of 20 Hz."""
    lines = (check.poll(begin_s + 0.05 * tick) for tick in range(round(20 * seconds)))
    return [line for line in lines if line != NOTHING]


def test_it_asks_at_once_and_drives_with_the_answer() -> None:
    check = FirmwareCheck()
    assert check.poll(100.0) == b"VERSION\n"
    assert not check.may_drive
    check.take(OURS, "port")
    assert check.may_drive
    assert check.version == OURS
    assert asked(check, 10.0, 100.05) == []


def test_it_asks_again_for_a_board_that_is_still_starting() -> None:
    check = FirmwareCheck()
    assert asked(check, 2.5) == [b"VERSION\n"] * 3


def test_who_never_answers_is_driven_after_some_seconds_and_known_as_silent() -> None:
    check = FirmwareCheck()
    assert asked(check, 10.0) == [b"VERSION\n"] * ASK_TIMES
    assert check.may_drive
    assert check.silent
    assert check.version is None


def test_another_protocol_is_refused_with_what_to_do() -> None:
    check = FirmwareCheck()
    with pytest.raises(
        DeviceError, match=r"on /dev/x .* speaks protocol 9, this program 1; flash .*PORT=/dev/x"
    ):
        check.take(VersionLine(9, "3.0.0"), "/dev/x")
    assert not check.may_drive


def test_a_new_connection_is_asked_anew() -> None:
    check = FirmwareCheck()
    check.take(OURS, "port")
    check.restart()
    assert not check.may_drive
    assert check.poll(0.0) == b"VERSION\n"

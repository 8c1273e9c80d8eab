"""The firmware's own unit tests under sanitizers, the image's size, and the same logic on both processors."""

from __future__ import annotations

import re
import subprocess

import pytest

from tests.utils.firmware import BUILD, made, need_avr_tools, need_make, need_simavr

pytestmark = pytest.mark.slow

RAM_BYTES = 8192
FLASH_BYTES = 262_144 - 8192
"""The boot loader keeps the last 8 KB."""


def test_unit_tests_and_fuzz_pass_under_sanitizers() -> None:
    need_make()
    probe = ["c++", "-x", "c++", "-fsanitize=address,undefined", "-", "-o", "/dev/null"]
    if subprocess.run(probe, input="int main() {}", text=True, capture_output=True).returncode != 0:
        pytest.skip("this compiler has no address and undefined-behaviour sanitizers")
    (run, failed) = re.findall(r"^(\d+) tests, (\d+) failed$", made("check"), re.MULTILINE)[-1]
    assert int(run) > 50
    assert failed == "0"


def test_a_failing_unit_test_is_told() -> None:
    """That the runner of one file can fail."""
    need_make()
    made("check")
    done = subprocess.run([BUILD / "unit_tests", "no_test_has_this_name"], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (1, "0 tests, 0 failed\n")


def test_the_image_leaves_half_of_the_ram() -> None:
    need_avr_tools()
    output = made("avr")
    (flash, ram) = re.findall(r"^flash (\d+) of .* RAM (\d+) of ", output, re.MULTILINE)[-1]
    print(output.splitlines()[-1])
    assert 5_000 < int(flash) < FLASH_BYTES
    assert 500 < int(ram) < RAM_BYTES // 2


def test_the_same_script_gives_the_same_bytes_on_the_atmega2560() -> None:
    """Its int has 16 bit: an arithmetic that is right here may overflow there."""
    need_simavr()
    (lines,) = re.findall(r"^(\d+) lines, equal$", made("golden"), re.MULTILINE)
    assert int(lines) > 1000

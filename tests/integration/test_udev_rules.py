"""Serial names on the robot: which device gets which, by the rules that are installed."""

from __future__ import annotations

import re
import shutil
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from target_nav.app.robot_ports import ARDUINO_LINK, LIDAR_LINK

RULES = Path(__file__).resolve().parents[2] / "deploy" / "udev" / "60-target-nav.rules"


@dataclass
class Node:
    """What the rules made of a device."""

    links: list[str] = field(default_factory=list)
    assigned: dict[str, str] = field(default_factory=dict)


def apply_rules(text: str, device: dict[str, str]) -> Node:
    """udev(7) as far as these rules go: ==, !=, =, +=, GOTO and LABEL. Anything else is an error."""
    lines = []
    for line in text.splitlines():
        if line and not line.startswith("#"):
            parts = [
                re.fullmatch(r'\s*([A-Z]+(?:\{\w+\})?)(==|!=|\+=|=)"([^"]*)"\s*', p) for p in line.split(",")
            ]
            assert all(parts), line
            lines.append([part.groups() for part in parts if part])
    labels = {v: n for n, rule in enumerate(lines) for key, _, v in rule if key == "LABEL"}
    node, at = Node(), 0
    while at < len(lines):
        rule, at = lines[at], at + 1
        matches = [(key, op, value) for key, op, value in rule if op in ("==", "!=")]
        if not all((device.get(key) == value) is (op == "==") for key, op, value in matches):
            continue
        for key, op, value in rule:
            if key == "GOTO":
                at = labels[value]
            elif key == "SYMLINK":
                assert op == "+="
                node.links.append(value)
            elif op in ("=", "+=") and key != "LABEL":
                node.assigned[key] = value
    return node


def tty(vendor: str, product: str, **more: str) -> dict[str, str]:
    ids = {"ATTRS{idVendor}": vendor, "ATTRS{idProduct}": product}
    return {"ACTION": "add", "SUBSYSTEM": "tty", **ids, **more}


@pytest.mark.parametrize(
    ("vendor", "product", "link"),
    [
        ("2341", "0042", ARDUINO_LINK),
        ("2a03", "0042", ARDUINO_LINK),
        ("1a86", "7523", ARDUINO_LINK),
        ("10c4", "ea60", LIDAR_LINK),
    ],
)
def test_known_devices_get_their_name(vendor: str, product: str, link: str) -> None:
    node = apply_rules(RULES.read_text(), tty(vendor, product))
    assert [f"/dev/{name}" for name in node.links] == [link]
    assert node.assigned["GROUP"] == "dialout"
    assert node.assigned["MODE"] == "0660"
    assert node.assigned["TAG"] == "systemd"
    assert node.assigned["ENV{ID_MM_DEVICE_IGNORE}"] == "1"


@pytest.mark.parametrize(
    "device",
    [
        tty("2341", "0043"),
        tty("0403", "6001"),
        tty("10c4", "0042"),
        tty("2341", "0042", SUBSYSTEM="usb"),
        tty("2341", "0042", ACTION="remove"),
    ],
)
def test_other_devices_are_left_alone(device: dict[str, str]) -> None:
    assert apply_rules(RULES.read_text(), device) == Node()


def udevadm_verifies() -> bool:
    tool = shutil.which("udevadm")
    return (
        tool is not None and subprocess.run([tool, "verify", "--help"], capture_output=True).returncode == 0
    )


@pytest.mark.skipif(not udevadm_verifies(), reason="udevadm of systemd 254 or newer is not installed")
def test_udev_has_nothing_to_say_about_the_rules() -> None:
    done = subprocess.run(["udevadm", "verify", RULES], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stdout + done.stderr

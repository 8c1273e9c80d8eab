"""Serial ports by stable name."""

from __future__ import annotations

from pathlib import Path

from target_nav.app.robot_ports import arduino_port, lidar_port
from target_nav.config import Config


def test_the_stable_name_counts_where_it_exists(tmp_path: Path) -> None:
    link = tmp_path / "target_nav_arduino"
    assert arduino_port(Config(), str(link)) == "/dev/ttyACM0"
    assert lidar_port(Config(), str(link)) == "/dev/ttyUSB0"
    link.symlink_to("/dev/null")
    assert arduino_port(Config(), str(link)) == str(link)
    assert lidar_port(Config(), str(link)) == str(link)


def test_a_port_that_was_chosen_wins(tmp_path: Path) -> None:
    link = tmp_path / "target_nav_lidar"
    link.symlink_to("/dev/null")
    chosen = Config().override({"serial.port": "/dev/ttyS1", "lidar.port": "/dev/ttyS2"})
    assert arduino_port(chosen, str(link)) == "/dev/ttyS1"
    assert lidar_port(chosen, str(link)) == "/dev/ttyS2"

"""The robot's serial ports by the names that `deploy/udev` gives them: a plug in another socket changes nothing."""

from __future__ import annotations

from pathlib import Path

from target_nav.config import Config

ARDUINO_LINK = "/dev/target_nav_arduino"
LIDAR_LINK = "/dev/target_nav_lidar"


def arduino_port(config: Config, link: str = ARDUINO_LINK) -> str:
    """The key serial.port; where that was left alone and the stable name exists, the stable name."""
    return _port(config.serial.port, Config().serial.port, link)


def lidar_port(config: Config, link: str = LIDAR_LINK) -> str:
    """The key lidar.port; where that was left alone and the stable name exists, the stable name."""
    return _port(config.lidar.port, Config().lidar.port, link)


def _port(configured: str, default: str, link: str) -> str:
    return link if configured == default and Path(link).exists() else configured

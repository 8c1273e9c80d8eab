"""The odometry node's last pose, kept where a successor finds it: a restarted process must not make odom jump."""

from __future__ import annotations

import os
import struct
import zlib
from pathlib import Path

from target_nav.state.types import Odometry, Pose2D

RESUME_LIMIT_S = 10.0
"""A pose older than this is of another run: the robot may have been carried away since."""

_LAYOUT = struct.Struct("<4d")
_CHECK = struct.Struct("<I")


class PoseFile:
    """One small file, overwritten with every message; a checksum tells a whole record from a torn one."""

    def __init__(self, path: Path) -> None:
        self._descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)

    def keep(self, odometry: Odometry) -> None:
        pose = odometry.pose_in_odom
        data = _LAYOUT.pack(odometry.stamp_s, pose.x_m, pose.y_m, pose.yaw_rad)
        os.pwrite(self._descriptor, data + _CHECK.pack(zlib.crc32(data)), 0)

    def last(self, now_s: float) -> tuple[float, Pose2D] | None:
        """Stamp and pose of the predecessor, None if there is none, or none that is whole and recent."""
        record = os.pread(self._descriptor, _LAYOUT.size + _CHECK.size, 0)
        data = record[: _LAYOUT.size]
        if len(record) != _LAYOUT.size + _CHECK.size or _CHECK.unpack(record[_LAYOUT.size :])[
            0
        ] != zlib.crc32(data):
            return None
        stamp_s, *values = _LAYOUT.unpack(data)
        pose = Pose2D(*values)
        return (stamp_s, pose) if 0.0 <= now_s - stamp_s <= RESUME_LIMIT_S and pose.is_finite() else None

    def close(self) -> None:
        os.close(self._descriptor)

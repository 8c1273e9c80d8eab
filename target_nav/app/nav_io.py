"""The nav process's inputs and outputs: ROS 2 topics on one side, shared memory on the other.

Messages arrive in the executor's thread and wait in stores; `read` takes them at the begin of a tick, so a tick sees
one consistent world.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from target_nav.app.robot_description import frame_to_msg, frames
from target_nav.app.ros_convert import odometry_from_msg, scan_from_msg, twist_to_msg
from target_nav.app.ros_support import RosNode, command_qos, latched_qos, sensor_qos, stream_qos
from target_nav.config import Config
from target_nav.ipc import channels
from target_nav.state.snapshots import AvoidSnapshot, LaserSnapshot, NavSnapshot
from target_nav.state.stores import LatestStore, QueueStore
from target_nav.state.types import STOP, Command, CommandKind, Inputs, Odometry, Pose2D, Scan, Twist2D
from target_nav.utils.frames import points_to_parent

ODOMETRY_WAITING = 100
QUIET_AFTER_S = 1.0
"""Zero velocity is sent so long after a mission, then nothing: the layer below stops by itself, and a person may use
its position mode."""

STATE_PERIOD_S = 0.2
LASER_POINTS = 1440


class NavIo:
    """Implements the nav core's `InputSource` and `OutputSink`.

    Raises:
        DeviceError: another process writes the same channels.
    """

    def __init__(self, ros: RosNode, config: Config) -> None:
        from geometry_msgs.msg import Twist
        from nav_msgs.msg import Odometry as OdometryMsg
        from sensor_msgs.msg import LaserScan
        from std_msgs.msg import Empty, String
        from tf2_msgs.msg import TFMessage

        self._ros, self._config = ros, config
        self._scan: LatestStore[Scan] = LatestStore()
        self._odometry: LatestStore[Odometry] = LatestStore()
        self._odometry_since: QueueStore[Odometry] = QueueStore(ODOMETRY_WAITING)
        self._injected: list[Command] = []
        self._laser_sent: Scan | None = None
        self._quiet_from_s: float | None = None
        self._state_key: tuple[object, ...] = ()
        self._state_s = 0.0

        prefix = config.ipc.prefix
        self._nav = channels.open_writer(channels.NAV, prefix=prefix)
        self._laser = channels.open_writer(channels.LASER, prefix=prefix)
        self._avoid = channels.open_writer(channels.AVOID, prefix=prefix)
        self._detections = channels.open_reader(channels.DET, prefix=prefix)
        self._commands = channels.open_command_reader(prefix)

        self._send_twist = ros.publisher(Twist, "/cmd_vel", command_qos())
        self._send_state = ros.publisher(String, "/nav_state", stream_qos())
        self._send_drive_command = ros.publisher(String, "/arduino/cmd", command_qos())
        self._send_reset = ros.publisher(Empty, "/reset_odom", command_qos())
        self._string, self._empty = String, Empty
        ros.subscribe(LaserScan, "/scan", self._take_scan, sensor_qos())
        ros.subscribe(OdometryMsg, "/odom", self._take_odometry, stream_qos())
        self._send_mounts(ros.publisher(TFMessage, "/tf_static", latched_qos()), TFMessage)

    # -- in the executor's thread --------------------------------------------------------------------------------------

    def _take_scan(self, message: Any) -> None:
        self._scan.put(scan_from_msg(message, self._ros.clock))

    def _take_odometry(self, message: Any) -> None:
        odometry = odometry_from_msg(message, self._ros.clock)
        self._odometry_since.put(odometry)
        self._odometry.put(odometry)

    # -- in the tick's thread ------------------------------------------------------------------------------------------

    def read(self, now_s: float) -> Inputs:
        since = self._odometry_since.take_all()
        return Inputs(
            now_s=now_s,
            scan=self._scan.latest(),
            odometry=self._odometry.latest(),
            odometry_since=since,
            detections=self._detections.latest(),
            commands=(*self._take_injected(), *self._commands.pop_all()),
        )

    def publish(self, snapshot: NavSnapshot, inputs: Inputs) -> None:
        self._publish_twist(snapshot)
        if any(command.kind is CommandKind.STOP for command in inputs.commands):
            # A zero velocity leaves a position move alone; the operator's STOP does not.
            self._send_drive_command(self._string(data="STOP"))
        self._nav.write(snapshot)
        self._publish_laser(snapshot.pose_in_odom, inputs.scan)
        self._publish_state(snapshot)

    def inject(self, command: Command) -> None:
        """Add a command to the next tick's, as if an operator had sent it."""
        self._injected.append(command)

    def reset_odometry(self) -> None:
        self._send_reset(self._empty())

    def send_to_firmware(self, line: str) -> None:
        self._send_drive_command(self._string(data=line))

    def publish_avoidance(self, avoidance: AvoidSnapshot) -> None:
        self._avoid.write(avoidance)

    def stop_wheels(self) -> None:
        """The last word of a process that ends, for whatever reason."""
        self._send_twist(twist_to_msg(STOP))

    def close(self) -> None:
        for channel in (self._nav, self._laser, self._avoid, self._detections, self._commands):
            channel.close()

    # ------------------------------------------------------------------------------------------------------------------

    def _take_injected(self) -> list[Command]:
        injected, self._injected = self._injected, []
        return injected

    def _publish_twist(self, snapshot: NavSnapshot) -> None:
        # driving by hand begins with zeros too: the firmware tells its odometry only while somebody drives
        wanted = (snapshot.requested and snapshot.outcome is None) or snapshot.manual
        active = wanted or snapshot.twist_sent != STOP
        if active:
            self._quiet_from_s = snapshot.stamp_s + QUIET_AFTER_S
        if self._quiet_from_s is not None and snapshot.stamp_s <= self._quiet_from_s:
            self._send_twist(twist_to_msg(snapshot.twist_sent))

    def _publish_laser(self, pose: Pose2D, scan: Scan | None) -> None:
        if scan is None or scan is self._laser_sent:
            return
        self._laser_sent = scan
        valid = (
            np.isfinite(scan.ranges_m)
            & (scan.ranges_m >= scan.range_min_m)
            & (scan.ranges_m <= scan.range_max_m)
        )
        index = np.flatnonzero(valid)[:LASER_POINTS]
        angles = scan.angle_min_rad + index * scan.angle_increment_rad
        points = scan.ranges_m[index, None] * np.column_stack((np.cos(angles), np.sin(angles)))
        lidar = self._config.lidar
        mount = Pose2D(lidar.x_m, lidar.y_m, lidar.yaw_rad)
        self._laser.write(LaserSnapshot(scan.stamp_s, pose, points_to_parent(mount, points)))

    def _publish_state(self, snapshot: NavSnapshot) -> None:
        key = (snapshot.state, snapshot.running_leaf, snapshot.outcome)
        if key == self._state_key and snapshot.stamp_s - self._state_s < STATE_PERIOD_S:
            return
        self._state_key, self._state_s = key, snapshot.stamp_s
        self._send_state(self._string(data=json.dumps(state_of(snapshot))))

    def _send_mounts(self, send: Any, message_type: Any) -> None:
        now_s = self._ros.clock.now_s()
        send(message_type(transforms=[frame_to_msg(f, now_s, self._ros.clock) for f in frames(self._config)]))


def state_of(snapshot: NavSnapshot) -> dict[str, Any]:
    """What /nav_state says, as JSON values."""
    pose, twist, track = snapshot.pose_in_odom, snapshot.twist_sent, snapshot.track
    return {
        "state": snapshot.state.name,
        "leaf": snapshot.running_leaf,
        "reason": snapshot.reason,
        "requested": snapshot.requested,
        "outcome": snapshot.outcome.kind.value if snapshot.outcome is not None else None,
        "outcome_reason": snapshot.outcome.reason if snapshot.outcome is not None else None,
        "pose": [pose.x_m, pose.y_m, pose.yaw_rad],
        "twist": _values(twist),
        "limited_by": snapshot.limited_by,
        "target": None if track is None else {"range_m": track.range_m, "bearing_rad": track.bearing_rad},
    }


def _values(twist: Twist2D) -> list[float]:
    return [twist.vx_mps, twist.vy_mps, twist.wz_radps]

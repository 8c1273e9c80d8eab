"""Process `odometry`: the firmware's velocities integrated into /odom and the transform odom -> base_link.

/arduino/odom_raw (std_msgs/String)   in: JSON of the arduino node
/reset_odom (std_msgs/Empty)          in: the robot's present pose becomes odom's origin
/odom (nav_msgs/Odometry), /tf        out: stamped with the time at which the line came over the serial port
"""

from __future__ import annotations

import argparse
import json
import logging
import math
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from target_nav.app.odometry_state import PoseFile
from target_nav.app.process import report_ready, run_process
from target_nav.app.ros_convert import (
    BASE_FRAME,
    FUTURE_LIMIT_S,
    ODOM_FRAME,
    PAST_LIMIT_S,
    BadMessageError,
    odometry_to_msg,
    transform_to_msg,
)
from target_nav.app.ros_support import RosNode, command_qos, stream_qos, tf_qos
from target_nav.app.settings import add_config_arguments, config_from, parse_arguments
from target_nav.config import Config
from target_nav.errors import ConfigError
from target_nav.nav.odometry import OdometryIntegrator, OdometryNoise, OdometryScale
from target_nav.state.types import STOP, Twist2D

RAW_DEPTH = 50

log = logging.getLogger(__name__)


def parse_raw(text: str, now_s: float) -> tuple[float, Twist2D, int | None]:
    """Stamp, velocity and the firmware's clock (None: not told) of one message on /arduino/odom_raw.

    Raises:
        BadMessageError: not the arduino node's JSON, a number that is not finite, a stamp far off.
    """
    try:
        data = json.loads(text)
        stamp_s, *values = (float(data[key]) for key in ("stamp_s", "vx_mm", "vy_mm", "wz_mrad"))
        device_us = int(data["device_us"]) if "device_us" in data else None
    except (ValueError, KeyError, TypeError, OverflowError) as error:
        raise BadMessageError(
            "raw.form", f"{text[:80]!r} is not the arduino node's JSON ({error!r})"
        ) from error
    if not all(math.isfinite(value) for value in (stamp_s, *values)):
        raise BadMessageError("raw.not_finite", f"{text[:80]!r} has a number that is not finite")
    age_s = now_s - stamp_s
    if not -FUTURE_LIMIT_S <= age_s <= PAST_LIMIT_S:
        raise BadMessageError(
            "raw.stamp", f"stamped {age_s:.3f} s ago; does the arduino node run on this machine?"
        )
    vx, vy, wz = (value / 1000.0 for value in values)
    return stamp_s, Twist2D(vx, vy, wz), device_us


class OdometryNode:
    """Everything happens in the executor's thread."""

    def __init__(self, ros: RosNode, config: Config, state: PoseFile | None = None) -> None:
        from nav_msgs.msg import Odometry
        from std_msgs.msg import Empty, String
        from tf2_msgs.msg import TFMessage

        self._ros = ros
        self._tf_message = TFMessage
        calibration = config.odometry
        self._noise = OdometryNoise()
        self._last_twist = STOP
        self.integrator = OdometryIntegrator(
            OdometryScale(calibration.forward_scale, calibration.lateral_scale, calibration.yaw_scale),
            calibration.max_gap_s,
            self._noise,
        )
        self._state = state
        last = state.last(ros.clock.now_s()) if state is not None else None
        if last is not None:
            self.integrator.resume(*last)
            log.info("going on from %s, %.2f s ago", last[1], ros.clock.now_s() - last[0])
        self._publish_odometry = ros.publisher(Odometry, "/odom", stream_qos())
        self._publish_tf = ros.publisher(TFMessage, "/tf", tf_qos())
        ros.subscribe(String, "/arduino/odom_raw", self._take_raw, stream_qos(RAW_DEPTH))
        ros.subscribe(Empty, "/reset_odom", self._reset, command_qos())

    def _take_raw(self, message: Any) -> None:
        clock = self._ros.clock
        stamp_s, twist, device_us = parse_raw(message.data, clock.now_s())
        odometry = self.integrator.add(stamp_s, twist, device_us)
        if odometry is None:
            raise BadMessageError("raw.order", f"the message of {stamp_s:.3f} s came after a newer one")
        # The firmware is silent while it is not driven, so a gap between two standstills is nothing.
        moving = odometry.twist_in_base != STOP or self._last_twist != STOP
        if self.integrator.in_gap and moving:
            self._ros.warnings.warn(
                "odometry.gap", "a gap in odometry: the pose may be wrong by what was driven meanwhile"
            )
        self._last_twist = odometry.twist_in_base
        if self._state is not None:
            self._state.keep(odometry)
        self._publish_odometry(
            odometry_to_msg(
                odometry, clock, self.integrator.covariance, self._noise.velocity(odometry.twist_in_base)
            )
        )
        transform = transform_to_msg(stamp_s, ODOM_FRAME, BASE_FRAME, odometry.pose_in_odom, clock)
        self._publish_tf(self._tf_message(transforms=[transform]))

    def _reset(self, message: Any) -> None:
        self.integrator.reset()
        log.info("odometry reset: this pose is the origin now")


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="odometry_node", description="Integrates wheel odometry: /odom and /tf."
    )
    parser.add_argument("--state", metavar="FILE", type=Path, help="keeps the pose for a restarted node")
    add_config_arguments(parser)
    arguments = parse_arguments(parser)
    sys.exit(run_process("odometry", lambda: _run(arguments)))


def _run(arguments: argparse.Namespace) -> None:
    config = config_from(arguments)
    with ExitStack() as stack:
        state = _pose_file(arguments.state) if arguments.state is not None else None
        if state is not None:
            stack.callback(state.close)
        ros = stack.enter_context(RosNode("odometry_node", needs=("tf2_msgs.msg",)))
        node = OdometryNode(ros, config, state)
        report_ready()
        ros.run()
        log.info("%d gaps, %d messages rejected", node.integrator.gaps, node.integrator.rejected)


def _pose_file(path: Path) -> PoseFile:
    try:
        return PoseFile(path)
    except OSError as error:
        raise ConfigError(f"--state {path} cannot be written: {error.strerror}") from error


if __name__ == "__main__":
    main()

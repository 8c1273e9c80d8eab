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
from typing import Any

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
from target_nav.nav.odometry import OdometryIntegrator, OdometryNoise, OdometryScale
from target_nav.state.types import Twist2D

RAW_DEPTH = 50

log = logging.getLogger(__name__)


def parse_raw(text: str, now_s: float) -> tuple[float, Twist2D]:
    """Stamp and velocity of one message on /arduino/odom_raw.

    Raises:
        BadMessageError: not the arduino node's JSON, a number that is not finite, a stamp far off.
    """
    try:
        data = json.loads(text)
        stamp_s, *values = (float(data[key]) for key in ("stamp_s", "vx_mm", "vy_mm", "wz_mrad"))
    except (ValueError, KeyError, TypeError) as error:
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
    return stamp_s, Twist2D(vx, vy, wz)


class OdometryNode:
    """Everything happens in the executor's thread."""

    def __init__(self, ros: RosNode, config: Config) -> None:
        from nav_msgs.msg import Odometry
        from std_msgs.msg import Empty, String
        from tf2_msgs.msg import TFMessage

        self._ros = ros
        self._tf_message = TFMessage
        calibration = config.odometry
        self._noise = OdometryNoise()
        self.integrator = OdometryIntegrator(
            OdometryScale(calibration.forward_scale, calibration.lateral_scale, calibration.yaw_scale),
            calibration.max_gap_s,
            self._noise,
        )
        self._publish_odometry = ros.publisher(Odometry, "/odom", stream_qos())
        self._publish_tf = ros.publisher(TFMessage, "/tf", tf_qos())
        ros.subscribe(String, "/arduino/odom_raw", self._take_raw, stream_qos(RAW_DEPTH))
        ros.subscribe(Empty, "/reset_odom", self._reset, command_qos())

    def _take_raw(self, message: Any) -> None:
        clock = self._ros.clock
        stamp_s, twist = parse_raw(message.data, clock.now_s())
        odometry = self.integrator.add(stamp_s, twist)
        if odometry is None:
            raise BadMessageError("raw.order", f"the message of {stamp_s:.3f} s came after a newer one")
        if self.integrator.in_gap:
            self._ros.warnings.warn(
                "odometry.gap", "a gap in odometry: the pose may be wrong by what was driven meanwhile"
            )
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
    add_config_arguments(parser)
    arguments = parse_arguments(parser)
    sys.exit(run_process("odometry", lambda: _run(arguments)))


def _run(arguments: argparse.Namespace) -> None:
    with RosNode("odometry_node", needs=("tf2_msgs.msg",)) as ros:
        node = OdometryNode(ros, config_from(arguments))
        report_ready()
        ros.run()
        log.info("%d gaps, %d messages rejected", node.integrator.gaps, node.integrator.rejected)


if __name__ == "__main__":
    main()

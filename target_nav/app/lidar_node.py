"""Process `lidar`: an RPLidar A1 on a serial port to /scan, where rplidar_ros is not installed.

    /scan (sensor_msgs/LaserScan)   best effort, frame laser, stamped with the time of the first beam

The angle increment is negative: the head turns clockwise, and beams are in the order in which they were taken. A LiDAR
that is not there at the start ends the process with code 2; one that is lost later is started again when it is back.
"""

from __future__ import annotations

import argparse
import logging
import sys

from target_nav.app.process import report_ready, run_process
from target_nav.app.ros_convert import scan_to_msg
from target_nav.app.ros_support import RosNode, sensor_qos
from target_nav.app.settings import add_config_arguments, config_from, parse_arguments
from target_nav.config import Config
from target_nav.hardware.rplidar import RpLidar
from target_nav.state.types import Scan

log = logging.getLogger(__name__)


class LidarNode:
    """Wires one LiDAR to one ROS node."""

    def __init__(self, ros: RosNode, config: Config) -> None:
        from sensor_msgs.msg import LaserScan

        self._ros = ros
        self._publish = ros.publisher(LaserScan, "/scan", sensor_qos())
        self.lidar = RpLidar(config.lidar, self._take_scan, self._take_connection)

    def _take_scan(self, scan: Scan) -> None:
        self._publish(scan_to_msg(scan, self._ros.clock))

    def _take_connection(self, connected: bool, reason: str) -> None:
        port = self.lidar.config.port
        if connected:
            log.info("the LiDAR on %s is back", port)
        else:
            log.error("the LiDAR on %s is lost (%s); trying to start it again", port, reason)


def main() -> None:
    parser = argparse.ArgumentParser(prog="lidar_node", description="RPLidar A1: serial port to /scan.")
    parser.add_argument("--port", help="serial port (key lidar.port)")
    parser.add_argument("--wait", type=float, default=5.0, help="seconds to wait for the LiDAR at the start")
    add_config_arguments(parser)
    arguments = parse_arguments(parser)
    sys.exit(run_process("lidar", lambda: _run(arguments)))


def _run(arguments: argparse.Namespace) -> None:
    config = config_from(arguments)
    if arguments.port:
        config = config.override({"lidar.port": arguments.port}, source="--port")
    with RosNode("lidar_node") as ros:
        lidar = LidarNode(ros, config).lidar
        lidar.open(wait_s=arguments.wait)
        try:
            assert lidar.info is not None
            log.info(
                "RPLidar model %d, firmware %s, serial number %s on %s",
                lidar.info.model, lidar.info.firmware, lidar.info.serial_number, config.lidar.port,
            )  # fmt: skip
            report_ready()
            ros.run(check=lidar.raise_failure)
        finally:
            lidar.close()
            log.info("%s", lidar.statistics)


if __name__ == "__main__":
    main()

"""Process `arduino`: /cmd_vel and /arduino/cmd to the serial port, the firmware's odometry to /arduino/odom_raw.

    /cmd_vel (geometry_msgs/Twist)        velocity of base_link, sent on at once and refreshed at 20 Hz
    /arduino/cmd (std_msgs/String)        a position command in the firmware's words, STOP or VERSION
    /arduino/odom_raw (std_msgs/String)   JSON: stamp_s (monotonic, when the line came), vx_mm, vy_mm, wz_mrad, and
                                          device_us (the firmware's clock) where it tells

A port that is not there at the start ends the process with code 2. A port that is lost later is opened again as soon
as it is back; until then the firmware's own watchdog has stopped the wheels. After each opening the firmware is asked
for its version first: one that speaks another protocol ends the process with code 2.
"""

from __future__ import annotations

import argparse
import json
import logging
import sys
import threading
from typing import Any

from target_nav.app.process import report_ready, run_process
from target_nav.app.ros_convert import BadMessageError, twist_from_msg
from target_nav.app.ros_support import RosNode, command_qos, stream_qos
from target_nav.app.settings import add_config_arguments, config_from, parse_arguments
from target_nav.config import Config
from target_nav.errors import DeviceError
from target_nav.hardware.arduino_bridge import ArduinoBridge
from target_nav.hardware.drive_arbiter import DriveArbiter
from target_nav.hardware.firmware_check import FirmwareCheck
from target_nav.hardware.protocol import DeviceLine, ErrorLine, OdomLine, VersionLine, encode_stop

REFRESH_PERIOD_S = 0.02
"""A velocity is sent again at 20 Hz; how old it is, is looked at more often. By the main thread: a ROS timer would wake
the executor 50 times a second, which is most of what this process would cost."""

log = logging.getLogger(__name__)


class ArduinoNode:
    """Wires one bridge to one ROS node. Messages come in the executor's thread, lines in the bridge's, and `refresh` is
    the main thread's."""

    def __init__(self, ros: RosNode, config: Config) -> None:
        from geometry_msgs.msg import Twist
        from std_msgs.msg import String

        self._ros = ros
        self._string = String
        self._arbiter = DriveArbiter(config.robot, config.serial)
        self._deciding = threading.Lock()
        """Held from the arbiter's answer until it is sent: what was decided first goes out first."""
        self._firmware = FirmwareCheck()
        self._silence_told = False
        self._stale_s, self._timeout_s = config.serial.cmd_vel_stale_s, config.serial.cmd_vel_timeout_s
        self._publish_odometry = ros.publisher(String, "/arduino/odom_raw", stream_qos())
        self.bridge = ArduinoBridge(
            config.serial.port, config.serial.baud, self._take_line, self._take_connection
        )
        ros.subscribe(Twist, "/cmd_vel", self._take_velocity, command_qos())
        ros.subscribe(String, "/arduino/cmd", self._take_command, command_qos())

    def _take_velocity(self, message: Any) -> None:
        try:
            twist = twist_from_msg(message)
        except BadMessageError:
            with self._deciding:
                self._send(self._arbiter.halt())
            raise
        with self._deciding:
            self._send(self._arbiter.velocity(self._ros.clock.now_s(), twist))

    def _take_command(self, message: Any) -> None:
        with self._deciding:
            try:
                line = self._arbiter.command(self._ros.clock.now_s(), message.data)
            except DeviceError as error:
                raise BadMessageError("command", str(error)) from error
            self._send(line)
        log.info("command %s", message.data.strip())

    def refresh(self) -> None:
        """What is due by now without being asked for; to be called every REFRESH_PERIOD_S."""
        self._ask_version()
        timeouts, stale = self._arbiter.timeouts, self._arbiter.stale
        with self._deciding:
            self._send(self._arbiter.refresh(self._ros.clock.now_s()))
        if self._arbiter.timeouts > timeouts:
            log.warning("no /cmd_vel for %.1f s: STOP", self._timeout_s)
        elif self._arbiter.stale > stale:
            log.warning("no /cmd_vel for %.1f s: zero velocity", self._stale_s)

    def _ask_version(self) -> None:
        if not self.bridge.connected:
            return
        question = self._firmware.poll(self._ros.clock.now_s())
        if question:
            self.bridge.send(question)
        if self._firmware.silent and not self._silence_told:
            self._silence_told = True
            log.error(
                "the firmware on %s does not answer VERSION: it is not this project's, or an old one; it is driven all "
                "the same. Flash it: make -C deploy/firmware flash PORT=%s", self.bridge.port, self.bridge.port,
            )  # fmt: skip

    def _send(self, line: bytes) -> None:
        if line and line != encode_stop() and not self._firmware.may_drive:
            self._ros.warnings.warn("serial.version", "the firmware has not told its version yet: not driven")
            return
        if line and not self.bridge.send(line):
            self._ros.warnings.warn("serial.write", f"{self.bridge.port} took no command: lost or stuck")

    def _take_line(self, line: DeviceLine, stamp_s: float) -> None:
        if isinstance(line, OdomLine):
            data: dict[str, float] = {
                "stamp_s": round(stamp_s, 6),
                "vx_mm": line.vx_mmps,
                "vy_mm": line.vy_mmps,
                "wz_mrad": line.wz_mradps,
            }
            if line.device_us is not None:
                data["device_us"] = line.device_us
            self._publish_odometry(self._string(data=json.dumps(data)))
        elif isinstance(line, VersionLine):
            self._firmware.take(line, self.bridge.port)
            log.info("firmware %s, protocol %d", line.firmware, line.protocol)
        elif isinstance(line, ErrorLine):
            self._ros.warnings.warn(f"firmware.{line.code}", f"firmware: {line.code} {line.text}")

    def _take_connection(self, connected: bool, reason: str) -> None:
        if connected:
            log.info("%s is back", self.bridge.port)
        else:
            # With the loss, not with the return: who comes back is not known before it was asked.
            self._firmware.restart()
            self._silence_told = False
            log.error("%s lost (%s); trying to open it again", self.bridge.port, reason)


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="arduino_node", description="Drivetrain: /cmd_vel to serial and back."
    )
    parser.add_argument("--port", help="serial port (key serial.port)")
    parser.add_argument("--wait", type=float, default=5.0, help="seconds to wait for the port at the start")
    add_config_arguments(parser)
    arguments = parse_arguments(parser)
    sys.exit(run_process("arduino", lambda: _run(arguments)))


def _run(arguments: argparse.Namespace) -> None:
    config = config_from(arguments)
    if arguments.port:
        config = config.override({"serial.port": arguments.port}, source="--port")
    with RosNode("arduino_node") as ros:
        node = ArduinoNode(ros, config)
        bridge = node.bridge
        bridge.open(wait_s=arguments.wait)
        try:
            log.info("%s open at %d baud", bridge.port, bridge.baud)
            report_ready()
            ros.start()
            while not ros.stop.wait(REFRESH_PERIOD_S):
                node.refresh()
                ros.check()
                bridge.raise_failure()
            ros.check()
        finally:
            bridge.close()
            log.info("%s", bridge.statistics)


if __name__ == "__main__":
    main()

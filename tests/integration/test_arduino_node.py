"""The arduino node as a real process, with a scripted firmware at the other end of a pty: what goes over the wire."""

from __future__ import annotations

import json
import os
import select
import threading
import time
import tty
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from target_nav.app.ros_convert import twist_to_msg
from target_nav.app.ros_support import RosNode, command_qos, stream_qos
from target_nav.hardware.protocol import LineAssembler
from target_nav.state.types import Twist2D
from tests.utils.processes import Managed, ros_environment, running, wait_until

pytestmark = [pytest.mark.ros, pytest.mark.linux, pytest.mark.slow]

MODULE = "target_nav.app.arduino_node"


class Wire:
    """Hears every line the node sends, with its time, and answers VERSION as `version` says."""

    def __init__(self, link: Path) -> None:
        self.link = link
        self.version = b"VERSION,1,9.9.9\n"
        self.asked = 0
        self.heard: list[tuple[float, bytes]] = []
        self.plug_in()

    def plug_in(self) -> None:
        self.master, self.slave = os.openpty()
        tty.setraw(self.slave)
        self.link.symlink_to(os.ttyname(self.slave))
        self._unplugged = threading.Event()
        self._listener = threading.Thread(target=self._listen)
        self._listener.start()

    def unplug(self) -> None:
        self.link.unlink()
        # A port is only gone for the other side once nobody reads from it here.
        self._unplugged.set()
        self._listener.join()
        os.close(self.slave)
        os.close(self.master)

    def say(self, data: bytes) -> None:
        os.write(self.master, data)

    def lines(self) -> list[bytes]:
        return [line for _, line in list(self.heard)]

    def _listen(self) -> None:
        lines = LineAssembler()
        while not self._unplugged.is_set():
            if select.select([self.master], [], [], 0.02)[0]:
                data = os.read(self.master, 4096)
                for line in lines.feed(data):
                    if line == b"VERSION":
                        self.asked += 1
                        self.say(self.version)
                    else:
                        self.heard.append((time.monotonic(), line))


class Host:
    """The ROS side: publishes to the node, keeps what it publishes."""

    def __init__(self, ros: RosNode) -> None:
        from geometry_msgs.msg import Twist
        from std_msgs.msg import String

        self.ros = ros
        self.raw: list[dict[str, Any]] = []
        self._string = String
        self._send = ros.publisher(Twist, "/cmd_vel", command_qos())
        self._command = ros.publisher(String, "/arduino/cmd", command_qos())
        ros.subscribe(
            String, "/arduino/odom_raw", lambda m: self.raw.append(json.loads(m.data)), stream_qos()
        )
        ros.start()
        wait_until(self._is_connected, "discovery")

    def drive(self, twist: Twist2D) -> None:
        self._send(twist_to_msg(twist))

    def command(self, text: str) -> None:
        self._command(self._string(data=text))

    def _is_connected(self) -> bool:
        node = self.ros.node
        topics = ("/cmd_vel", "/arduino/cmd")
        return all(node.count_subscribers(topic) for topic in topics) and node.count_publishers(
            "/arduino/odom_raw"
        )


@pytest.fixture
def wire(tmp_path: Path) -> Iterator[Wire]:
    ros_environment()
    wire = Wire(tmp_path / "arduino")
    yield wire
    wire.unplug()


@pytest.fixture
def node(wire: Wire, tmp_path: Path) -> Iterator[Managed]:
    with running(MODULE, "--port", str(wire.link), folder=tmp_path) as managed:
        wait_until(lambda: "firmware 9.9.9, protocol 1" in managed.log(), "the firmware's version")
        yield managed


@pytest.fixture
def host(node: Managed) -> Iterator[Host]:
    with RosNode("test_host") as ros:
        yield Host(ros)


def test_a_velocity_is_sent_refreshed_and_ended_by_one_stop(wire: Wire, host: Host) -> None:
    host.drive(Twist2D(0.2, 0.0, 0.3))
    wait_until(lambda: b"STOP" in wire.lines(), "STOP after the velocities ceased")
    time.sleep(0.3)
    velocities = [t for t, line in wire.heard if line == b"VEL,200,0,300"]
    stops = [t for t, line in wire.heard if line == b"STOP"]
    assert len(velocities) >= 3
    assert len(stops) == 1
    assert list(dict.fromkeys(wire.lines())) == [b"VEL,200,0,300", b"VEL,0,0,0", b"STOP"]
    # Half a second, and what the timer and a busy machine add.
    assert 0.45 < stops[0] - velocities[0] < 1.5


def test_a_velocity_beyond_the_limits_is_scaled(wire: Wire, host: Host) -> None:
    host.drive(Twist2D(3.0, 0.0, 1.0))
    wait_until(lambda: bool(wire.lines()), "a velocity")
    assert wire.lines()[0] == b"VEL,300,0,100"


def test_a_velocity_that_is_not_finite_stops_at_once(wire: Wire, host: Host, node: Managed) -> None:
    host.drive(Twist2D(0.2, 0.0, 0.0))
    wait_until(lambda: bool(wire.lines()), "a velocity")
    host.drive(Twist2D(float("nan"), 0.0, 0.0))
    wait_until(lambda: b"STOP" in wire.lines(), "STOP")
    assert "no /cmd_vel" not in node.log()
    wait_until(lambda: "is not finite; message dropped" in node.log(), "a warning")
    assert node.process.poll() is None


def test_a_position_command_passes_and_nonsense_does_not(wire: Wire, host: Host, node: Managed) -> None:
    host.command("HOP,1")
    wait_until(lambda: "not a command of the firmware" in node.log(), "a warning")
    host.command("FWD,100,1719")
    wait_until(lambda: bool(wire.lines()), "the command")
    assert wire.lines() == [b"FWD,100,1719"]


def test_odometry_lines_are_published_with_the_time_they_came(wire: Wire, host: Host) -> None:
    before_s = time.monotonic()
    wire.say(b"garbage\xff\nENC,1,2,3,4\nODOM,100,-5,30\n")
    wait_until(lambda: bool(host.raw), "odometry")
    message = host.raw[0]
    assert before_s <= message.pop("stamp_s") <= time.monotonic()
    assert message == {"vx_mm": 100, "vy_mm": -5, "wz_mrad": 30}


def test_what_the_firmware_complains_of_is_in_the_log(wire: Wire, host: Host, node: Managed) -> None:
    wire.say(b"ERROR,STALL,FL does not turn\n")
    wait_until(lambda: "firmware: STALL FL does not turn" in node.log(), "the firmware's error")


def test_a_pulled_cable_is_reported_and_put_right(wire: Wire, host: Host, node: Managed) -> None:
    wire.unplug()
    wait_until(lambda: "trying to open it again" in node.log(), "the loss")
    wire.plug_in()
    wait_until(lambda: node.log().count("firmware 9.9.9, protocol 1") == 2, "the return")
    host.drive(Twist2D(0.1, 0.0, 0.0))
    wait_until(lambda: b"VEL,100,0,0" in wire.lines(), "a velocity")


def test_a_firmware_of_another_protocol_is_refused(wire: Wire, tmp_path: Path) -> None:
    wire.version = b"VERSION,7,3.0.0\n"
    refused = Managed(MODULE, ["--port", str(wire.link)], tmp_path)
    assert refused.wait() == 2
    assert "(version 3.0.0) speaks protocol 7, this program 1" in refused.log()
    assert "Traceback" not in refused.log()
    assert not [line for line in wire.lines() if line != b"STOP"]


def test_a_firmware_that_does_not_tell_its_version_is_driven_with_a_warning(
    wire: Wire, tmp_path: Path
) -> None:
    wire.version = b"ERROR,BADCMD,VERSION\n"
    with running(MODULE, "--port", str(wire.link), folder=tmp_path) as node, RosNode("test_host") as ros:
        host = Host(ros)
        host.drive(Twist2D(0.1, 0.0, 0.0))
        wait_until(lambda: "does not answer VERSION" in node.log(), "the warning")
        assert wire.lines() == [b"STOP"] or not wire.lines()
        assert wire.asked > 1
        host.drive(Twist2D(0.1, 0.0, 0.0))
        wait_until(lambda: b"VEL,100,0,0" in wire.lines(), "a velocity")


def test_the_robot_is_stopped_when_the_node_is_asked_to_end(wire: Wire, node: Managed) -> None:
    assert node.end() == 0
    wait_until(lambda: wire.lines()[-1:] == [b"STOP"], "STOP")


def test_a_port_that_is_not_there_is_an_error_that_helps(tmp_path: Path) -> None:
    missing = Managed(MODULE, ["--port", str(tmp_path / "ttyACM9"), "--wait", "0"], tmp_path)
    assert missing.wait() == 2
    assert "there is no serial port" in missing.log()
    assert "Traceback" not in missing.log()


def test_a_second_node_on_the_port_is_refused(wire: Wire, node: Managed, tmp_path: Path) -> None:
    folder = tmp_path / "second"
    folder.mkdir()
    second = Managed(MODULE, ["--port", str(wire.link), "--wait", "0"], folder)
    assert second.wait() == 2
    assert "is in use" in second.log()
    assert node.process.poll() is None

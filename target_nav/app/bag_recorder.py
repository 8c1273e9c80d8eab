"""Process `recorder`: ROS topics into a bag that `ros2 bag` and Foxglove read, also where neither is installed.

    python -m target_nav.app.bag_recorder --output runs/bag                     the topics of this stack
    python -m target_nav.app.bag_recorder --output runs/bag --topics /scan /tf

Topics are taken as their publishers appear, with the quality of service these offer. Messages are not decoded; a thread
of its own compresses and writes them.
"""

from __future__ import annotations

import argparse
import itertools
import logging
import os
import queue
import sys
import threading
import time
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from target_nav.app.bag_writer import BagWriter, OfferedQos
from target_nav.app.message_definitions import Definition, MessageDefinitions, share_folders
from target_nav.app.process import report_ready, run_process
from target_nav.app.ros_support import RosNode
from target_nav.app.settings import add_config_arguments, config_from, parse_arguments
from target_nav.errors import DeviceError, TargetNavError

STACK_TOPICS = (
    "/scan",
    "/odom",
    "/cmd_vel",
    "/tf",
    "/tf_static",
    "/nav_state",
    "/arduino/odom_raw",
    "/arduino/cmd",
    "/reset_odom",
    "/robot_description",
)

LOOK_PERIOD_S = 0.25
FLUSH_PERIOD_S = 1.0
WAITING = 1000
"""Messages of one topic that DDS keeps for a recorder that is busy."""

log = logging.getLogger(__name__)


class BagRecorder:
    """Subscribes to topics as they appear and writes what comes. Use as a context manager, or call `close`."""

    def __init__(
        self, ros: RosNode, bag: BagWriter, topics: Sequence[str], definitions: MessageDefinitions
    ) -> None:
        self._ros, self._bag = ros, bag
        self._definitions = definitions
        self._waiting_for = list(topics)
        self._queue: queue.Queue[tuple[str, bytes, int, int] | None] = queue.Queue()
        self._new: queue.Queue[tuple[str, Definition, list[OfferedQos]]] = queue.Queue()
        self._failure: BaseException | None = None
        self._thread = threading.Thread(target=self._write_all, name="bag writer", daemon=True)
        self._thread.start()
        ros.every(LOOK_PERIOD_S, self._look)

    def check(self) -> None:
        """Raise what ended the writer, if something did (a full disk)."""
        if self._failure is not None:
            raise self._failure

    def close(self) -> None:
        """Write what is still waiting, and the file's end."""
        self._queue.put(None)
        self._thread.join()
        self._bag.close()

    def __enter__(self) -> BagRecorder:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _look(self) -> None:
        for topic in tuple(self._waiting_for):
            publishers = self._ros.node.get_publishers_info_by_topic(topic)
            # An endpoint is discovered before its type is known.
            if publishers and publishers[0].topic_type:
                self._waiting_for.remove(topic)
                self._take_up(topic, publishers)

    def _take_up(self, topic: str, publishers: Sequence[Any]) -> None:
        type_name: str = publishers[0].topic_type
        try:
            definition = self._definitions.of(type_name)
            message_type = message_class(type_name)
        except TargetNavError as error:
            log.error("%s is not recorded: %s", topic, error)
            return
        self._new.put((topic, definition, [offered_qos(info.qos_profile) for info in publishers]))

        def take(data: bytes, info: Any) -> None:
            received_ns = time.time_ns()
            self._queue.put((topic, data, received_ns, info["source_timestamp"] or received_ns))

        self._ros.node.create_subscription(message_type, topic, take, subscription_qos(publishers), raw=True)
        log.info("recording %s (%s)", topic, type_name)

    def _write_all(self) -> None:
        flush_s = time.monotonic() + FLUSH_PERIOD_S
        try:
            while (item := self._queue.get()) is not None:
                self._announce()
                self._bag.write(*item)
                if time.monotonic() > flush_s:
                    self._bag.flush()
                    flush_s = time.monotonic() + FLUSH_PERIOD_S
            self._announce()
        except BaseException as error:
            self._failure = error
            # What comes now is lost, but it shall not pile up.
            while self._queue.get() is not None:
                continue

    def _announce(self) -> None:
        while not self._new.empty():
            self._bag.add_topic(*self._new.get())


def free_folder(wanted: Path) -> Path:
    """`wanted`, or with a number behind it when it exists: a recorder that is started again begins a new bag."""
    numbered = (wanted.with_name(f"{wanted.name}-{n}") for n in itertools.count(1))
    return next(path for path in itertools.chain((wanted,), numbered) if not path.exists())


def message_class(type_name: str) -> Any:
    """The message's class, for `sensor_msgs/msg/LaserScan`.

    Raises:
        DeviceError: its package is not installed.
    """
    package, _, name = type_name.split("/")
    try:
        return getattr(import_module(f"{package}.msg"), name)
    except (ImportError, AttributeError) as error:
        raise DeviceError(f"{type_name} is not installed here ({error})") from error


def subscription_qos(publishers: Sequence[Any]) -> Any:
    """What all of these publishers can serve: reliable if all are, latched if all are (as rosbag2 does)."""
    from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

    reliable = all(i.qos_profile.reliability is ReliabilityPolicy.RELIABLE for i in publishers)
    latched = all(i.qos_profile.durability is DurabilityPolicy.TRANSIENT_LOCAL for i in publishers)
    return QoSProfile(
        depth=WAITING,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )


def offered_qos(profile: Any) -> OfferedQos:
    """A publisher's rclpy QoSProfile in the words of a bag."""
    return OfferedQos(
        reliability=profile.reliability.short_key,
        durability=profile.durability.short_key,
        history=profile.history.short_key,
        depth=profile.depth,
        liveliness=profile.liveliness.short_key,
        deadline_ns=profile.deadline.nanoseconds,
        lifespan_ns=profile.lifespan.nanoseconds,
        liveliness_lease_ns=profile.liveliness_lease_duration.nanoseconds,
    )


def main() -> None:
    parser = argparse.ArgumentParser(prog="bag_recorder", description="Records ROS topics into a bag (MCAP).")
    parser.add_argument("--output", metavar="FOLDER", type=Path, required=True, help="of the bag; made anew")
    parser.add_argument("--topics", nargs="+", default=STACK_TOPICS, help="instead of those of this stack")
    add_config_arguments(parser)
    arguments = parse_arguments(parser)
    sys.exit(run_process("recorder", lambda: _run(arguments)))


def _run(arguments: argparse.Namespace) -> None:
    config_from(arguments)
    with RosNode("bag_recorder") as ros:
        bag = BagWriter(free_folder(arguments.output), os.environ.get("ROS_DISTRO", "jazzy"))
        with BagRecorder(ros, bag, arguments.topics, MessageDefinitions(share_folders())) as recorder:
            report_ready()
            ros.run(check=recorder.check)
        log.info(
            "%s: %s", bag.path, ", ".join(f"{n} of {topic}" for topic, n in bag.counts.items()) or "nothing"
        )


if __name__ == "__main__":
    main()

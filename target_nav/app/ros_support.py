"""ROS 2 wiring that every node shares: start and end, a background executor, QoS, timers that no clock step
disturbs.

Importable without ROS; what needs it says so. Conversions are in `ros_convert`, time in `ros_clock`.
"""

from __future__ import annotations

import logging
import sys
import threading
from collections.abc import Callable
from importlib import import_module
from types import TracebackType
from typing import Any

from target_nav.app.logs import CountedWarnings
from target_nav.app.process import StopSignal
from target_nav.app.ros_clock import RosClock
from target_nav.app.ros_convert import BadMessageError
from target_nav.errors import DeviceError

log = logging.getLogger(__name__)


def require_ros(*more: str) -> None:
    """Raise a DeviceError that says what to do, unless rclpy, the common messages and `more` can be imported."""
    try:
        for name in ("rclpy", "std_msgs.msg", "geometry_msgs.msg", "nav_msgs.msg", "sensor_msgs.msg", *more):
            import_module(name)
    except ImportError as error:
        raise DeviceError(
            f"ROS 2 cannot be imported by {sys.executable} ({error}); on a robot: source "
            "/opt/ros/jazzy/setup.bash first; on a desk: scripts/start.sh --sim sets it up in .venv"
        ) from error


def sensor_qos() -> Any:
    """Sensor data, of which the newest counts: best effort, depth 5."""
    from rclpy.qos import qos_profile_sensor_data

    return qos_profile_sensor_data


def command_qos() -> Any:
    """Commands: reliable, and only the newest counts."""
    from rclpy.qos import QoSProfile, ReliabilityPolicy

    return QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)


def stream_qos(depth: int = 10) -> Any:
    """Streams whose every message counts: reliable, which subscribers of either kind can read."""
    from rclpy.qos import QoSProfile, ReliabilityPolicy

    return QoSProfile(depth=depth, reliability=ReliabilityPolicy.RELIABLE)


def tf_qos() -> Any:
    """`/tf`, as tf2 has it."""
    return stream_qos(depth=100)


def latched_qos() -> Any:
    """`/tf_static` and what a late subscriber must still get: reliable, transient local, depth 1."""
    from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

    return QoSProfile(
        depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL
    )


class RosNode:
    """A node with its own context and an executor in a background thread, as a `with` block.

    An error in a callback ends the process: the executor stops, and `check` or `run` raises it in the main
    thread. A message that a callback refuses with BadMessageError is counted in `warnings` and dropped.

    Args:
        name: the node's name.
        needs: message packages beyond the common ones, as `tf2_msgs.msg`.
    """

    def __init__(self, name: str, needs: tuple[str, ...] = ()) -> None:
        require_ros(*needs)
        self.name = name
        self.stop = StopSignal()
        self.warnings = CountedWarnings(log)
        self.clock = RosClock(on_step=self._warn_of_step)
        self._failure: BaseException | None = None
        self._thread: threading.Thread | None = None

    def __enter__(self) -> RosNode:
        import rclpy
        from rclpy.context import Context
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.node import Node
        from rclpy.signals import SignalHandlerOptions

        self.stop.__enter__()
        self._context = Context()
        # Signals are this process's own business: rclpy's handler would end the context under a running
        # publisher.
        rclpy.init(context=self._context, signal_handler_options=SignalHandlerOptions.NO)
        self.node: Any = Node(self.name, context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._executor.shutdown(timeout_sec=1.0)
        if self._thread is not None:
            self._thread.join(timeout=1.0)
        self.node.destroy_node()
        self._context.try_shutdown()
        self.stop.__exit__(kind, error, trace)

    def subscribe(self, message_type: Any, topic: str, callback: Callable[[Any], None], qos: Any) -> None:
        """Call `callback` in the executor's thread with every message of a topic."""

        def take(message: Any) -> None:
            try:
                callback(message)
            except BadMessageError as bad:
                self.warnings.warn(f"{topic} {bad.kind}", f"{topic}: {bad}; message dropped")

        self.node.create_subscription(message_type, topic, take, qos)

    def publisher(self, message_type: Any, topic: str, qos: Any) -> Callable[[Any], None]:
        """A function that publishes one message. It may be called from any thread."""
        publish: Callable[[Any], None] = self.node.create_publisher(message_type, topic, qos).publish
        return publish

    def every(self, period_s: float, callback: Callable[[], None]) -> None:
        """Call `callback` in the executor's thread every `period_s`, whatever becomes of the wall clock."""
        from rclpy.clock import Clock, ClockType

        self.node.create_timer(period_s, callback, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def start(self) -> None:
        """Start the executor's thread. Publishers and subscriptions are made before."""
        self._thread = threading.Thread(target=self._spin, name=f"{self.name} executor", daemon=True)
        self._thread.start()

    def check(self) -> None:
        """Raise what ended the executor, if something did."""
        if self._failure is not None:
            raise self._failure

    def run(self, check: Callable[[], None] | None = None) -> None:
        """Start, and block until a signal asks to stop; `check` is called ten times a second."""
        self.start()
        while not self.stop.wait(0.1):
            self.check()
            if check is not None:
                check()
        self.check()

    def _spin(self) -> None:
        from rclpy.executors import ExternalShutdownException

        try:
            self._executor.spin()
        except ExternalShutdownException:
            pass
        except BaseException as error:
            self._failure = error
            self.stop.request()

    def _warn_of_step(self, step_s: float) -> None:
        self.warnings.warn("clock.step", f"the wall clock was set by {step_s:+.3f} s; stamps follow it")

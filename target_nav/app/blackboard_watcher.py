"""`py-trees-blackboard-watcher` for where py_trees_ros is not installed: the same name, options and streams.

    py-trees-blackboard-watcher --list              the names of all entries
    py-trees-blackboard-watcher                     the whole board, whenever something on it changes
    py-trees-blackboard-watcher track.x_m           some of it; names may be nested
    py-trees-blackboard-watcher --visited --activity

Where py_trees_ros is installed its own command runs.
"""

from __future__ import annotations

import argparse
import sys

from py_trees import console

from target_nav.app.process import run_process
from target_nav.app.ros_support import RosNode, latched_qos
from target_nav.app.watcher_support import call, find_service, hand_over

NAME = "py-trees-blackboard-watcher"
LIST_TYPE = "py_trees_ros_interfaces/srv/GetBlackboardVariables"
OPEN_TYPE = "py_trees_ros_interfaces/srv/OpenBlackboardStream"


def main() -> None:
    hand_over("blackboard_watcher")
    arguments = parser().parse_args()
    sys.exit(run_process(NAME, lambda: _run(arguments)))


def parser() -> argparse.ArgumentParser:
    made = argparse.ArgumentParser(
        prog=NAME,
        description="Shows the blackboard of a running tree, all of it or some, whenever it changes.",
    )
    made.add_argument("-l", "--list", action="store_true", help="the names of the entries, and nothing else")
    made.add_argument(
        "-a", "--activity", action="store_true", help="with what was done to them in the last tick"
    )
    made.add_argument("-v", "--visited", action="store_true", help="only what the last tick's behaviours use")
    made.add_argument(
        "-n", "--namespace", nargs="?", default=None, help="of the executor, if there are several"
    )
    made.add_argument(
        "variables", nargs=argparse.REMAINDER, help="entries, also nested ones: /target/track.x_m"
    )
    return made


def _run(arguments: argparse.Namespace) -> int:
    from py_trees_ros_interfaces.srv import (
        CloseBlackboardStream,
        GetBlackboardVariables,
        OpenBlackboardStream,
    )
    from std_msgs.msg import String

    namespace = arguments.namespace or ""
    with RosNode("blackboard_watcher", needs=("py_trees_ros_interfaces.srv",)) as ros:
        ros.start()
        if arguments.list:
            name = find_service(ros, LIST_TYPE, namespace)
            print(
                names_text(
                    call(ros, GetBlackboardVariables, name, GetBlackboardVariables.Request()).variables
                )
            )
            return 0
        name = find_service(ros, OPEN_TYPE, namespace)
        request = OpenBlackboardStream.Request(
            variables=[variable.strip(",[]") for variable in arguments.variables],
            filter_on_visited_path=arguments.visited,
            with_activity_stream=arguments.activity,
        )
        topic = call(ros, OpenBlackboardStream, name, request).topic
        ros.node.create_subscription(
            String, topic, lambda message: print(message.data, flush=True), latched_qos()
        )
        while not ros.stop.wait(0.1):
            ros.check()
        close = f"{name.rsplit('/', 1)[0]}/close"
        if ros.node.count_publishers(topic):
            call(ros, CloseBlackboardStream, close, CloseBlackboardStream.Request(topic_name=topic))
    return 0


def names_text(variables: list[str]) -> str:
    """One line a name; fields stand below what they are of."""
    lines = [f"{console.bold}{console.cyan}Blackboard Variables:{console.reset}"]
    for variable in variables:
        *outer, last = variable.split(".")
        lines.append(f"    {'    ' * len(outer)}{console.yellow}{'.' if outer else ''}{last}{console.reset}")
    return "\n".join(lines)


if __name__ == "__main__":
    main()

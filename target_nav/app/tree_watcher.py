"""`py-trees-tree-watcher` for where py_trees_ros is not installed: the same name, options and streams.

    py-trees-tree-watcher               the tree whenever it changes
    py-trees-tree-watcher -b -a -s      with blackboard, activity and statistics, every two seconds at least
    py-trees-tree-watcher /tree/snapshots    a stream that is there already
    py-trees-tree-watcher --dot-graph   the tree as a graph, once

Where py_trees_ros is installed its own command runs. Unlike that one it waits for an executor that is started anew.
"""

from __future__ import annotations

import argparse
import math
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any
from uuid import UUID

from py_trees import console, display
from py_trees.common import Status

from target_nav.app.process import run_process
from target_nav.app.ros_support import RosNode
from target_nav.app.stream_names import ONLY_ON_CHANGE
from target_nav.app.watcher_support import find_service, hand_over
from target_nav.app.watcher_tree import BrokenTreeError, tree_of

NAME = "py-trees-tree-watcher"
BUSY_PERIOD_S = 2.0
"""As py_trees_ros: so often at least when more than the tree is shown."""
WIDTH = 80


def main() -> None:
    hand_over("tree_watcher")
    arguments = parser().parse_args()
    sys.exit(run_process(NAME, lambda: _run(arguments)))


def parser() -> argparse.ArgumentParser:
    made = argparse.ArgumentParser(
        prog=NAME,
        description="Shows a running tree: as text whenever it changes, or once as a graph.",
        epilog="Looks for the executor by itself; with several, name one by --namespace-hint.",
    )
    made.add_argument(
        "topic_name", nargs="?", help="a snapshot stream that is there; otherwise one is opened"
    )
    made.add_argument(
        "-n", "--namespace-hint", nargs="?", default=None, help="of the executor, if there are several"
    )
    made.add_argument(
        "-a", "--blackboard-activity", action="store_true", help="what was done to the blackboard"
    )
    made.add_argument("-b", "--blackboard-data", action="store_true", help="the entries of the visited path")
    made.add_argument(
        "-s", "--statistics", action="store_true", help="how long ticks take, and how far they are apart"
    )
    mode = made.add_mutually_exclusive_group()
    mode.add_argument(
        "--snapshots", dest="mode", action="store_const", const="snapshots", help="text (the default)"
    )
    mode.add_argument("--dot-graph", dest="mode", action="store_const", const="dot", help="a graph, once")
    made.set_defaults(mode="snapshots")
    return made


def _run(arguments: argparse.Namespace) -> int:
    from target_nav.app.tree_client import OPEN_TYPE, TreeClient

    printer = SnapshotPrinter(arguments)
    busy = arguments.statistics or arguments.blackboard_data or arguments.blackboard_activity
    with RosNode("tree_watcher", needs=("py_trees_ros_interfaces.msg",)) as ros:
        if not arguments.topic_name:
            find_service(ros, OPEN_TYPE, arguments.namespace_hint or "")
        client = TreeClient(
            ros.node,
            BUSY_PERIOD_S if busy else ONLY_ON_CHANGE,
            blackboard_data=arguments.blackboard_data,
            blackboard_activity=arguments.blackboard_activity,
            namespace=arguments.namespace_hint or "",
            topic=arguments.topic_name or "",
            on_tree=printer.show,
        )
        ros.every(0.2, client.poll)
        ros.run(lambda: ros.stop.request() if printer.done else None)
        client.close()
    return 0


class SnapshotPrinter:
    """Prints what comes; `done` when nothing more is wanted."""

    def __init__(self, arguments: argparse.Namespace) -> None:
        self._arguments = arguments
        self._previously: dict[UUID, Status] = {}
        self.done = False

    def show(self, message: Any) -> None:
        if self.done:
            return
        try:
            tree = tree_of(message.behaviours)
        except BrokenTreeError as error:
            print(f"{console.red}a snapshot that is no tree: {error}{console.reset}", flush=True)
            return
        if self._arguments.mode == "dot":
            self.done = True
            _draw_graph(tree.root)
            return
        drawn = display.unicode_tree(tree.root, visited=tree.visited, previously_visited=self._previously)
        self._previously = tree.visited
        print(snapshot_text(message, str(drawn), self._arguments), flush=True)


def snapshot_text(message: Any, drawn: str, shown: argparse.Namespace) -> str:
    """One snapshot for the terminal: what changed has a green frame."""
    colour = console.green if message.changed else console.bold
    title = f" tick {message.statistics.count} ".center(WIDTH, "=")
    parts = [f"{colour}{title}{console.reset}", drawn.rstrip("\n")]
    if shown.blackboard_data:
        rows = [(each.key, each.value) for each in message.blackboard_on_visited_path]
        parts += [f"{colour}Blackboard Data{console.reset}", _rows(rows)]
    if shown.blackboard_activity:
        parts.append(f"{colour}Blackboard Activity Stream{console.reset}")
        if message.blackboard_activity:
            text = display.unicode_blackboard_activity_stream(
                message.blackboard_activity, indent=0, show_title=False
            )
            parts.append(str(text).rstrip("\n"))
        else:
            parts.append(_rows([]))
    if shown.statistics:
        parts += [f"{colour}Statistics{console.reset}", _rows(statistics_rows(message.statistics))]
    return "\n".join(parts)


def statistics_rows(s: Any) -> list[tuple[str, str]]:
    return [
        ("Timestamp", f"{s.stamp.sec + 1e-9 * s.stamp.nanosec:.3f}"),
        (
            "Duration",
            f"{1e3 * s.tick_duration:.3f}/{1e3 * s.tick_duration_average:.3f}/"
            f"{1e3 * math.sqrt(max(s.tick_duration_variance, 0.0)):.3f} (ms) [time/avg/stddev]",
        ),
        (
            "Interval",
            f"{s.tick_interval:.3f}/{s.tick_interval_average:.3f}/"
            f"{math.sqrt(max(s.tick_interval_variance, 0.0)):.3f} (s) [time/avg/stddev]",
        ),
    ]


def _rows(rows: list[tuple[str, str]]) -> str:
    width = max((len(key) for key, _ in rows), default=1)
    return "\n".join(
        f"    {console.cyan}{key:<{width}}{console.reset} : {console.yellow}{value}{console.reset}"
        for key, value in rows or [("-", "-")]
    )


def _draw_graph(root: Any) -> None:
    """Files in a folder of their own; shown by xdot where that is installed."""
    folder = Path(tempfile.mkdtemp(prefix="tree_watcher_"))
    graph = display.dot_tree(root)
    dot = folder / "tree.dot"
    dot.write_text(graph.to_string(), encoding="utf-8")
    print(dot, flush=True)
    if shutil.which("dot"):
        subprocess.run(["dot", "-Tsvg", str(dot), "-o", str(dot.with_suffix(".svg"))], check=False)
        print(dot.with_suffix(".svg"), flush=True)
    if shutil.which("xdot"):
        subprocess.run(["xdot", str(dot)], check=False)
    else:
        print(graph.to_string(), flush=True)


if __name__ == "__main__":
    main()

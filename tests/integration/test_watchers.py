"""Looking into a running executor: blackboard streams as a stranger sees them, the two commands, and watchers that
hang, die, or outlive the executor.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from tests.utils.processes import Managed, ros_environment, running, wait_until

pytestmark = [pytest.mark.ros, pytest.mark.linux, pytest.mark.slow]
pytest.importorskip("rclpy")
pytest.importorskip("py_trees_ros_interfaces.srv")

from py_trees_ros_interfaces.srv import (  # noqa: E402
    CloseBlackboardStream,
    GetBlackboardVariables,
    OpenBlackboardStream,
)
from std_msgs.msg import String  # noqa: E402

from tests.integration.test_tree_executor import EXECUTOR, LATCHED, Client  # noqa: E402

PREFIX = "test_watchers"
STREAMS = "/tree_executor/blackboard_streams"


@pytest.fixture(scope="module")
def executor(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Managed]:
    with running(EXECUTOR, "--prefix", PREFIX, folder=tmp_path_factory.mktemp("executor")) as process:
        yield process


@pytest.fixture
def client(executor: Managed) -> Iterator[Client]:
    stranger = Client()
    yield stranger
    stranger.close()


def open_board(client: Client, **wanted: Any) -> tuple[str, list[Any]]:
    topic = client.call(OpenBlackboardStream, f"{STREAMS}/open", OpenBlackboardStream.Request(**wanted)).topic
    return topic, client.listen(String, topic, LATCHED)


def rows(message: Any) -> dict[str, str]:
    pairs = (line.partition(" : ") for line in message.data.splitlines() if " : " in line)
    return {name.strip(): value.strip() for name, _, value in pairs}


def test_the_variables_are_all_entries_and_their_fields(client: Client) -> None:
    _, heard = open_board(client, variables=["/clock/now_s"])
    client.spin_until(lambda: heard, "the first tick")
    answer = client.call(GetBlackboardVariables, f"{STREAMS}/get_variables", GetBlackboardVariables.Request())
    assert {"/clock/now_s", "/robot/pose_in_odom", "/robot/pose_in_odom.x_m"} <= set(answer.variables)


def test_a_stream_of_some_entries_follows_their_changes(client: Client) -> None:
    topic, heard = open_board(client, variables=["/clock/now_s", "robot/pose_in_odom.x_m"])
    assert topic.startswith(f"{STREAMS}/_watcher_")
    client.spin_until(lambda: len(heard) > 5, "texts")
    texts = [rows(message) for message in heard]
    assert all(set(each) == {"/clock/now_s", "/robot/pose_in_odom.x_m"} for each in texts)
    assert len({each["/clock/now_s"] for each in texts}) == len(texts), (
        "published when it changes, not otherwise"
    )


def test_an_entry_that_does_not_change_comes_once_also_to_who_comes_later(client: Client) -> None:
    topic, heard = open_board(client, variables=["/command/requested"])
    client.spin_until(lambda: heard, "a text")
    late = client.listen(String, topic, 1)  # does not care for latched messages
    client.spin_until(lambda: late, "a text for the one who came later")
    begin_s = time.monotonic()
    client.spin_until(lambda: time.monotonic() - begin_s > 0.5, "half a second")
    assert [rows(message)["/command/requested"] for message in late] == ["False"]


def test_the_visited_path_and_its_activity(client: Client) -> None:
    _, heard = open_board(client, filter_on_visited_path=True, with_activity_stream=True)
    client.spin_until(lambda: heard and "READ" in heard[-1].data, "activity")
    text = heard[-1].data
    assert "MissionRequested" in text
    assert "/command/requested" in rows(heard[-1])
    assert "/input/scan_age_s" not in rows(heard[-1]), "nobody asks for the scan's age before GO"


def test_a_stream_is_closed_once(client: Client) -> None:
    topic, _ = open_board(client)
    request = CloseBlackboardStream.Request(topic_name=topic)
    assert client.call(CloseBlackboardStream, f"{STREAMS}/close", request).result
    assert not client.call(CloseBlackboardStream, f"{STREAMS}/close", request).result
    client.spin_until(lambda: client.node.count_publishers(topic) == 0, "the publisher to go")


def test_activity_comes_in_snapshots_too_while_somebody_asks_for_it(client: Client) -> None:
    _, plain = client.open_stream(snapshot_period=0.1)
    _, busy = client.open_stream(snapshot_period=0.1, blackboard_activity=True)
    client.spin_until(lambda: busy and busy[-1].blackboard_activity, "activity")
    client.spin_until(lambda: plain, "a plain snapshot")
    assert not plain[-1].blackboard_activity
    kinds = {item.activity_type for item in busy[-1].blackboard_activity}
    assert kinds <= {
        "READ",
        "INITIALISED",
        "WRITE",
        "ACCESSED",
        "ACCESS_DENIED",
        "NO_KEY",
        "NO_OVERWRITE",
        "UNSET",
    }
    assert {"READ", "WRITE"} <= kinds


# -- the commands ------------------------------------------------------------------------------------------------------


def command_of(module: str) -> list[str]:
    """The command of py_trees' name, as a person types it; the module where the project is not installed."""
    command = Path(sys.executable).parent / f"py-trees-{module.replace('_', '-')}"
    return [str(command)] if command.is_file() else [sys.executable, "-m", f"target_nav.app.{module}"]


@contextmanager
def watcher(module: str, *options: str, folder: Path) -> Iterator[tuple[subprocess.Popen[bytes], Path]]:
    out = folder / f"{module}{len(list(folder.iterdir()))}.txt"
    with out.open("wb") as stream:
        process = subprocess.Popen(
            [*command_of(module), *options],
            stdout=stream,
            stderr=subprocess.STDOUT,
            env=ros_environment(),
        )
    try:
        yield process, out
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGCONT)
            process.send_signal(signal.SIGINT)
            process.wait(20.0)


def text_of(path: Path) -> str:
    return path.read_text(encoding="utf-8", errors="replace")


def test_the_tree_watcher_shows_the_tree_once_while_nothing_changes(
    executor: Managed, tmp_path: Path
) -> None:
    with watcher("tree_watcher", folder=tmp_path) as (process, out):
        wait_until(lambda: "waiting for GO" in text_of(out), "the tree")
        time.sleep(1.0)
    assert process.returncode == 0
    assert text_of(out).count("Bowling pin") == 1
    wait_until(lambda: "closed stream" in executor.log().splitlines()[-1], "the stream to be closed", 5.0)


def test_the_tree_watcher_shows_blackboard_activity_and_statistics(executor: Managed, tmp_path: Path) -> None:
    with watcher("tree_watcher", "-b", "-a", "-s", folder=tmp_path) as (_, out):
        wait_until(lambda: "Interval" in text_of(out), "statistics")
    text = text_of(out)
    assert "Blackboard Data" in text
    assert "/command/requested : False" in " ".join(text.split())
    assert "Blackboard Activity Stream" in text


def test_the_tree_watcher_draws_a_graph_and_ends(executor: Managed, tmp_path: Path) -> None:
    with watcher("tree_watcher", "--dot-graph", folder=tmp_path) as (process, out):
        assert process.wait(20.0) == 0
    dot = Path(next(line for line in text_of(out).splitlines() if line.endswith(".dot")))
    assert "digraph" in dot.read_text(encoding="utf-8")


def test_the_blackboard_watcher_lists_and_follows(executor: Managed, tmp_path: Path) -> None:
    with watcher("blackboard_watcher", "--list", folder=tmp_path) as (process, out):
        assert process.wait(20.0) == 0
    assert {"/target/track", "/clock/now_s"} <= {line.strip() for line in text_of(out).splitlines()}
    with watcher("blackboard_watcher", "clock/now_s", folder=tmp_path) as (process, out):
        wait_until(lambda: text_of(out).count("/clock/now_s") > 3, "changes")
    assert process.returncode == 0


@pytest.mark.parametrize("module", ["tree_watcher", "blackboard_watcher"])
def test_without_an_executor_a_watcher_says_so(tmp_path: Path, module: str) -> None:
    with watcher(module, "-n", "nobody", folder=tmp_path) as (process, out):
        assert process.wait(30.0) == 2
    assert "with 'nobody' in its name within 5 s; does tree_executor run" in text_of(out)


# -- what goes wrong ---------------------------------------------------------------------------------------------------


def intervals_s(client: Client, heard: list[Any], seconds: float) -> list[float]:
    """Of the ticks in the next seconds, in order of length; at least half of them must be heard of."""
    client.spin_until(lambda: heard, "snapshots")
    heard.clear()
    begin_s = time.monotonic()
    client.spin_until(lambda: time.monotonic() - begin_s > seconds, f"{seconds:g} seconds")
    assert len(heard) >= 0.5 * 20 * seconds
    return sorted(tree.statistics.tick_interval for tree in heard)


def test_a_watcher_that_hangs_delays_nobody(executor: Managed, client: Client, tmp_path: Path) -> None:
    """They are stopped while their streams are open with all there is, every tick; before and then in a pair."""
    _, heard = client.open_stream(snapshot_period=0.05)
    with (
        watcher("tree_watcher", "-a", "-b", "-s", folder=tmp_path) as (hanging, out),
        watcher("blackboard_watcher", folder=tmp_path) as (other, board),
    ):
        wait_until(lambda: "Interval" in text_of(out) and "/clock/now_s" in text_of(board), "both watchers")
        before = intervals_s(client, heard, 3.0)
        for process in (hanging, other):
            os.kill(process.pid, signal.SIGSTOP)
        then = intervals_s(client, heard, 4.0)
        first, last = heard[0].statistics, heard[-1].statistics
        passed_s = (last.stamp.sec - first.stamp.sec) + 1e-9 * (last.stamp.nanosec - first.stamp.nanosec)
        # generous: the machine is shared, and a blocked publisher would show as 100 ms and more, again and again
        assert last.count - first.count >= passed_s * 20 * 0.9
        assert then[int(0.9 * len(then))] < 2.0 * max(before[int(0.9 * len(before))], 0.05)
    # they go on when they are continued, and end in order
    assert (hanging.returncode, other.returncode) == (0, 0)


def test_several_watchers_at_once_each_see_what_they_asked_for(executor: Managed, tmp_path: Path) -> None:
    with (
        watcher("tree_watcher", folder=tmp_path) as (_, plain),
        watcher("tree_watcher", "-b", "-s", folder=tmp_path) as (_, full),
        watcher("tree_watcher", "-a", folder=tmp_path) as (_, busy),
        watcher("blackboard_watcher", "clock/now_s", folder=tmp_path) as (_, board),
    ):
        wait_until(lambda: "waiting for GO" in text_of(plain), "the plain one")
        wait_until(lambda: "Interval" in text_of(full) and "Blackboard Data" in text_of(full), "the full one")
        wait_until(lambda: "Blackboard Activity Stream" in text_of(busy), "the one with activity")
        wait_until(lambda: text_of(board).count("/clock/now_s") > 3, "the board's changes")
    assert "Blackboard" not in text_of(plain)
    assert "Interval" not in text_of(busy)
    assert "Activity" not in text_of(full)


def test_a_watcher_goes_on_after_the_executor_was_started_anew(tmp_path: Path) -> None:
    options = ("--prefix", f"{PREFIX}_restart", "--ros-args", "-r", "__node:=restarted")
    first = Managed(EXECUTOR, options, tmp_path)
    try:
        first.wait_ready()
        with watcher("tree_watcher", "-n", "restarted", "-s", folder=tmp_path) as (_, out):
            wait_until(lambda: "Interval" in text_of(out), "the first executor's tree")
            first.process.kill()
            first.wait()
            shown = text_of(out).count("Interval")
            (tmp_path / "again").mkdir()
            with running(EXECUTOR, *options, folder=tmp_path / "again"):
                wait_until(lambda: text_of(out).count("Interval") > shown + 1, "the second executor's tree")
    finally:
        first.end()

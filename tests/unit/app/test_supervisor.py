"""The supervisor with tiny processes: order, restarts, giving up, logs. Signals and orphans are integration tests."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from target_nav.app.process_spec import NO_RESTART, ProcessSpec, ReadyWhen, RestartPolicy
from target_nav.app.supervised import ProcessState, exit_text
from target_nav.app.supervisor import StackState, Supervisor
from target_nav.errors import DeviceError

pytestmark = pytest.mark.linux

PATIENCE_S = 20.0
QUICK = RestartPolicy(first_delay_s=0.01, max_delay_s=0.02, max_failures=3)


def shell(name: str, script: str, **changes: object) -> ProcessSpec:
    return ProcessSpec(name, ("/bin/sh", "-c", script), **changes)  # type: ignore[arg-type]


SLEEPER = "exec sleep 1000"
REPORTING = 'touch "$TARGET_NAV_READY_FILE"; exec sleep 1000'


def until(supervisor: Supervisor, condition: Callable[[], bool]) -> None:
    deadline_s = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < deadline_s, supervisor.statuses()
        supervisor.poll()
        time.sleep(0.005)


def running(supervisor: Supervisor) -> Callable[[], bool]:
    return lambda: supervisor.state is StackState.RUNNING


def test_all_run_and_all_are_stopped(tmp_path: Path) -> None:
    with Supervisor([shell("a", SLEEPER), shell("b", SLEEPER)], tmp_path) as supervisor:
        until(supervisor, running(supervisor))
        pids = [status.pid for status in supervisor.statuses()]
        assert all(pid is not None and os.path.exists(f"/proc/{pid}") for pid in pids)
    assert [status.state for status in supervisor.statuses()] == [ProcessState.STOPPED] * 2
    assert not any(os.path.exists(f"/proc/{pid}") for pid in pids)
    assert supervisor.poll() is StackState.STOPPED


def test_a_process_waits_for_the_one_before_it_to_be_ready(tmp_path: Path) -> None:
    gate = tmp_path / "gate"
    first = f'while [ ! -e {gate} ]; do sleep 0.01; done; touch "$TARGET_NAV_READY_FILE"; exec sleep 1000'
    specs = [shell("a", first, ready=ReadyWhen.REPORTED), shell("b", SLEEPER)]
    with Supervisor(specs, tmp_path) as supervisor:
        for _ in range(20):
            assert supervisor.poll() is StackState.STARTING
            time.sleep(0.005)
        assert [status.state for status in supervisor.statuses()] == [
            ProcessState.STARTING,
            ProcessState.WAITING,
        ]
        gate.touch()
        until(supervisor, running(supervisor))


def test_a_process_that_holds_nobody_gets_ready_beside_the_next(tmp_path: Path) -> None:
    first = shell("a", SLEEPER, ready=ReadyWhen.REPORTED, holds_next=False)
    with Supervisor([first, shell("b", SLEEPER)], tmp_path) as supervisor:
        until(supervisor, lambda: supervisor.statuses()[1].state is ProcessState.RUNNING)
        assert supervisor.statuses()[0].state is ProcessState.STARTING
        assert supervisor.state is StackState.STARTING


def test_what_died_is_started_again_and_the_others_stay(tmp_path: Path) -> None:
    specs = [shell(name, REPORTING, ready=ReadyWhen.REPORTED, restart=QUICK) for name in ("a", "b")]
    with Supervisor(specs, tmp_path) as supervisor:
        until(supervisor, running(supervisor))
        first, second = supervisor.statuses()
        assert first.pid is not None
        os.kill(first.pid, 9)
        until(supervisor, lambda: supervisor.statuses()[0].restarts == 1)
        until(supervisor, running(supervisor))
        again = supervisor.statuses()[0]
        assert again.pid not in (None, first.pid)
        assert again.exit_text == "was ended by SIGKILL"
        assert supervisor.statuses()[1].pid == second.pid
    assert "was ended by SIGKILL" in (tmp_path / "run.log").read_text()


def test_a_process_that_keeps_dying_stops_the_stack_and_its_last_words_are_told(tmp_path: Path) -> None:
    specs = [shell("a", SLEEPER), shell("b", "echo the reason >&2; exit 1", restart=QUICK)]
    with Supervisor(specs, tmp_path) as supervisor, pytest.raises(DeviceError) as caught:
        until(supervisor, lambda: False)
    assert "process b ended with exit code 1, 3 times within 30 s; all others were stopped" in str(
        caught.value
    )
    assert "the reason" in str(caught.value)
    assert [status.state for status in supervisor.statuses()] == [ProcessState.STOPPED, ProcessState.FAILED]


def test_a_process_that_may_not_die_ends_the_stack_at_once(tmp_path: Path) -> None:
    spec = shell("a", "exit 1", restart=RestartPolicy(max_failures=1))
    with (
        Supervisor([spec], tmp_path) as supervisor,
        pytest.raises(DeviceError, match="process a ended with exit code 1; all others"),
    ):
        until(supervisor, lambda: False)


def test_exit_code_2_is_never_tried_again(tmp_path: Path) -> None:
    with (
        Supervisor([shell("a", "echo no such port; exit 2")], tmp_path) as supervisor,
        pytest.raises(DeviceError, match=r"cannot be run(.|\n)*no such port"),
    ):
        until(supervisor, lambda: False)
    assert supervisor.statuses()[0].restarts == 0


def test_a_program_that_is_not_there_cannot_be_run(tmp_path: Path) -> None:
    with (
        Supervisor([ProcessSpec("a", ("/nowhere/program",))], tmp_path) as supervisor,
        pytest.raises(DeviceError, match=r"/nowhere/program cannot be run: No such file"),
    ):
        until(supervisor, lambda: False)


def test_a_process_that_is_not_critical_only_stays_away(tmp_path: Path) -> None:
    specs = [shell("a", "exit 2", critical=False), shell("b", SLEEPER)]
    with Supervisor(specs, tmp_path) as supervisor:
        until(supervisor, lambda: supervisor.statuses()[0].state is ProcessState.FAILED)
        until(supervisor, running(supervisor))
        assert supervisor.statuses()[1].state is ProcessState.RUNNING


@pytest.mark.parametrize("code", [0, 1])
def test_an_end_that_means_something_is_reported(tmp_path: Path, code: int) -> None:
    specs = [shell("a", SLEEPER), shell("b", f"exit {code}", restart=NO_RESTART)]
    with Supervisor(specs, tmp_path) as supervisor:
        until(supervisor, lambda: supervisor.statuses()[1].state is ProcessState.EXITED)
        assert supervisor.statuses()[1].exit_code == code
        assert supervisor.statuses()[1].pid is None


def test_even_a_good_end_is_a_death_where_none_is_due(tmp_path: Path) -> None:
    with (
        Supervisor([shell("a", "exit 0", restart=QUICK)], tmp_path) as supervisor,
        pytest.raises(DeviceError, match="exit code 0, 3 times"),
    ):
        until(supervisor, lambda: False)


def test_a_process_that_never_gets_ready_is_given_up(tmp_path: Path) -> None:
    spec = shell("a", SLEEPER, ready=ReadyWhen.REPORTED, ready_timeout_s=0.05, restart=QUICK)
    with (
        Supervisor([spec], tmp_path) as supervisor,
        pytest.raises(DeviceError, match=r"was not ready after 0\.05 s, 3 times"),
    ):
        until(supervisor, lambda: False)


def test_deaths_that_are_far_apart_are_forgiven(tmp_path: Path) -> None:
    policy = RestartPolicy(first_delay_s=0.001, max_failures=2, window_s=0.0)
    with Supervisor([shell("a", "exit 1", restart=policy)], tmp_path) as supervisor:
        until(supervisor, lambda: supervisor.statuses()[0].restarts >= 5)


def test_a_process_that_does_not_listen_is_killed(tmp_path: Path) -> None:
    deaf = "trap '' INT TERM; touch \"$TARGET_NAV_READY_FILE\"; while :; do sleep 0.05; done"
    spec = shell("a", deaf, ready=ReadyWhen.REPORTED, stop_timeout_s=0.05)
    with Supervisor([spec], tmp_path) as supervisor:
        until(supervisor, running(supervisor))
    assert supervisor.statuses()[0].exit_text == "was ended by SIGKILL"


def test_what_a_process_started_itself_goes_with_it(tmp_path: Path) -> None:
    script = f"sleep 1000 & echo $! > {tmp_path}/pid; {REPORTING}"
    with Supervisor([shell("a", script, ready=ReadyWhen.REPORTED)], tmp_path) as supervisor:
        until(supervisor, running(supervisor))
        pid = int((tmp_path / "pid").read_text())
        assert os.path.exists(f"/proc/{pid}")
    assert not is_alive(pid)


def is_alive(pid: int) -> bool:
    try:
        stat = Path(f"/proc/{pid}/stat").read_text()
    except FileNotFoundError:
        return False
    return stat[stat.rindex(")") + 2] not in "ZX"


def test_processes_are_stopped_in_reverse_order(tmp_path: Path) -> None:
    order = tmp_path / "order"
    script = (
        "trap 'echo {0} >> %s; exit 0' INT; touch \"$TARGET_NAV_READY_FILE\"; while :; do sleep 0.01; done"
    )
    specs = [shell(name, (script % order).format(name), ready=ReadyWhen.REPORTED) for name in "abc"]
    with Supervisor(specs, tmp_path) as supervisor:
        until(supervisor, running(supervisor))
    assert order.read_text().split() == ["c", "b", "a"]


def test_each_process_has_its_log_and_all_are_merged(tmp_path: Path) -> None:
    specs = [shell(name, f"echo from {name}; {SLEEPER}") for name in ("a", "b")]
    with Supervisor(specs, tmp_path) as supervisor:
        until(supervisor, lambda: len(supervisor.recent_log(10)) == 2)
    assert (tmp_path / "logs" / "a.log").read_text() == "from a\n"
    assert sorted((tmp_path / "run.log").read_text().splitlines()) == ["a | from a", "b | from b"]


def test_a_process_gets_its_environment_core_and_niceness(tmp_path: Path) -> None:
    core = min(os.sched_getaffinity(0))
    nice = os.getpriority(os.PRIO_PROCESS, 0) + 1
    script = "import os; print(os.environ['ROS_DOMAIN_ID'], os.sched_getaffinity(0), os.nice(0), flush=True)"
    spec = ProcessSpec("a", (sys.executable, "-c", script), core=core, nice=nice, restart=NO_RESTART)
    with Supervisor([spec], tmp_path, env={"ROS_DOMAIN_ID": "42"}) as supervisor:
        until(supervisor, lambda: bool(supervisor.recent_log(1)))
    assert (tmp_path / "logs" / "a.log").read_text().strip() == f"42 {{{core}}} {nice}"


def test_a_core_that_is_not_there_is_told_and_not_needed(tmp_path: Path) -> None:
    with Supervisor([shell("a", "echo runs; " + SLEEPER, core=4000)], tmp_path) as supervisor:
        until(supervisor, lambda: len(supervisor.recent_log(2)) == 2)
    assert "core 4000 not granted" in (tmp_path / "logs" / "a.log").read_text()


def test_statuses_tell_time_and_memory(tmp_path: Path) -> None:
    with Supervisor([shell("a", "while :; do :; done")], tmp_path) as supervisor:
        # between two programs (the launcher becomes the shell) a process has no memory to tell of
        until(
            supervisor,
            lambda: supervisor.statuses()[0].cpu_s > 0.0 and supervisor.statuses()[0].memory_mb > 0.0,
        )
        (status,) = supervisor.statuses()
        assert status.uptime_s > 0.0


def test_two_processes_of_one_name_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="one name"):
        Supervisor([shell("a", SLEEPER), shell("a", SLEEPER)], tmp_path)


def test_ends_in_words() -> None:
    assert exit_text(None) == ""
    assert exit_text(3) == "ended with exit code 3"
    assert exit_text(-15) == "was ended by SIGTERM"
    assert exit_text(-99) == "was ended by signal 99"

"""The panel without a stack: whatever stands in shared memory, or does not, it stays up and says what is missing."""

from __future__ import annotations

import os
import subprocess
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from benchmarks.bench_panel import memory_mb
from target_nav.app import gui_launch
from target_nav.ipc import channels
from target_nav.ipc.channels import Channel
from target_nav.ipc.codecs import PlainCodec
from target_nav.state.snapshots import Calibration
from target_nav.state.types import CommandKind
from tests.unit.gui import worlds
from tests.utils.processes import wait_until
from tests.utils.screen import Screen, require_screen

pytestmark = [pytest.mark.linux, pytest.mark.slow]

PREFIX = f"test_panel_alone_{os.getpid()}"
MOST_MEMORY_MB = 150.0


class Panel:
    def __init__(self, screen: Screen, folder: Path) -> None:
        self.screen = screen
        self.log_path, ready = folder / "panel.log", folder / "ready"
        with self.log_path.open("wb") as log:
            self.process = subprocess.Popen(
                gui_launch.command("--prefix", PREFIX, "--settings", str(folder / "settings.yaml")),
                env={**screen.environment, "TARGET_NAV_READY_FILE": str(ready)},
                stderr=log,
            )
        wait_until(lambda: ready.exists() or self.process.poll() is not None, "the first frame")
        self.must_run()

    def log(self) -> str:
        return self.log_path.read_text(encoding="utf-8", errors="replace")

    def must_run(self, for_s: float = 0.0) -> None:
        time.sleep(for_s)
        assert self.process.poll() is None, self.log()
        assert "Traceback" not in self.log(), self.log()

    def close(self) -> None:
        self.process.terminate()
        assert self.process.wait(20.0) == 0, self.log()
        channels.remove(PREFIX)


@pytest.fixture(scope="module")
def panel(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Panel]:
    require_screen()
    folder = tmp_path_factory.mktemp("alone")
    with closing(Screen(folder)) as screen, closing(Panel(screen, folder)) as made:
        yield made


def test_with_nothing_there_it_stays_up_shows_every_page_and_is_small(panel: Panel) -> None:
    panel.screen.shoot("panel-nothing-there")
    for number in range(1, 9):
        panel.screen.key(f"alt+{number}")
        panel.must_run(0.2)
    panel.screen.key("alt+1")
    assert memory_mb(panel.process.pid) < MOST_MEMORY_MB


def test_a_stop_that_nobody_can_hear_is_told(panel: Panel) -> None:
    panel.screen.key("space")
    wait_until(
        lambda: "STOP NOT SENT: the nav process does not listen" in panel.log(), "the panel tells", 5.0
    )


def test_files_of_nonsense_and_of_another_version_are_told_and_do_not_end_it(panel: Panel) -> None:
    other: Channel[Calibration] = Channel("nav", PlainCodec(Calibration))
    with channels.open_writer(other, PREFIX) as writer:
        writer.write(Calibration(time.monotonic(), 1.0, 1.0, 1.0, 1.0, (0.0,) * 5, 0.5, "pin"))
        broken = [Path(f"/dev/shm/{PREFIX}_{name}") for name in ("tree", "camera", "det", "laser", "avoid")]
        for path in broken:
            path.write_bytes(b"nonsense" * 200)
        panel.must_run(1.5)
        panel.screen.shoot("panel-other-version")
        for path in broken:
            path.unlink()
    panel.must_run(0.3)


def test_a_stack_that_comes_goes_and_comes_again_is_followed(panel: Panel) -> None:
    for _ in range(2):
        with channels.open_writer(channels.NAV, PREFIX) as nav, channels.open_command_reader(PREFIX) as ear:
            heard = panel.log().count("GO acknowledged")
            panel.screen.key("ctrl+Return")
            said: list[CommandKind] = []
            deadline_s = time.monotonic() + 5.0
            while panel.log().count("GO acknowledged") == heard:
                said += [command.kind for command in ear.pop_all()]
                nav.write(worlds.nav(stamp_s=time.monotonic()))
                assert time.monotonic() < deadline_s, panel.log()
                time.sleep(0.02)
            assert said == [CommandKind.GO]
        panel.must_run(0.2)

"""The panel as a person uses it: on a screen of 800x480 with keys and a mouse, against the whole simulated stack.

One stack for the whole module; the tests go on where the last one stopped, so they begin by saying STOP.
"""

from __future__ import annotations

import itertools
import math
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
import yaml

from target_nav.ipc import channels
from target_nav.state.snapshots import NavSnapshot
from tests.utils.processes import is_alive, ros_environment, wait_until
from tests.utils.screen import HEIGHT, WIDTH, PanelHand, Screen, require_screen

pytestmark = [pytest.mark.ros, pytest.mark.linux, pytest.mark.slow]
pytest.importorskip("rclpy")
pytest.importorskip("py_trees_ros_interfaces.srv")

PREFIX = f"test_panel_{os.getpid()}"
SMALLEST_KEY_PX = 44
"""About 9 mm on a 7 inch screen of 800x480 (0.19 mm a pixel)."""

VERMILION = (213, 94, 0)


class Stack:
    """The simulated robot with the panel, and what shared memory says of it."""

    def __init__(self, screen: Screen, folder: Path) -> None:
        self.screen, self.folder = screen, folder
        places = folder / "places.json"
        self.hand = PanelHand(screen, places)
        environment = {**ros_environment(), **screen.environment, "TARGET_NAV_PANEL_PLACES": str(places)}
        self._out = (folder / "run.out").open("wb")
        self._process = subprocess.Popen(
            [
                *(sys.executable, "-m", "target_nav.app.cli", "run", "--sim", "open_floor", "--headless"),
                *("--wait", "--gui", "--prefix", PREFIX, "--out", str(folder)),
            ],
            env=environment,
            stdout=self._out,
            stderr=subprocess.STDOUT,
        )
        self._nav = channels.open_reader(channels.NAV, PREFIX)
        self._processes = channels.open_reader(channels.PROCESSES, PREFIX)

    @property
    def run_dir(self) -> Path:
        return self.folder / "latest"

    @property
    def nav(self) -> NavSnapshot:
        value = self._nav.latest()
        assert value is not None
        return value

    def panel_log(self) -> str:
        path = self.run_dir / "logs" / "gui.log"
        return path.read_text(encoding="utf-8", errors="replace") if path.exists() else ""

    def pid(self, name: str) -> int:
        table = self._processes.latest()
        return next((row.pid for row in table.rows if row.name == name), 0) if table is not None else 0

    def wait_up(self) -> None:
        try:
            wait_until(lambda: self._nav.latest() is not None, "the nav process ticks", 60.0)
            wait_until(lambda: "first frame" in self.panel_log(), "the panel's first frame", 60.0)
        except AssertionError:
            self._out.flush()
            raise AssertionError((self.folder / "run.out").read_text() + self.panel_log()) from None
        self.take_pid()

    def take_pid(self) -> None:
        wait_until(lambda: is_alive(self.pid("gui")), "the supervisor tells the panel's pid")
        self.hand.pid = self.pid("gui")

    def stop(self) -> None:
        self.screen.key("space")
        wait_until(lambda: not self.nav.requested and self.stands(), "the robot stands after STOP")

    def stands(self) -> bool:
        twist = self.nav.twist_sent
        return twist.speed_mps == 0.0 and twist.wz_radps == 0.0

    def heard(self, word: str) -> int:
        """How often the panel has told that the nav process acknowledged a word."""
        return len(re.findall(rf"{word} acknowledged", self.panel_log()))

    def close(self) -> None:
        self._process.send_signal(signal.SIGINT)
        try:
            self._process.wait(30.0)
        finally:
            self._process.kill()
            self._out.close()
            self._nav.close()
            self._processes.close()
            channels.remove(PREFIX)


@pytest.fixture(scope="module")
def screen(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Screen]:
    require_screen()
    with closing(Screen(tmp_path_factory.mktemp("screen"))) as shown:
        yield shown


@pytest.fixture(scope="module")
def stack(screen: Screen, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Stack]:
    with closing(Stack(screen, tmp_path_factory.mktemp("stack"))) as started:
        started.wait_up()
        yield started


def pixels(picture: Path) -> Any:
    cv2 = pytest.importorskip("cv2")
    return cv2.cvtColor(cv2.imread(str(picture)), cv2.COLOR_BGR2RGB)


def moved_m(before: NavSnapshot, after: NavSnapshot) -> tuple[float, float]:
    """The way between two snapshots in the frame of the first: ahead, left."""
    a, b = before.pose_in_odom, after.pose_in_odom
    dx, dy = b.x_m - a.x_m, b.y_m - a.y_m
    c, s = math.cos(a.yaw_rad), math.sin(a.yaw_rad)
    return c * dx + s * dy, -s * dx + c * dy


def test_it_fills_the_screen_with_stop_in_reach_of_a_thumb(stack: Stack) -> None:
    time.sleep(0.5)
    picture = pixels(stack.screen.shoot("panel-idle"))
    assert picture.shape == (HEIGHT, WIDTH, 3)
    x, y = stack.hand.place("■ STOP")
    assert tuple(picture[y - 60, x - 50]) == VERMILION
    boxes = stack.hand.boxes()
    assert min(boxes["■ STOP"][2:]) >= 130
    assert not {words: box for words, box in boxes.items() if min(box[2:]) < SMALLEST_KEY_PX}


@pytest.mark.parametrize(("key", "axis"), [("Up", "ahead"), ("a", "left")])
def test_a_held_key_moves_the_robot_and_a_released_one_stops_it(stack: Stack, key: str, axis: str) -> None:
    stack.stop()
    stack.hand.page(5)
    before = stack.nav
    with stack.screen.held_key(key):
        wait_until(lambda: stack.nav.manual and not stack.stands(), "the robot moves while the key is held")
        time.sleep(1.0)
        assert not stack.stands()
        stack.screen.shoot(f"panel-drive-{axis}")
    wait_until(stack.stands, "the robot stops when the key is released", 3.0)
    ahead_m, left_m = moved_m(before, stack.nav)
    way_m, other_m = (ahead_m, left_m) if axis == "ahead" else (left_m, ahead_m)
    assert way_m > 0.05
    assert abs(other_m) < 0.5 * way_m
    assert not stack.nav.requested


def test_a_thumb_on_the_pad_turns_the_robot_until_it_is_lifted(stack: Stack) -> None:
    stack.stop()
    stack.hand.page(5)
    before = stack.nav.pose_in_odom.yaw_rad
    with stack.screen.held_mouse(*stack.hand.place("turn  Q")):
        wait_until(lambda: stack.nav.twist_sent.wz_radps > 0.1, "the robot turns while the field is held")
        time.sleep(0.5)
    wait_until(stack.stands, "the robot stops when the thumb is lifted", 3.0)
    assert math.remainder(stack.nav.pose_in_odom.yaw_rad - before, math.tau) > 0.1


def test_a_panel_that_dies_while_a_key_is_held_leaves_a_robot_that_stops(stack: Stack) -> None:
    stack.stop()
    stack.hand.page(5)
    tick = stack.nav.tick
    with stack.screen.held_key("Up"):
        wait_until(lambda: not stack.stands(), "the robot moves while the key is held")
        os.kill(stack.hand.pid, signal.SIGKILL)
        wait_until(stack.stands, "the deadman stops the robot", 3.0)
    wait_until(lambda: stack.pid("gui") not in (0, stack.hand.pid), "the supervisor starts the panel again")
    wait_until(lambda: stack.panel_log().count("first frame") == 2, "the new panel's first frame")
    stack.take_pid()
    assert stack.nav.tick > tick, "the nav process ticks on"


def test_a_changed_setting_is_saved_and_changes_how_fast_the_robot_is_driven(stack: Stack) -> None:
    stack.stop()
    stack.hand.page(8)
    stack.screen.shoot("panel-motor-test")
    stack.hand.reveal("manual")
    stack.hand.press("manual")
    stack.hand.press("speed mps")
    for key in ("0", ".", "0", "6"):
        stack.hand.press(key)
    stack.hand.press("Set")
    stack.hand.place("home")
    stack.screen.shoot("panel-settings-changed")
    wait_until(lambda: "manual.speed_mps" in stack.nav.notice, "the nav process takes the setting")
    saved = yaml.safe_load((stack.run_dir / "settings.yaml").read_text())
    assert saved == {"manual.speed_mps": 0.06}
    stack.hand.page(5)
    with stack.screen.held_key("Down"):
        wait_until(lambda: not stack.stands(), "the robot moves while the key is held")
        time.sleep(0.6)
        assert stack.nav.twist_sent.vx_mps == pytest.approx(-0.06)
    wait_until(stack.stands, "the robot stops", 3.0)


def test_another_mission_is_chosen_and_waits_for_go(stack: Stack) -> None:
    stack.stop()
    stack.hand.page(7)
    for name in ("patrol", "bowling pin"):
        stack.hand.press(name)
        wait_until(lambda n=name: stack.nav.mission == n.replace(" ", "_"), f"{name} is loaded")
        assert not stack.nav.requested
    stack.hand.press("bowling pin 28 x 8 cm")
    wait_until(lambda: "bowling_pin,0.28,0.08" in stack.nav.notice, "the target is taken")


def test_a_motor_turns_while_its_field_is_held(stack: Stack) -> None:
    stack.stop()
    stack.hand.page(8)
    stack.hand.reveal("motor test")
    stack.hand.press("motor test")
    arduino = stack.run_dir / "logs" / "arduino.log"
    before = arduino.read_text()
    with stack.screen.held_mouse(*stack.hand.place("front left")):
        wait_until(
            lambda: "command TMOTOR,FL,80" in arduino.read_text()[len(before) :], "the motor's command"
        )
        time.sleep(0.8)
        assert "command STOP" not in arduino.read_text()[len(before) :]
    wait_until(lambda: "command STOP" in arduino.read_text()[len(before) :], "STOP when it is released", 3.0)


def test_go_starts_the_mission_and_every_stop_stops_the_robot(stack: Stack) -> None:
    stack.stop()
    stack.hand.page(1)
    for way, stop in (
        ("space", lambda: stack.screen.key("space")),
        ("escape", lambda: stack.screen.key("Escape")),
        ("click", lambda: stack.hand.press("■ STOP")),
    ):
        heard = stack.heard("GO"), stack.heard("STOP")
        stack.hand.press("▶ GO")
        wait_until(lambda: stack.nav.requested and not stack.stands(), "GO starts the mission")
        time.sleep(1.0)
        stack.screen.shoot(f"panel-mission-{way}")
        stop()
        wait_until(lambda: not stack.nav.requested, f"{way} is STOP", 2.0)
        wait_until(stack.stands, f"the robot stands after {way}", 2.0)
        wait_until(
            lambda h=heard: stack.heard("GO") > h[0] and stack.heard("STOP") > h[1], "both acknowledged"
        )


def test_by_hand_nothing_moves_while_a_mission_runs(stack: Stack) -> None:
    stack.stop()
    stack.hand.page(5)
    stack.hand.press("▶ GO")
    wait_until(lambda: stack.nav.requested, "GO")
    with stack.screen.held_key("Down"):
        time.sleep(0.5)
        assert not stack.nav.manual
    stack.stop()


def test_every_page_can_be_reached_by_key_and_is_kept_as_a_picture(stack: Stack) -> None:
    stack.screen.key("ctrl+Return")
    wait_until(lambda: stack.nav.requested, "Ctrl+Enter is GO")
    at_rest = None
    names = ("home", "camera", "map", "tree", "drive", "log", "mission", "settings")
    shown = []
    for number, name in enumerate(names, start=1):
        stack.hand.page(number)
        shown.append(pixels(stack.screen.shoot(f"panel-{number}-{name}")))
        boxes = stack.hand.boxes()
        always = {key: boxes[key] for key in ("home", "settings", "▶ GO", "■ STOP", "PAUSE")}
        assert all(y + height <= HEIGHT for _, y, _, height in always.values())
        assert always == (at_rest or always), "no page pushes the keys that are always there"
        at_rest = always
    stack.stop()
    for one, other in itertools.pairwise(shown):
        # below the bar and left of GO and STOP
        assert (one[90:420, :640] != other[90:420, :640]).mean() > 0.02


def test_a_nav_process_that_does_not_answer_is_seen_and_a_stop_is_told_as_not_acknowledged(
    stack: Stack,
) -> None:
    stack.stop()
    stack.hand.page(1)
    nav = stack.pid("nav")
    os.kill(nav, signal.SIGSTOP)
    try:
        time.sleep(1.2)
        stack.screen.key("space")
        wait_until(lambda: "STOP NOT ACKNOWLEDGED" in stack.panel_log(), "the panel tells", 3.0)
        stack.screen.shoot("panel-nav-silent")
    finally:
        os.kill(nav, signal.SIGCONT)
    heard = stack.heard("STOP")
    wait_until(lambda: stack.heard("STOP") > heard, "the STOP that was said again is acknowledged")


def test_a_dead_process_is_named_and_the_panel_goes_on(stack: Stack) -> None:
    camera = stack.pid("camera")
    os.kill(camera, signal.SIGKILL)
    wait_until(lambda: stack.pid("camera") not in (0, camera), "the supervisor starts it again")
    stack.hand.page(6)
    time.sleep(0.3)
    stack.screen.shoot("panel-log")
    assert is_alive(stack.hand.pid)

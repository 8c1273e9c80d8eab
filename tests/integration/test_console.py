"""The browser console as a person uses it: in a real browser, against the whole simulated stack.

One stack, one console and one window for the module; each test begins by saying STOP. Screenshots are kept in
`runs/console`.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from target_nav.state.snapshots import NavSnapshot
from target_nav.state.types import STOP
from tests.utils.browser import Browser, require_browser
from tests.utils.console import TOKEN, ConsoleProcess, Stack
from tests.utils.processes import wait_until

pytestmark = [pytest.mark.ros, pytest.mark.linux, pytest.mark.slow]
pytest.importorskip("rclpy")
pytest.importorskip("py_trees_ros_interfaces.srv")
for package in ("starlette", "uvicorn", "websockets"):
    pytest.importorskip(package)

PICTURES = Path(__file__).resolve().parents[2] / "runs" / "console"
CONTROL, ESCAPE, HOME, PAGE_DOWN = "\ue009", "\ue00c", "\ue011", "\ue00f"
"""As WebDriver writes them."""


@pytest.fixture(scope="module")
def stack(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Stack]:
    require_browser()
    with closing(Stack(tmp_path_factory.mktemp("console"))) as started:
        started.wait_up()
        yield started


@pytest.fixture(scope="module")
def console(stack: Stack) -> Iterator[ConsoleProcess]:
    with closing(ConsoleProcess(stack)) as started:
        yield started


@pytest.fixture(scope="module")
def window(console: ConsoleProcess) -> Iterator[Browser]:
    PICTURES.mkdir(parents=True, exist_ok=True)
    with closing(Browser(PICTURES)) as opened:
        opened.open(f"{console.address}#token={TOKEN}")
        opened.wait_text("#role", "Operator")
        yield opened


@pytest.fixture
def page(window: Browser, stack: Stack) -> Iterator[Browser]:
    """The watch page of the operator, the robot standing; at the end no script has complained."""
    window.shape(1440, 900)
    window.click("#tab-watch")
    window.click("#stop")
    wait_until(lambda: not stack.nav.requested and stack.stands(), "the robot stands after STOP")
    yield window
    assert window.errors() == []


def moved_m(before: NavSnapshot, after: NavSnapshot) -> tuple[float, float]:
    """The way between two snapshots in the frame of the first: ahead, left."""
    a, b = before.pose_in_odom, after.pose_in_odom
    dx, dy = b.x_m - a.x_m, b.y_m - a.y_m
    c, s = math.cos(a.yaw_rad), math.sin(a.yaw_rad)
    return c * dx + s * dy, -s * dx + c * dy


def test_the_page_shows_what_the_robot_senses(page: Browser) -> None:
    page.wait(lambda: page.text("#headline") == "IDLE", "the robot idles")
    page.wait(
        lambda: page.run("return document.querySelectorAll('.panel.stale').length") == 0, "nothing is stale"
    )
    page.wait(
        lambda: page.run("return document.querySelectorAll('#tree .node').length") > 20, "the tree is there"
    )
    for canvas in ("camera", "radar", "map", "past"):
        colors = page.run(
            "const c = document.getElementById(arguments[0]);"
            "const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;"
            "const s = new Set(); for (let i = 0; i < d.length; i += 40) s.add(d[i] << 16 | d[i + 1] << 8 | d[i + 2]);"
            "return s.size",
            canvas,
        )
        assert colors > 3, f"{canvas} is empty"
    assert "token" not in page.driver.current_url, "the token does not stay in the address"


def test_go_starts_the_mission_and_space_stops_the_robot(page: Browser, stack: Stack) -> None:
    page.click("#go")
    wait_until(lambda: stack.nav.requested and stack.nav.twist_sent != STOP, "GO moves the robot")
    page.wait(lambda: page.text("#headline") in ("SEARCHING", "NAVIGATING"), "the page says so")
    page.wait(
        lambda: page.run("return document.querySelector('#tree .node.current.RUNNING')") is not None,
        "a leaf runs",
    )
    time.sleep(2.0)
    page.shot("console-watch")
    # the focus is on GO, where Space would press it again
    page.key(" ")
    wait_until(lambda: not stack.nav.requested and stack.stands(), "Space stops the robot")
    page.wait(
        lambda: page.text("#said").startswith("✔ STOP") or "STOP acknowledged" in page.text("#said"),
        "STOP is acknowledged",
    )
    page.wait_text("#headline", "IDLE")


def test_escape_stops_it_even_from_a_text_field(page: Browser, stack: Stack) -> None:
    page.click("#go")
    wait_until(lambda: stack.nav.requested, "GO")
    page.click("#tab-settings")
    page.wait(
        lambda: page.run("return document.querySelectorAll('.setting').length") > 50, "settings are listed"
    )
    field = page.find(".sheet-head input")
    field.send_keys("stand off")
    assert stack.nav.requested, "a space in a text field is a space"
    field.send_keys(ESCAPE)
    wait_until(lambda: not stack.nav.requested and stack.stands(), "Escape stops the robot")


def test_pause_and_step_hold_the_tree(page: Browser, stack: Stack) -> None:
    page.click("#pause")
    wait_until(lambda: stack.nav.paused, "paused")
    page.wait_text("#pause", "Resume")
    tick = stack.nav.tick
    page.click("#step")
    wait_until(lambda: stack.nav.tick == tick + 1, "one tick")
    page.click("#pause")
    wait_until(lambda: not stack.nav.paused, "goes on")


def test_it_moves_by_hand_only_while_a_field_is_held(page: Browser, stack: Stack) -> None:
    before = stack.nav
    hand = page.actions().click_and_hold(page.find("[data-direction=forward]"))
    hand.perform()
    wait_until(lambda: moved_m(before, stack.nav)[0] > 0.12, "it drives ahead")
    page.shot("console-by-hand")
    wait_until(lambda: stack.nav.manual, "it is driven by hand")
    page.actions().release().perform()
    wait_until(stack.stands, "released: it stands")
    time.sleep(0.5)
    rest = stack.nav
    time.sleep(1.0)
    assert math.hypot(*moved_m(rest, stack.nav)) < 0.01, "and goes on standing"
    assert not stack.nav.manual


def test_the_keyboard_strafes_while_the_pad_has_the_focus(page: Browser, stack: Stack) -> None:
    before = stack.nav
    page.run("document.querySelector('.pad').focus()")
    page.actions().key_down("a").perform()
    wait_until(lambda: moved_m(before, stack.nav)[1] > 0.08, "it strafes to the left")
    page.actions().key_up("a").perform()
    wait_until(stack.stands, "released: it stands")


def test_a_setting_changes_how_fast_it_drives(page: Browser, stack: Stack, console: ConsoleProcess) -> None:
    def fastest(setting: str) -> float:
        page.click("#tab-settings")
        page.wait(
            lambda: page.run("return document.getElementById('set-manual.speed_mps') !== null"), "settings"
        )
        page.run(
            "const s = document.getElementById('set-manual.speed_mps'); s.value = arguments[0];"
            "s.dispatchEvent(new Event('change'))",
            setting,
        )
        page.wait_text("#said", "SETTING acknowledged")
        page.click("#tab-watch")
        page.actions().click_and_hold(page.find("[data-direction=back]")).perform()
        speeds = []
        until_s = time.monotonic() + 1.5
        while time.monotonic() < until_s:
            speeds.append(stack.nav.twist_sent.speed_mps)
            time.sleep(0.02)
        page.actions().release().perform()
        wait_until(stack.stands, "it stands")
        page.click("#stop")
        page.wait_text("#said", "STOP acknowledged")
        return max(speeds)

    slow, fast = fastest("0.06"), fastest("0.14")
    assert slow == pytest.approx(0.06, abs=0.005)
    assert fast == pytest.approx(0.14, abs=0.005)
    assert "manual.speed_mps: 0.14" in console.settings.read_text()


def test_a_value_outside_its_limits_is_refused_with_the_limits(
    page: Browser, console: ConsoleProcess
) -> None:
    page.click("#tab-settings")
    page.wait(
        lambda: page.run("return document.getElementById('set-approach.cruise_speed_mps') !== null"),
        "settings",
    )
    page.run(
        "const f = document.querySelector('.sheet-head input'); f.value = ''; f.dispatchEvent(new Event('input'));"
        "const s = document.getElementById('set-approach.cruise_speed_mps'); s.scrollIntoView({block: 'center'});"
        "s.value = '7'; s.dispatchEvent(new Event('change'))"
    )
    page.wait(
        lambda: "it must lie in 0.02 ... 2 m/s" in page.run("return document.body.innerText"),
        "the limits are told",
    )
    page.shot("console-settings")
    assert "cruise" not in (console.settings.read_text() if console.settings.exists() else "")


def test_the_checker_speaks_at_the_line_and_a_broken_mission_is_not_saved(
    page: Browser, console: ConsoleProcess
) -> None:
    page.click("#tab-missions")
    page.wait_text(".edit-head b", "bowling_pin.xml")
    page.wait_text(".edit-head .aside", "nothing wrong")
    good = (console.missions / "bowling_pin.xml").read_text()

    def write(text: str) -> None:
        page.run(
            "const t = document.querySelector('.text textarea'); t.value = arguments[0];"
            "t.dispatchEvent(new Event('input'))",
            text,
        )

    write(good.replace("<MissionRequested/>", "<MissionRequestd/>"))
    page.wait_text(".problems", 'did you mean "MissionRequested"?')
    assert "1 error" in page.text(".edit-head .aside")
    line = good[: good.index("<MissionRequested/>")].count("\n") + 1
    assert page.text(".gutter .error").endswith(str(line))
    page.shot("console-missions")
    assert not page.find(".edit-head button:not([hidden]):not(.danger):not(.quiet)").is_enabled(), (
        "Save is closed"
    )
    assert (console.missions / "bowling_pin.xml").read_text() == good
    changed = good.replace("The reference mission", "The reference mission, changed on the page")
    write(changed)
    page.wait_text(".edit-head .aside", "nothing wrong")
    page.find(".text textarea").send_keys(CONTROL, "s")
    page.wait_text(".edit-head .aside", "saved bowling_pin.xml")
    assert (console.missions / "bowling_pin.xml").read_text() == changed


def test_another_mission_is_loaded_and_waits_for_go(page: Browser, stack: Stack) -> None:
    page.wait(
        lambda: page.run("return document.querySelectorAll('#mission-choice option').length") > 3, "missions"
    )
    choose = (
        "const s = document.getElementById('mission-choice'); s.value = arguments[0];"
        "s.dispatchEvent(new Event('change'))"
    )
    page.run(choose, "patrol.xml")
    wait_until(lambda: stack.nav.mission == "patrol", "the other mission is taken")
    assert not stack.nav.requested
    page.wait(lambda: page.text("#mission") == "patrol", "the page says so")
    page.run(choose, "bowling_pin.xml")
    wait_until(lambda: stack.nav.mission == "bowling_pin", "back")


def test_past_ticks_can_be_scrubbed_and_a_recording_as_well(page: Browser, stack: Stack) -> None:
    page.find("#past").send_keys(HOME)
    page.wait(lambda: "ago" in page.text("#past-says"), "the past is shown")
    assert page.run("return document.body.classList.contains('past-shown')")
    page.click("#past-live")
    page.wait_text("#past-says", "live")
    page.wait(
        lambda: page.run("return document.querySelectorAll('#past-source option').length") > 1,
        "the run is listed",
    )
    page.run(
        "const s = document.getElementById('past-source'); s.selectedIndex = 1; s.dispatchEvent(new Event('change'))"
    )
    page.wait(lambda: " s of " in page.text("#past-says"), "the recording is open", 60.0)
    page.find("#past").send_keys(PAGE_DOWN * 15)
    page.wait(lambda: not page.text("#past-says").startswith("0.0 s"), "it goes on")
    page.wait_text("#camera-excuse", "no picture kept of this moment")
    page.wait(lambda: page.run("return document.body.classList.contains('past-shown')"), "the past is marked")
    page.shot("console-recording")
    page.click("#past-live")


def test_a_wrong_token_is_refused_and_a_spectator_moves_nothing(
    page: Browser, console: ConsoleProcess, stack: Stack
) -> None:
    with closing(Browser(PICTURES, 900, 700)) as other:
        other.open(f"{console.address}#token=wrong-token")
        other.wait(lambda: other.find("#token-dialog").is_displayed(), "the page asks for the token")
        other.wait_text("#token-problem", "not the right one")
        other.shot("console-wrong-token")
        other.click("#token-dialog button[value=cancel]")
        other.wait_text("#role", "Watching only")
        other.wait(lambda: other.text("#headline") == "IDLE", "a spectator sees the robot")
        assert not other.find("#go").is_enabled()
        assert not other.find("[data-direction=forward]").is_enabled()
        other.key(" ")
        other.wait_text("#said", "needs the operator's address")
    assert "refused a wrong token from 127.0.0.1" in console.log()
    assert not stack.nav.requested


def test_on_a_phone_stop_and_the_pad_are_at_the_thumb(page: Browser) -> None:
    page.shape(390, 844, dark=False, phone=True)
    time.sleep(1.0)
    page.shot("console-phone")
    for css in ("#stop", "#go", "[data-direction=forward]"):
        box = page.run(
            "const b = document.querySelector(arguments[0]).getBoundingClientRect(); return [b.width, b.height]",
            css,
        )
        assert min(box) >= 44, f"{css} is {box} px"
    stop = page.run(
        "const b = document.getElementById('stop').getBoundingClientRect(); return [b.left, b.right, b.bottom]"
    )
    assert stop[0] >= 0
    assert stop[1] <= 390
    assert stop[2] <= 844
    assert page.run("return document.documentElement.scrollWidth") <= 390, "nothing is wider than the screen"


def test_a_console_that_dies_while_a_field_is_held_leaves_a_robot_that_stands(
    page: Browser, console: ConsoleProcess, stack: Stack
) -> None:
    page.actions().click_and_hold(page.find("[data-direction=turn_left]")).perform()
    wait_until(lambda: stack.nav.twist_sent.wz_radps > 0.3, "it turns")
    console.kill()
    wait_until(stack.stands, "the deadman stops it", 5.0)
    page.wait_text("#banner", "No connection to the console")
    page.shot("console-lost")
    page.actions().release().perform()
    console.start()
    page.wait(
        lambda: not page.run("return document.body.classList.contains('lost')"),
        "the page comes back by itself",
    )
    page.wait_text("#role", "Operator")
    assert stack.stands()


def test_without_the_stack_it_stays_up_and_says_what_is_missing(page: Browser, stack: Stack) -> None:
    stack.end()
    page.wait(
        lambda: page.run("return document.querySelectorAll('.links .stale').length") >= 4, "sources grey out"
    )
    page.wait(
        lambda: page.run("return document.querySelectorAll('.panel.stale').length") >= 3, "panels grey out"
    )
    assert page.find("#banner").is_displayed()
    assert page.text("#banner")
    page.shot("console-nothing")
    page.click("#stop")
    page.wait(
        lambda: "NOT SENT" in page.text("#said") or "NOT ACKNOWLEDGED" in page.text("#said"),
        "and STOP says so",
    )

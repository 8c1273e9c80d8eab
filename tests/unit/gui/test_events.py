"""The log: one line for each thing that happened, none for what stays as it is."""

from __future__ import annotations

from target_nav.config import Config
from target_nav.gui.events import CAPACITY, LOOKS_TO_BE_LOST, EventLog
from target_nav.gui.view_status import StatusView, status_view
from target_nav.state.types import NavState, Outcome, OutcomeKind
from tests.unit.gui import worlds
from tests.unit.gui.worlds import stale, world


def status(**changes: object) -> StatusView:
    return status_view(world(nav=worlds.nav(**changes)), Config())


def texts(log: EventLog) -> list[str]:
    return [event.text for event in log.events]


def test_what_stays_as_it_is_is_said_once() -> None:
    log = EventLog()
    for _ in range(50):
        log.see(status())
    assert len(log.events) == 1


def test_a_mission_leaves_a_line_for_each_step() -> None:
    log = EventLog(clock_text=lambda: "12:00:00")
    log.see(status(requested=False, state=NavState.IDLE))
    log.see(status(requested=True, state=NavState.SEARCHING, reason="turned 10 deg"))
    log.see(status(requested=True, state=NavState.ARRIVED, outcome=Outcome(OutcomeKind.SUCCEEDED, "there")))
    said = texts(log)[1:]
    assert said == [
        "mission requested",
        "SEARCHING: turned 10 deg",
        "ARRIVED: target 2.0 m off",
        "succeeded: there",
    ]
    assert log.events[-1].level == "good"
    assert [event.number for event in log.events] == [1, 2, 3, 4, 5]


def test_the_same_notice_twice_is_two_lines() -> None:
    log = EventLog()
    log.see(status())
    for count in (1, 2):
        log.see(status(notice="set approach.stand_off_m=0.1", notice_count=count))
    assert texts(log)[1:] == ["set approach.stand_off_m=0.1"] * 2


def test_a_source_is_lost_after_a_while_and_found_again() -> None:
    log = EventLog()
    log.see(status())
    old = status_view(world(camera=stale("camera", worlds.PICTURE)), Config())
    for _ in range(LOOKS_TO_BE_LOST - 1):
        log.see(old)
    assert len(log.events) == 1, "a hiccup is no loss"
    for _ in range(5):
        log.see(old)
    log.see(status())
    assert [text.split(":")[0] for text in texts(log)[1:]] == ["image lost", "image is there"]


def test_a_dead_process_is_named_when_it_dies_and_when_it_is_back() -> None:
    log = EventLog()
    log.see(status())
    log.see(status_view(world(gone=("camera",)), Config()))
    log.see(status())
    assert texts(log)[1:] == ["process camera is down", "process camera is back"]


def test_it_is_bounded_and_numbers_go_on() -> None:
    log = EventLog()
    for n in range(CAPACITY + 50):
        log.add(str(n))
    assert len(log.events) == CAPACITY
    assert log.events[-1].number == CAPACITY + 50


def test_settings_that_differ_for_a_while_are_told_once() -> None:
    log = EventLog()
    for _ in range(LOOKS_TO_BE_LOST - 1):
        log.see(status(settings_crc=1))
    log.see(status())
    assert len(log.events) == 1, "a change is on its way for a moment"
    for _ in range(3 * LOOKS_TO_BE_LOST):
        log.see(status(settings_crc=1))
    assert texts(log)[1:] == ["the nav process uses other settings than this screen shows"]

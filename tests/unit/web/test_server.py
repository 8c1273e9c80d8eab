# ruff: noqa: E402 (the imports below need what is asked for first)
"""The server as its clients meet it: pages, programs, spectators, and those who should not be there."""

from __future__ import annotations

import http.client
import json
import logging
import re
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

for package in ("starlette", "uvicorn", "websockets"):
    pytest.importorskip(package, reason=f"the extra `web` is not installed here ({package})")

from websockets.exceptions import ConnectionClosed, InvalidStatus

from target_nav.errors import DeviceError
from target_nav.ipc import channels
from target_nav.state.types import CommandKind
from target_nav.web.server import bind
from tests.unit.gui import worlds
from tests.unit.web.served import TOKEN, Ear, Served

BEARER = {"Authorization": f"Bearer {TOKEN}"}


@pytest.fixture
def served(prefix: str, tmp_path: Path) -> Iterator[Served]:
    with closing(Served(prefix, tmp_path)) as site:
        yield site


@pytest.fixture
def ear(prefix: str) -> Iterator[Ear]:
    with closing(Ear(prefix)) as listening:
        yield listening


def request(
    served: Served, path: str, method: str = "GET", headers: dict[str, str] | None = None, body: str = ""
) -> tuple[int, dict[str, str], str]:
    connection = http.client.HTTPConnection("127.0.0.1", served.port, timeout=10)
    with closing(connection):
        connection.request(method, path, body=body or None, headers=headers or {})
        answer = connection.getresponse()
        lowered = {name.lower(): value for name, value in answer.getheaders()}
        return answer.status, lowered, answer.read().decode()


# -- the page ----------------------------------------------------------------------------------------------------------


def test_the_page_comes_with_a_policy_that_lets_nothing_foreign_in(served: Served) -> None:
    status, headers, text = request(served, "/")
    assert status == 200
    assert "<title>target_nav</title>" in text
    policy = headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "frame-ancestors 'none'" in policy
    assert headers["x-content-type-options"] == "nosniff"


def test_everything_the_page_names_is_served_and_nothing_comes_from_elsewhere(served: Served) -> None:
    _, _, page = request(served, "/")
    named = re.findall(r'(?:href|src)="([^"]+)"', page)
    assert len(named) >= 4
    scripts = [name for name in named if name.endswith(".js")]
    for name in scripts:
        _, _, text = request(served, f"/{name}")
        named += [f"static/js/{each}" for each in re.findall(r'from "\./([^"]+)"', text)]
    for name in named:
        assert not name.startswith(("http", "//")), name
        assert request(served, f"/{name}")[0] == 200, name


def test_a_file_that_the_browser_has_is_not_sent_again(served: Served) -> None:
    _, headers, _ = request(served, "/static/base.css")
    status, _, text = request(served, "/static/base.css", headers={"If-None-Match": headers["etag"]})
    assert (status, text) == (304, "")


@pytest.mark.parametrize(
    "path",
    [
        "/static/../server.py",
        "/static/%2e%2e/server.py",
        "/static//etc/passwd",
        "/static/js/../../access.py",
        "/static/",
    ],
)
def test_no_path_leads_out_of_the_page_s_folder(served: Served, path: str) -> None:
    assert request(served, path)[0] == 404


# -- who may what ------------------------------------------------------------------------------------------------------


def test_a_wrong_token_is_refused_and_logged(served: Served, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING), served.page("not-the-token") as page:
        with pytest.raises(ConnectionClosed):
            page.receive()
        assert page.socket.close_code == 4401
    assert "refused a wrong token from 127.0.0.1" in caplog.text
    assert "not-the-token" not in caplog.text


def test_without_a_token_one_watches_and_moves_nothing(served: Served, ear: Ear) -> None:
    with served.page(token=None) as page:
        assert page.receive()["role"] == "spectator"
        for what in (
            "go",
            "stop",
            "load",
            "mission.save",
            "setting.change",
            "reset_odometry",
            "mission.check",
        ):
            assert "spectator" in page.ask(what)["error"]
        page.hold("forward")
        assert "value" in page.ask("settings")
    assert ear.heard == []


def test_spectators_never_keep_an_operator_out(served: Served, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("target_nav.web.server.MOST_SPECTATORS", 1)
    with served.page(token=None) as first, served.page(token=None) as second, served.page() as operator:
        assert first.views()
        with pytest.raises(ConnectionClosed):
            second.until(lambda _: False)
        assert second.socket.close_code == 4429
        assert operator.receive()["role"] == "operator"


def test_a_program_needs_the_token_to_move_the_robot_and_none_to_look(served: Served, ear: Ear) -> None:
    assert request(served, "/api/status")[0] == 200
    assert request(served, "/api/go", "POST")[0] == 401
    assert request(served, "/api/go", "POST", {"Authorization": "Bearer wrong-token"})[0] == 401
    assert request(served, "/api/status", headers={"Authorization": "Bearer wrong-token"})[0] == 401
    assert ear.heard == []
    status, _, text = request(served, "/api/go", "POST", BEARER)
    assert (status, json.loads(text)["acknowledged"]) == (200, True)
    assert [command.kind for command in ear.heard] == [CommandKind.GO]


@pytest.mark.parametrize("body", ["[1]", "{", "x" * 200_000, '{"a":' * 3000])
def test_a_program_that_talks_nonsense_is_told_so(served: Served, body: str) -> None:
    status, _, text = request(served, "/api/load", "POST", BEARER, body)
    assert status == 400
    assert json.loads(text)["error"]


def test_another_site_s_page_cannot_open_a_connection(served: Served) -> None:
    with pytest.raises(InvalidStatus) as refused, served.page(origin="http://evil.example"):
        pass
    assert refused.value.response.status_code == 403
    with served.page(origin=f"http://127.0.0.1:{served.port}") as page:
        assert page.receive()["role"] == "operator"


def test_a_foreign_name_for_this_machine_is_refused(served: Served) -> None:
    assert request(served, "/", headers={"Host": "evil.example"})[0] == 421
    assert request(served, "/", headers={"Host": "localhost"})[0] == 200


def test_a_port_that_is_taken_is_told(served: Served) -> None:
    with pytest.raises(DeviceError, match="choose another --port"):
        bind("127.0.0.1", served.port)


@pytest.mark.parametrize("message", ["no JSON", "[]", "[" * 5000, '"hello"'])
def test_nonsense_ends_that_connection_and_no_other(served: Served, message: str) -> None:
    with served.page() as other, served.page() as page:
        page.receive()
        page.socket.send(message)
        with pytest.raises(ConnectionClosed):
            page.until(lambda _: False, seeing=False)
        assert page.socket.close_code == 4400
        assert "value" in other.ask("settings")


# -- words -------------------------------------------------------------------------------------------------------------


def test_stop_is_acknowledged_by_who_reads_the_ring(served: Served, ear: Ear) -> None:
    with served.page() as page:
        said = page.ask("stop")["value"]
    assert said["acknowledged"]
    assert said["took_ms"] is not None
    assert [command.kind for command in ear.heard] == [CommandKind.STOP]


def test_stop_that_nobody_reads_is_told_as_not_sent(served: Served) -> None:
    with served.page() as page:
        said = page.ask("stop")["value"]
    assert not said["acknowledged"]
    assert "NOT SENT" in said["text"]


def test_stop_that_is_not_acknowledged_is_told_so_and_said_again(served: Served, ear: Ear) -> None:
    ear.listening = False
    with served.page() as page:
        said = page.ask("stop")["value"]
        assert (said["acknowledged"], said["late"]) == (False, True)
        assert "NOT ACKNOWLEDGED" in said["text"]
        time.sleep(0.6)
        ear.listening = True
        ear.wait_for(lambda heard: len(heard) >= 2, "STOP is said again")
        page.until(lambda m: m.get("t") == "views" and (m.get("said") or {}).get("acknowledged") is True)
    assert {command.kind for command in ear.heard} == {CommandKind.STOP}


def test_a_mission_is_loaded_by_its_name_alone(served: Served, ear: Ear) -> None:
    (served.missions / "one.xml").write_text("<root/>")
    with served.page() as page:
        for name in ("two.xml", "../one.xml", str(served.missions / "one.xml"), "/etc/passwd"):
            assert "no mission" in page.ask("load", mission=name)["error"]
        assert page.ask("load", mission="one.xml")["value"]["acknowledged"]
    assert [(c.kind, c.argument) for c in ear.heard] == [(CommandKind.LOAD, str(served.missions / "one.xml"))]


def test_a_setting_is_saved_sent_and_seen_by_every_page(served: Served, ear: Ear) -> None:
    with served.page() as page, served.page(token=None) as other:
        other.until(lambda m: m.get("versions", {}).get("settings") == 0)
        done = page.ask("setting.change", key="approach.cruise_speed_mps", value=0.2)["value"]
        assert (done["live"], done["said"]["acknowledged"]) == (True, True)
        other.until(lambda m: m.get("versions", {}).get("settings") == 1)
        refused = page.ask("setting.change", key="approach.cruise_speed_mps", value=99)["error"]
        assert "it must lie in 0.02 ... 2 m/s" in refused
    assert "approach.cruise_speed_mps: 0.2" in served.settings_file.read_text()
    assert [(c.kind, c.argument) for c in ear.heard] == [
        (CommandKind.SETTING, "approach.cruise_speed_mps=0.2")
    ]


# -- driving by hand ---------------------------------------------------------------------------------------------------


def manual(ear: Ear) -> list[str]:
    return [command.argument for command in ear.heard if command.kind is CommandKind.MANUAL]


def test_each_word_of_a_hold_is_one_command_and_a_release_is_zero(served: Served, ear: Ear) -> None:
    with served.page() as page:
        page.hold("forward", "turn_left")
        ear.wait_for(lambda heard: len(heard) == 1, "the hold")
        page.hold()
        ear.wait_for(lambda heard: len(heard) == 2, "the release")
        time.sleep(0.3)
    assert manual(ear) == ["0.15,0,0.6", "0,0,0"]


def test_the_server_never_says_a_hold_again_by_itself(served: Served, ear: Ear) -> None:
    with served.page() as page:
        page.hold("forward")
        ear.wait_for(lambda heard: len(heard) == 1, "the hold")
        time.sleep(0.5)
        assert len(ear.heard) == 1


def test_a_page_that_goes_away_while_it_holds_is_released(served: Served, ear: Ear) -> None:
    with served.page() as page:
        page.hold("left")
        ear.wait_for(lambda heard: len(heard) == 1, "the hold")
    ear.wait_for(lambda heard: len(heard) == 2, "the release")
    assert manual(ear) == ["0,0.15,0", "0,0,0"]


def test_a_hold_that_was_held_up_on_its_way_is_not_driven(served: Served, ear: Ear) -> None:
    now_ms = 1e3 * time.monotonic()
    with served.page() as page:
        page.hold("forward", at_ms=now_ms)
        ear.wait_for(lambda heard: len(heard) == 1, "the first hold sets the clock")
        page.hold("back", at_ms=now_ms - 2000)
        page.ask("missions")
        page.hold()
        ear.wait_for(lambda heard: len(heard) == 2, "the release")
    assert manual(ear) == ["0.15,0,0", "0,0,0"]


def test_two_do_not_pull_at_the_same_wheels(served: Served, ear: Ear) -> None:
    with served.page() as one, served.page() as two:
        one.hold("forward")
        ear.wait_for(lambda heard: len(heard) == 1, "the first driver")
        two.hold("back")
        assert "somebody else drives" in two.until(lambda m: m.get("t") == "refused")["why"]
        one.hold()
        ear.wait_for(lambda heard: len(heard) == 2, "the first driver lets go")
        two.hold("back")
        ear.wait_for(lambda heard: len(heard) == 3, "the second driver")
    assert manual(ear)[:3] == ["0.15,0,0", "0,0,0", "-0.15,0,0"]


# -- what is sent ------------------------------------------------------------------------------------------------------


def test_a_page_that_draws_nothing_is_sent_no_more_than_its_credit(served: Served) -> None:
    with served.page(token=None) as slow:
        assert slow.receive()["t"] == "welcome"
        first, second = slow.receive(), slow.receive()
        assert [first["n"], second["n"]] == [1, 2]
        with pytest.raises(TimeoutError):
            slow.receive(timeout_s=0.7)
        looks = served.console.feed.latest.number
        slow.say({"t": "seen", "views": 2, "pictures": 0})
        assert slow.receive()["console"]["now_s"] >= served.console.feed.latest.now_s - 0.5
        assert looks >= 5


def test_pictures_go_to_who_wants_them_one_at_a_time(served: Served, prefix: str) -> None:
    with closing(channels.open_writer(channels.CAMERA, prefix)) as camera, served.page(token=None) as page:
        page.say({"t": "want", "pictures": True, "views": False})
        for number in range(12):
            camera.write(worlds.changed(worlds.PICTURE, stamp_s=time.monotonic(), frame_id=number))
            time.sleep(0.05)
        picture = page.until(lambda m: isinstance(m, bytes))
        assert picture[8:10] == b"\xff\xd8", "a JPEG behind its head"
        with pytest.raises(TimeoutError):
            page.receive(timeout_s=0.6)
        page.say({"t": "seen", "views": 0, "pictures": 1})
        camera.write(worlds.changed(worlds.PICTURE, stamp_s=time.monotonic(), frame_id=99))
        assert page.until(lambda m: isinstance(m, bytes))[:4] == b"\x02\0\0\0"


def test_with_nothing_there_it_stays_up_and_says_what_is_missing(served: Served) -> None:
    with served.page(token=None) as page:
        page.receive()
        seen = page.views()
    assert seen["status"]["headline"] == "NO CONTACT"
    assert "is process nav running?" in seen["status"]["links"][0]["problem"]
    assert seen["camera"]["message"]
    assert seen["radar"]["message"]
    assert seen["tree"]["rows"] == []


def test_what_is_torn_or_of_another_version_is_named(served: Served, prefix: str) -> None:
    Path(f"/dev/shm/{prefix}_nav").write_bytes(b"something else entirely" * 100)
    Path(f"/dev/shm/{prefix}_camera").write_bytes(b"")
    Path(f"/dev/shm/{prefix}_tree").write_bytes(bytes(range(256)) * 64)
    with served.page(token=None) as page:
        page.receive()
        page.until(lambda _: "its maker died early" in page.last.get("camera", {}).get("message", ""))
        assert "not a channel of target_nav" in page.last["tree"]["message"]
        nav = page.last["status"]["links"][0]
        assert (nav["name"], nav["fresh"]) == ("nav", False)
        assert "not a channel of target_nav" in nav["problem"]
        assert page.last["status"]["banner"]


def test_past_ticks_come_back_as_they_were(served: Served, prefix: str) -> None:
    with closing(channels.open_writer(channels.NAV, prefix)) as writer, served.page(token=None) as page:
        for tick in range(10):
            writer.write(worlds.nav(stamp_s=time.monotonic(), tick=tick, running_leaf=f"Leaf{tick}"))
            time.sleep(0.06)
        page.until(lambda m: m.get("marks", {}).get("end", 0) >= 3)
        marks = page.last["marks"]["add"]
        assert [mark[0] for mark in marks] == list(range(marks[0][0], marks[-1][0] + 1))
        assert marks[0][2] == "NAVIGATING"
        frame = page.ask("past", number=1)["value"]["frame"]
        assert frame["status"]["leaf"].startswith("Leaf")
        for number in (1, 2):
            assert set(page.ask("past", number=number)["value"]["frame"]) >= {
                "pose",
                "radar",
                "tree",
                "camera",
            }
        assert "is not kept any more" in page.ask("past", number=10**9)["error"]

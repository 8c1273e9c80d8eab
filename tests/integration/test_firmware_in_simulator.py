"""The robot's own firmware under the whole stack in virtual time, in the place of its imitation."""

from __future__ import annotations

import json

import pytest

from target_nav.app.paths import mission_path
from target_nav.app.virtual import RunResult, run_virtual
from target_nav.sim import simulation
from target_nav.sim.arena import load_arena
from target_nav.sim.host_firmware import HostFirmware
from tests.utils.firmware import built_library

MISSION = mission_path("bowling_pin")
SEED = 3


def run(arena: str) -> RunResult:
    return run_virtual(load_arena(arena), MISSION, SEED)


@pytest.fixture
def firmware(monkeypatch: pytest.MonkeyPatch) -> type[HostFirmware]:
    built_library()
    monkeypatch.setattr(simulation, "FirmwareEmulator", HostFirmware)
    return HostFirmware


@pytest.mark.parametrize("arena", ["open_floor", "pin_behind_boxes"])
def test_the_reference_mission_arrives(firmware: type[HostFirmware], arena: str) -> None:
    result = run(arena)
    assert result.as_expected, result
    assert result.stop_error_m == pytest.approx(0.0, abs=0.05)
    assert not result.collided


def test_the_same_seed_gives_the_same_bytes(firmware: type[HostFirmware]) -> None:
    first, second = run("open_floor"), run("open_floor")
    assert json.dumps(first.as_json(with_trace=True)) == json.dumps(second.as_json(with_trace=True))


def test_it_drives_as_the_imitation_did(monkeypatch: pytest.MonkeyPatch) -> None:
    built_library()
    imitated = run("open_floor")
    monkeypatch.setattr(simulation, "FirmwareEmulator", HostFirmware)
    driven = run("open_floor")
    assert driven.states == imitated.states
    # Rounding differs, and with it every decision a little.
    assert driven.time_s == pytest.approx(imitated.time_s, rel=0.1)
    assert driven.path_m == pytest.approx(imitated.path_m, rel=0.1)

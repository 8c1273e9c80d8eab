"""Every channel carries what it is for, through a real file, to the last bit."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from target_nav.ipc import channels
from target_nav.ipc.channels import Channel
from tests.unit.ipc import values

CARRIED = {
    "camera": values.pictures,
    "sim_camera": values.pictures,
    "detections": values.raw_frames,
    "calibration": values.calibrations,
    "det": values.frames,
    "nav": values.navs,
    "laser": values.lasers,
    "avoid": values.avoids,
    "tree": values.trees,
    "processes": values.process_tables,
}


def test_the_channels_are_those_of_the_reference_the_simulators_camera_and_what_screens_show() -> None:
    reference = {"det", "nav", "laser", "cmd", "camera", "detections", "calibration"}
    assert {channel.name for channel in channels.ALL} == reference | {
        *("sim_camera", "cmd_ack", "avoid", "tree", "processes")
    }
    assert {channel.name for channel in channels.NEWEST_VALUE} == set(CARRIED)


@pytest.mark.parametrize("channel", channels.ALL, ids=lambda c: c.name)
def test_every_payload_begins_with_its_stamp(channel: Channel[Any]) -> None:
    first = channel.codec.layout.members[0]
    assert (first.name, first.of, first.offset) == ("stamp_s", "double", 0)


@pytest.mark.parametrize("channel", channels.ALL, ids=lambda c: c.name)
def test_the_slots_counter_and_the_payloads_numbers_are_aligned(channel: Channel[Any]) -> None:
    for index in range(channel.slot_count):
        assert channel.geometry.slot_at(index) % 64 == 0


@pytest.fixture(scope="module")
def pairs() -> Iterator[dict[str, tuple[Any, Any]]]:
    prefix = f"t{os.getpid()}-channels"
    opened = {
        c.name: (channels.open_writer(c, prefix), channels.open_reader(c, prefix))
        for c in channels.NEWEST_VALUE
    }
    yield opened
    for writer, reader in opened.values():
        writer.close()
        reader.close()
    channels.remove(prefix)


@pytest.mark.parametrize("name", sorted(CARRIED))
@settings(max_examples=40, deadline=None)
@given(data=st.data())
def test_any_value_comes_back_from_shared_memory(pairs, name: str, data: st.DataObject) -> None:
    writer, reader = pairs[name]
    value = data.draw(CARRIED[name])
    writer.write(value)
    assert values.same(reader.take_new(), value)
    assert reader.take_new() is None

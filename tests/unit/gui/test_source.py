"""The reader of shared memory: whatever state it is in, it says so and goes on."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from target_nav.config import Config
from target_nav.gui.model import Model
from target_nav.gui.source import StackReader
from target_nav.ipc import channels
from target_nav.ipc.channels import Channel
from target_nav.ipc.codecs import PlainCodec
from target_nav.state.snapshots import Calibration
from tests.unit.gui import worlds
from tests.unit.ipc.values import same

pytestmark = pytest.mark.linux


@pytest.fixture
def prefix() -> Iterator[str]:
    name = f"t{os.getpid()}-gui-source"
    yield name
    channels.remove(name)


def now_nav() -> object:
    return worlds.nav(stamp_s=time.monotonic())


def test_what_is_written_is_read_with_its_age(prefix: str) -> None:
    reader = StackReader(prefix, Config())
    with (
        channels.open_writer(channels.NAV, prefix) as nav,
        channels.open_writer(channels.LASER, prefix) as laser,
    ):
        value = now_nav()
        nav.write(value)
        laser.write(worlds.changed(worlds.laser(), stamp_s=time.monotonic() - 5.0))
        world = reader.poll(time.monotonic())
    assert same(world.nav.value, value)
    assert world.nav.fresh
    assert not world.laser.fresh
    assert world.laser.age_s > 4.9
    reader.close()


def test_nothing_there_is_told_for_each_channel(prefix: str) -> None:
    world = StackReader(prefix, Config()).poll(time.monotonic())
    for link in world.links:
        assert (link.value, link.age_s, link.fresh) == (None, math.inf, False)
        assert link.name in link.excuse
    assert world.gone == ()


def test_a_writer_that_dies_is_named_by_its_process(prefix: str) -> None:
    with channels.open_writer(channels.NAV, prefix) as nav:
        nav.write(now_nav())
    world = StackReader(prefix, Config()).poll(time.monotonic())
    assert world.gone == ("nav",)
    assert world.nav.value is not None, "its last word stays"


def test_another_version_of_a_layout_is_told_and_found_again_when_it_is_right(prefix: str) -> None:
    reader = StackReader(prefix, Config())
    other: Channel[Calibration] = Channel("nav", PlainCodec(Calibration))
    with channels.open_writer(other, prefix) as writer:
        writer.write(Calibration(time.monotonic(), 1.0, 1.0, 1.0, 1.0, (0.0,) * 5, 0.5, "pin"))
        world = reader.poll(time.monotonic())
        assert world.nav.value is None
        assert "version" in world.nav.excuse
    with channels.open_writer(channels.NAV, prefix) as nav:
        nav.write(now_nav())
        assert reader.poll(time.monotonic()).nav.fresh


@pytest.mark.parametrize("channel", channels.NEWEST_VALUE, ids=lambda c: c.name)
@pytest.mark.parametrize("content", [b"", b"nonsense" * 100, b"\0" * 5000])
def test_a_file_of_nonsense_breaks_no_view(prefix: str, channel: Channel[object], content: bytes) -> None:
    path = Path(f"/dev/shm/{prefix}_{channel.name}")
    path.write_bytes(content)
    model = Model(prefix, Config())
    try:
        for _ in range(3):
            views = model.look(time.monotonic())
        assert views.status.headline == "NO CONTACT"
    finally:
        path.unlink()
        model.close()


def test_a_payload_torn_in_place_is_not_believed(prefix: str) -> None:
    reader = StackReader(prefix, Config())
    with channels.open_writer(channels.NAV, prefix) as nav:
        nav.write(now_nav())
        path = Path(f"/dev/shm/{prefix}_nav")
        with path.open("r+b") as file:
            content = bytearray(file.read())
            # every payload byte of every slot, whatever the layout: the CRC has to notice
            content[512:] = bytes(byte ^ 0x5A for byte in content[512:])
            file.seek(0)
            file.write(content)
        assert reader.poll(time.monotonic()).nav.value is None
        nav.write(now_nav())
        assert reader.poll(time.monotonic()).nav.fresh


def test_pictures_are_read_only_where_they_are_wanted(prefix: str) -> None:
    with channels.open_writer(channels.CAMERA, prefix) as camera:
        frame = worlds.changed(
            worlds.PICTURE, stamp_s=time.monotonic(), image_bgr=np.ones((4, 6, 3), np.uint8)
        )
        camera.write(frame)
        assert StackReader(prefix, Config()).poll(time.monotonic()).camera.fresh
        assert StackReader(prefix, Config(), pictures=False).poll(time.monotonic()).camera.value is None

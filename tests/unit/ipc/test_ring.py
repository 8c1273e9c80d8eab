"""The command ring: order, no loss, nothing old, and STOP above all."""

from __future__ import annotations

import os
import time

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from target_nav.errors import DeviceError
from target_nav.ipc import files, header
from target_nav.ipc.channels import open_command_reader, open_command_writer, open_reader, open_writer, remove
from target_nav.ipc.files import path_of
from target_nav.ipc.header import CRC_AT, lock_busy
from target_nav.ipc.ring import RING_SLOTS, CommandReader, CommandReaderStatistics, CommandWriter
from target_nav.state.types import Command, CommandKind

STOP = Command(1.0, CommandKind.STOP)


def go(number: int) -> Command:
    return Command(float(number), CommandKind.GO, f"number {number}")


def test_commands_arrive_once_and_in_order(prefix: str) -> None:
    with open_command_reader(prefix) as reader, open_command_writer(prefix) as writer:
        assert reader.pop_all() == []
        assert all(writer.push(go(i)) for i in range(3))
        assert reader.pop_all() == [go(0), go(1), go(2)]
        assert reader.pop_all() == []
        assert writer.push(STOP)
        assert reader.pop_all() == [STOP]


def test_the_order_in_which_the_two_are_opened_does_not_matter(prefix: str) -> None:
    with open_command_writer(prefix) as writer, open_command_reader(prefix) as reader:
        assert writer.push(go(1))
        assert reader.pop_all() == [go(1)]


def test_a_command_nobody_would_read_is_refused_and_never_carried_out_later(prefix: str) -> None:
    with open_command_writer(prefix) as writer:
        assert not writer.heard
        assert not writer.push(go(1))
        assert not writer.push(STOP)
        assert writer.statistics.refused_unheard == 2
        with open_command_reader(prefix) as reader:
            assert writer.heard
            assert reader.pop_all() == []


def test_a_reader_does_not_replay_what_a_former_one_left_unread(prefix: str) -> None:
    with open_command_writer(prefix) as writer:
        with open_command_reader(prefix):
            assert writer.push(go(1))
            assert writer.push(go(2))
        with open_command_reader(prefix) as successor:
            assert successor.pop_all() == []
            assert successor.statistics.skipped_old == 2
            assert writer.push(go(3))
            assert successor.pop_all() == [go(3)]
            assert all(writer.push(go(i)) for i in range(RING_SLOTS - 1)), "what was skipped takes no place"


def test_what_is_pushed_while_a_reader_is_just_opening_is_delivered(prefix: str, monkeypatch) -> None:
    with open_command_writer(prefix) as writer:
        opened = []
        take = CommandReader._take

        def push_first(reader: CommandReader) -> list[Command]:
            if not opened:
                opened.append(reader)
                assert writer.push(go(1)), "the reader's claim stands, so this counts as heard"
            return take(reader)

        monkeypatch.setattr(CommandReader, "_take", push_first)
        with open_command_reader(prefix) as reader:
            assert reader.pop_all() == [go(1)]


def test_a_full_ring_refuses_and_tells_and_its_last_place_is_for_stop(prefix: str) -> None:
    with open_command_reader(prefix) as reader, open_command_writer(prefix) as writer:
        pushed = [go(i) for i in range(RING_SLOTS - 1)]
        assert all(writer.push(command) for command in pushed)
        assert not writer.push(go(99))
        assert not writer.push(Command(1.0, CommandKind.PAUSE))
        assert writer.push(STOP)
        assert not writer.push(go(99))
        assert writer.push(STOP), "it is the newest command in there already"
        assert writer.statistics.refused_full == 3
        assert reader.pop_all() == [*pushed, STOP]
        assert writer.push(go(5))
        assert reader.pop_all() == [go(5)]


@settings(max_examples=40, deadline=None)
@given(
    st.lists(
        st.tuples(st.sampled_from([*CommandKind, None, "gui restarts"]), st.integers(1, RING_SLOTS)),
        max_size=12,
    )
)
def test_whatever_happens_accepted_commands_come_in_order_and_a_stop_is_never_overruled(steps) -> None:
    """A refused command may be lost, an accepted one never, and nothing older than a STOP comes after it."""
    prefix = f"t{os.getpid()}-ring-laws"
    accepted: list[Command] = []
    got: list[Command] = []
    newest_stop = -1.0
    number = 0
    with open_command_reader(prefix) as reader:
        writer = open_command_writer(prefix)
        for what, times in steps:
            if what is None:
                got += reader.pop_all()
            elif what == "gui restarts":
                writer.close()
                writer = open_command_writer(prefix)
            else:
                for _ in range(times):
                    number += 1
                    command = Command(float(number), what)
                    full = writer._waiting(writer._mapping) == RING_SLOTS
                    pushed = writer.push(command)
                    assert pushed or what is not CommandKind.STOP
                    if what is CommandKind.STOP:
                        newest_stop = number
                    if pushed and not full:
                        accepted.append(command)
        got += reader.pop_all()
        writer.close()
    remove(prefix)
    assert got == accepted
    if newest_stop >= 0:
        stops = [i for i, command in enumerate(got) if command.kind is CommandKind.STOP]
        assert all(command.stamp_s > newest_stop for command in got[stops[-1] + 1 :])


def test_an_overflow_does_not_outlast_the_reader_that_caused_it(prefix: str) -> None:
    with open_command_writer(prefix) as writer:
        with open_command_reader(prefix):
            while writer.push(go(1)):
                pass
        with open_command_reader(prefix) as successor:
            assert writer.push(go(2))
            assert successor.pop_all() == [go(2)]


# Processes that come and go


def test_commands_of_a_gui_that_has_gone_are_still_delivered(prefix: str) -> None:
    with open_command_reader(prefix) as reader:
        for i in range(3):
            with open_command_writer(prefix) as writer:
                assert writer.push(go(i))
        assert reader.pop_all() == [go(0), go(1), go(2)]


def test_a_gui_killed_in_mid_push_costs_that_push_only(prefix: str) -> None:
    with open_command_reader(prefix) as reader:
        writer = open_command_writer(prefix)
        assert writer.push(go(1))
        at = writer._mapping.geometry.slot_at(writer._sequence % RING_SLOTS)
        writer._mapping.words[at // 4] = lock_busy(writer._sequence)
        writer._mapping.view[at + CRC_AT : at + 60] = bytes(range(56))
        writer.close()
        with open_command_writer(prefix) as successor:
            assert successor.statistics.repaired == 1
            assert successor.push(go(2))
        assert reader.pop_all() == [go(1), go(2)]


def test_a_ring_that_was_removed_is_made_again_and_followed(prefix: str) -> None:
    with open_command_reader(prefix) as reader, open_command_writer(prefix) as writer:
        assert writer.push(go(1))
        assert reader.pop_all() == [go(1)]
        path_of(prefix, "cmd").unlink()
        assert writer.push(go(2))
        assert reader.pop_all() == [go(2)]
        assert reader.statistics.reopened == 1
        path_of(prefix, "cmd_ack").unlink()
        assert not writer.push(go(3)), "the reader's answer has gone, until it reads again"
        assert reader.pop_all() == []
        assert writer.push(go(4))
        assert reader.pop_all() == [go(4)]


def test_a_second_live_gui_and_a_second_live_nav_process_are_refused(prefix: str) -> None:
    with open_command_reader(prefix), open_command_writer(prefix):
        with pytest.raises(DeviceError, match=f"writes {prefix}_cmd; stop it"):
            open_command_writer(prefix)
        with pytest.raises(DeviceError, match=f"commands can have one reader: .* writes {prefix}_cmd_ack"):
            open_command_reader(prefix)


def test_prefixes_do_not_hear_each_other(prefix: str) -> None:
    other = f"{prefix}_b"
    with (
        open_command_reader(prefix) as one,
        open_command_reader(other) as two,
        open_command_writer(other) as writer,
    ):
        assert writer.push(go(1))
        assert one.pop_all() == []
        assert two.pop_all() == [go(1)]


# Bad input and damage


def test_an_argument_that_is_too_long_is_refused_for_half_a_setting_is_another_one(prefix: str) -> None:
    with open_command_reader(prefix) as reader, open_command_writer(prefix) as writer:
        assert writer.push(Command(1.0, CommandKind.GO, "x" * 255))
        with pytest.raises(DeviceError, match=r"argument .* is 256 bytes long \(limit 255\)"):
            writer.push(Command(1.0, CommandKind.GO, "x" * 256))
        assert len(reader.pop_all()) == 1


def test_what_is_no_command_is_refused(prefix: str) -> None:
    wanted = r"PushedCommand\.command is .*; it must be a Command"
    with (
        open_command_reader(prefix),
        open_command_writer(prefix) as writer,
        pytest.raises(DeviceError, match=wanted),
    ):
        writer.push(Command(1.0, 99))


def test_a_damaged_command_is_counted_and_passed_over(prefix: str) -> None:
    with open_command_reader(prefix) as reader, open_command_writer(prefix) as writer:
        for i in range(3):
            assert writer.push(go(i))
        at = writer._mapping.geometry.slot_at((writer._sequence - 2) % RING_SLOTS)
        writer._mapping.view[at + 40] ^= 1
        assert reader.pop_all() == [go(0), go(2)]
        assert reader.statistics.crc_errors > 0


def test_the_ring_is_not_opened_as_a_newest_value_channel(prefix: str) -> None:
    from target_nav.ipc.channels import ALL

    for channel in ALL[-2:]:
        with pytest.raises(TypeError, match="use open_command_writer or open_command_reader"):
            open_writer(channel, prefix)
        with pytest.raises(TypeError, match="use open_command_writer or open_command_reader"):
            open_reader(channel, prefix)


def test_a_closed_writer_says_so_and_a_closed_reader_is_not_heard(prefix: str) -> None:
    writer, reader = open_command_writer(prefix), open_command_reader(prefix)
    reader.close()
    assert not writer.push(go(1))
    writer.close()
    with pytest.raises(DeviceError, match=f"{prefix}_cmd is closed"):
        writer.push(go(1))


@pytest.mark.parametrize("modulus", [2**31, 2**32])
def test_counters_wrap_without_a_lost_or_repeated_command(prefix: str, modulus: int, monkeypatch) -> None:
    now_ns = time.monotonic_ns()
    start = (now_ns // modulus + 1) * modulus - 10
    monkeypatch.setattr(time, "monotonic_ns", lambda: start)
    with open_command_reader(prefix) as reader, open_command_writer(prefix) as writer:
        assert writer._sequence == start
        for i in range(30):
            assert writer.push(go(i))
            assert reader.pop_all() == [go(i)]
        assert reader.statistics == CommandReaderStatistics(accepted=30)


def test_a_ring_of_another_layout_with_a_live_writer_is_an_error_for_the_reader(prefix: str) -> None:
    writer = CommandWriter(path_of(prefix, "cmd"), path_of(prefix, "cmd_ack"))
    writer._mapping.words[header.word("layout_version")] = 9
    with pytest.raises(DeviceError, match="has layout version 9"):
        open_command_reader(prefix)
    writer.close()
    with open_command_reader(prefix) as reader:
        assert reader.pop_all() == []
    assert not files.is_claimed(path_of(prefix, "cmd_ack"))

"""Commands reach their handler in order, and nothing overtakes a STOP."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.state.dispatcher import CommandDispatcher
from target_nav.state.types import Command, CommandKind

K = CommandKind


def handled(kinds: list[CommandKind]) -> list[CommandKind]:
    seen: list[CommandKind] = []
    CommandDispatcher({kind: lambda c: seen.append(c.kind) for kind in K}).dispatch(
        Command(0.0, k) for k in kinds
    )
    return seen


def test_commands_are_handled_in_order() -> None:
    assert handled([K.GO, K.PAUSE, K.RESUME]) == [K.GO, K.PAUSE, K.RESUME]


def test_a_stop_voids_what_was_asked_before_it() -> None:
    assert handled([K.GO, K.PAUSE, K.STOP]) == [K.STOP]


def test_a_go_after_a_stop_counts() -> None:
    assert handled([K.STOP, K.GO]) == [K.STOP, K.GO]


def test_odometry_is_reset_even_before_a_stop() -> None:
    assert handled([K.RESET_ODOM, K.GO, K.STOP]) == [K.RESET_ODOM, K.STOP]


@given(st.lists(st.sampled_from(K)))
def test_the_last_stop_is_never_lost(kinds: list[CommandKind]) -> None:
    seen = handled(kinds)
    assert (K.STOP in seen) == (K.STOP in kinds)
    assert seen.count(K.STOP) <= 1


def test_a_missing_handler_is_told_at_once() -> None:
    with pytest.raises(ValueError, match="no handler for STOP, RESET_ODOM, PAUSE, RESUME"):
        CommandDispatcher({K.GO: lambda c: None})

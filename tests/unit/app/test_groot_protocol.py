"""Groot2's protocol, byte by byte."""

from __future__ import annotations

import json
from contextlib import suppress
from uuid import UUID

import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.app.groot_monitor_protocol import (
    HookMode,
    HookState,
    Kind,
    NodeStatus,
    ProtocolError,
    Request,
    parse_hook,
    parse_request,
    reply_header,
    request_header,
    status_bytes,
    transition_bytes,
)

TREE = UUID(int=0x000102030405060708090A0B0C0D0E0F)


def test_a_question_is_six_bytes_and_perhaps_a_second_part() -> None:
    assert parse_request([b"\x02T\xd2\x04\x00\x00"]) == Request(Kind.FULL_TREE, 1234)
    assert parse_request([b"\x02B\x01\x00\x00\x00", b"Main"]) == Request(Kind.BLACKBOARD, 1, b"Main")


def test_an_answer_repeats_the_question_and_names_the_tree() -> None:
    request = parse_request([b"\x02S\xd2\x04\x00\x00"])
    assert reply_header(request, TREE) == b"\x02S\xd2\x04\x00\x00" + bytes(range(16))


@given(st.sampled_from(Kind), st.integers(0, 2**32 - 1))
def test_a_header_that_was_written_is_read_back(kind: Kind, number: int) -> None:
    assert parse_request([request_header(kind, number)]) == Request(kind, number)


@pytest.mark.parametrize(
    ("parts", "why"),
    [
        ([], "wrong request header"),
        ([b"abc"], "wrong request header"),
        ([b"\x02Q\x00\x00\x00\x00"], "Request not recognized"),
    ],
)
def test_what_is_no_question_is_refused_as_there(parts: list[bytes], why: str) -> None:
    with pytest.raises(ProtocolError, match=why):
        parse_request(parts)


@given(st.binary(max_size=12), st.binary(max_size=8))
def test_whatever_comes_is_a_question_or_refused(first: bytes, second: bytes) -> None:
    with suppress(ProtocolError):
        parse_request([first, second])


def test_statuses_are_three_bytes_a_node() -> None:
    assert status_bytes({1: NodeStatus.RUNNING, 258: 12}) == b"\x01\x00\x01\x02\x01\x0c"


def test_transitions_are_nine_bytes_each() -> None:
    assert (
        transition_bytes([(0x010203040506, 7, NodeStatus.FAILURE)]) == b"\x06\x05\x04\x03\x02\x01\x07\x00\x03"
    )


@given(
    st.builds(
        HookState,
        uid=st.integers(0, 65535),
        mode=st.sampled_from(HookMode),
        once=st.booleans(),
        enabled=st.booleans(),
        desired_status=st.sampled_from(NodeStatus),
        position=st.sampled_from([0, 1]),
    )
)
def test_a_hook_survives_json(hook: HookState) -> None:
    assert parse_hook(json.loads(json.dumps(hook.as_json()))) == hook


@pytest.mark.parametrize(
    "change", [{"uid": "x"}, {"mode": 7}, {"desired_status": "DONE"}, {"desired_status": None}]
)
def test_a_hook_that_is_none_is_refused(change: dict[str, object]) -> None:
    with pytest.raises(ProtocolError, match="a hook cannot be read"):
        parse_hook(HookState(1).as_json() | change)
    with pytest.raises(ProtocolError):
        parse_hook([])

"""Tokens, names and origins."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.errors import ConfigError
from target_nav.web.access import Access, Role

TOKEN = "correct-horse"
ACCESS = Access(TOKEN)


def test_a_token_is_random_unless_given_and_long_enough() -> None:
    assert Access().token != Access().token
    assert len(Access().token) >= 20
    with pytest.raises(ConfigError, match="8 or more"):
        Access("short")


def test_the_right_token_operates_none_watches_any_other_is_refused() -> None:
    access = Access(TOKEN)
    assert access.role(TOKEN, "peer") is Role.OPERATOR
    assert access.role(None, "peer") is Role.SPECTATOR
    assert access.role("", "peer") is Role.SPECTATOR
    assert access.role("correct-hors", "peer") is None


@given(st.text(alphabet="corethsCORE-\0 ä", min_size=1, max_size=20).filter(lambda text: text != TOKEN))
def test_no_other_text_is_the_token(text: str) -> None:
    assert ACCESS.role(text, "peer") is not Role.OPERATOR


@pytest.mark.parametrize(
    ("header", "role"),
    [
        (f"Bearer {TOKEN}", Role.OPERATOR),
        (f"bearer  {TOKEN}", Role.OPERATOR),
        (None, Role.SPECTATOR),
        ("", Role.SPECTATOR),
        (f"Basic {TOKEN}", None),
        ("Bearer nothing-like-it", None),
    ],
)
def test_programs_show_it_as_a_bearer(header: str | None, role: Role | None) -> None:
    assert Access(TOKEN).bearer_role(header, "peer") is role


@pytest.mark.parametrize(
    ("host", "ours"),
    [
        ("127.0.0.1:8642", True),
        ("[::1]:8642", True),
        ("192.168.1.20", True),
        ("localhost:1", True),
        ("robot7:8642", True),
        ("evil.example", False),
        ("127.0.0.1.evil.example", False),
        ("", False),
        (None, False),
    ],
)
def test_a_host_is_an_address_or_a_name_of_this_machine(host: str | None, ours: bool) -> None:
    assert Access(TOKEN, names=("Robot7",)).host_is_ours(host) is ours


@pytest.mark.parametrize(
    ("origin", "ours"),
    [
        ("http://127.0.0.1:8642", True),
        (None, True),
        ("http://127.0.0.1:8643", False),
        ("http://evil.example", False),
        ("null", False),
        ("file://", False),
        ("http://127.0.0.1:8642.evil.example", False),
    ],
)
def test_a_page_is_ours_when_it_came_from_the_address_it_speaks_to(origin: str | None, ours: bool) -> None:
    assert Access(TOKEN).origin_is_ours(origin, "127.0.0.1:8642") is ours

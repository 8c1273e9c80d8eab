"""A label comes apart into what it was made of."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.errors import ConfigError
from target_nav.state.target_label import TargetDetector, is_scaled_by_width, make_label, split_label

NAMES = st.text(st.characters(exclude_characters=":"), min_size=1, max_size=20)


@given(st.sampled_from(TargetDetector), NAMES)
def test_a_label_comes_apart_into_what_it_was_made_of(detector: TargetDetector, what: str) -> None:
    assert split_label(make_label(detector, what)) == (detector, what)


def test_the_networks_label_is_the_class_alone() -> None:
    assert make_label(TargetDetector.network, "bowling_pin") == "bowling_pin"


@pytest.mark.parametrize("what", ["", "a:b"])
def test_nothing_to_look_for_is_refused(what: str) -> None:
    with pytest.raises(ConfigError):
        make_label(TargetDetector.colour, what)


def test_only_two_boxes_are_scaled_by_their_gap() -> None:
    assert is_scaled_by_width("two_boxes:green")
    assert not is_scaled_by_width("colour:green")
    assert not is_scaled_by_width("two_boxes")

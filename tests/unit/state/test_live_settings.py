"""Which settings a running nav process takes, in which words, and the number by which a screen sees that it did."""

from __future__ import annotations

import pytest

from target_nav.config import Config
from target_nav.errors import ConfigError
from target_nav.state.live_settings import fingerprint, is_live, setting_text, with_setting

KEYS = [key for key, _, _ in Config().items()]


@pytest.mark.parametrize("key", [key for key in KEYS if is_live(key)])
def test_every_live_key_goes_there_and_back_and_changes_the_fingerprint(key: str) -> None:
    config = Config()
    values = {k: (value, meta) for k, value, meta in config.items()}
    value, meta = values[key]
    other = meta["low"] if value != meta["low"] else meta["high"]
    changed = with_setting(config, setting_text(key, other))
    assert {k: v for k, v, _ in changed.items()}[key] == other
    assert fingerprint(changed) != fingerprint(config)
    assert fingerprint(with_setting(changed, setting_text(key, value))) == fingerprint(config)


def test_what_shapes_a_device_a_filter_or_the_body_needs_a_restart() -> None:
    for key in (
        "serial.port",
        "ipc.prefix",
        "lidar.x_m",
        "camera.focal_px",
        "robot.front_m",
        "track.gate_sigma",
    ):
        assert not is_live(key)
        value = {k: v for k, v, _ in Config().items()}[key]
        with pytest.raises(ConfigError, match="restart"):
            with_setting(Config(), setting_text(key, value))


def test_every_key_that_names_a_live_one_exists() -> None:
    from target_nav.state import live_settings

    assert set(KEYS) >= live_settings._LIVE_KEYS
    assert {key.split(".")[0] for key in KEYS} >= live_settings._LIVE_SECTIONS

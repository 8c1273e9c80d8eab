"""Which keys of the configuration may change in a running nav process, and the words in which they do.

Safe is what only the limiter and skills that begin later look at: speeds, distances, weights, limits of age. The
limiter takes a change in its next tick, a skill when its leaf begins the next time. Everything else shapes something
that lives as long as its process (a filter, a histogram, a device) and needs a restart.
"""

from __future__ import annotations

import json
import zlib

from target_nav.config import Config
from target_nav.errors import ConfigError

_LIVE_SECTIONS = frozenset({"approach", "search", "arrival", "manual"})
_LIVE_KEYS = frozenset(
    {
        "robot.max_speed_mps", "robot.max_lateral_speed_mps", "robot.max_yaw_rate_radps", "robot.max_accel_mps2",
        "robot.max_decel_mps2", "robot.max_yaw_accel_radps2", "robot.min_speed_mps", "robot.min_yaw_rate_radps",
        "avoid.margin_m", "avoid.look_ahead_m", "avoid.stop_clearance_m", "avoid.slow_clearance_m",
        "avoid.cost_target", "avoid.cost_heading", "avoid.cost_previous",
        "loop.scan_max_age_s", "loop.odom_max_age_s", "loop.camera_max_age_s",
    }
)  # fmt: skip


def is_live(key: str) -> bool:
    """Whether a running nav process takes a change of this key; otherwise a restart is needed."""
    return key in _LIVE_KEYS or key.split(".", 1)[0] in _LIVE_SECTIONS


def setting_text(key: str, value: object) -> str:
    """The argument of a SETTING command."""
    return f"{key}={json.dumps(value)}"


def with_setting(config: Config, argument: str) -> Config:
    """`config` with the change that a SETTING command asks for.

    Raises:
        ConfigError: not `key=value`, a key that needs a restart, or a value outside its limits.
    """
    key, equals, text = argument.partition("=")
    try:
        value = json.loads(text)
    except json.JSONDecodeError:
        equals = ""
    if not equals:
        raise ConfigError(
            f"{argument!r} is no setting; it must be key=value, as in approach.stand_off_m=0.12"
        )
    changed = config.override({key: value}, source="setting")
    if not is_live(key):
        raise ConfigError(f"{key} is taken when the processes start; save it and restart them")
    return changed


def fingerprint(config: Config) -> int:
    """A number that two configurations share if they agree in all that can change in a running process."""
    live = [(key, value) for key, value, _ in config.items() if is_live(key)]
    return zlib.crc32(repr(live).encode())

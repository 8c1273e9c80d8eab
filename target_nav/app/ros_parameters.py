"""Every key of the configuration as a ROS parameter: `--ros-args -p lidar.rate_hz:=10.0`."""

from __future__ import annotations

from typing import Any

from target_nav.config import Config


def config_from_parameters(node: Any, config: Config) -> Config:
    """Declares a parameter per key, with `config` as defaults, and gives back what the parameters say.

    The parameters are read-only afterwards: a configuration does not change under a running tree.

    Raises:
        ConfigError: a value outside its limits or of the wrong type.
    """
    from rcl_interfaces.msg import ParameterDescriptor

    values: dict[str, object] = {}
    for key, default, metadata in config.items():
        unit = metadata.get("unit", "")
        limits = f" [{metadata['low']:g} ... {metadata['high']:g} {unit}]" if "low" in metadata else ""
        descriptor = ParameterDescriptor(
            description=f"{metadata['doc']}{limits}",
            read_only=True,
            # a person writes 10 for 10.0; Config.override checks type and limits, and says more
            dynamic_typing=True,
        )
        value = node.declare_parameter(key, default, descriptor).value
        if value != default:
            values[key] = value
    return config.override(values, source="ROS parameter")

"""The errors this project raises on purpose.

A message has the value, the limit and what to look at next. What can happen in the world (a target lost, a way
blocked) is never an exception: it is a leaf's FAILURE.
"""

from __future__ import annotations


class TargetNavError(Exception):
    """Base of every error this project raises on purpose."""


class ConfigError(TargetNavError):
    """A configuration or an arena that cannot be used: unknown key, wrong type, value outside its limits."""


class MissionError(TargetNavError):
    """A mission file that cannot be ticked. The text has one `file:line:column: error: ...` line per problem."""


class DeviceError(TargetNavError):
    """A device, port, channel or process that is not there, is somebody else's, or answers nonsense."""


class StaleInput(TargetNavError):
    """An input that is older than its limit."""

"""Packages that only some of the commands need: asked for by name before they are used."""

from __future__ import annotations

import importlib.util

from target_nav.errors import DeviceError


def require_extra(package: str, extra: str) -> None:
    """Raise a DeviceError that says how to install it, unless `package` can be imported."""
    if importlib.util.find_spec(package) is None:
        raise DeviceError(
            f"this needs the package {package}, which is not installed; scripts/start.sh installs it, "
            f"or pip install 'target_nav[{extra}]'"
        )

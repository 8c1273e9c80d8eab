"""Scripts run on a dictionary."""

from __future__ import annotations

from typing import Any

from target_nav.mission.script import bind, check_kinds, parse_script


class Entry:
    """An entry of a dictionary as scripts use it."""

    has_type = False

    def __init__(self, values: dict[str, Any], name: str) -> None:
        self._values = values
        self._name = name

    @property
    def exists(self) -> bool:
        return self._name in self._values

    def read(self) -> Any:
        return self._values[self._name]

    def write(self, value: Any) -> Any:
        self._values[self._name] = value
        return value


def value_of(text: str, values: dict[str, Any] | None = None, enums: dict[str, int] | None = None) -> Any:
    """What a script returns; it changes `values`."""
    store = {} if values is None else values
    script = parse_script(text)
    check_kinds(script, enums or {}, decides=False)
    return bind(script, lambda name: Entry(store, name), enums or {})()


def after(text: str, **values: Any) -> dict[str, Any]:
    """What a script leaves behind."""
    value_of(text, values)
    return values

"""A frozen dataclass of `target_nav.state` <-> a C struct, derived from the dataclass's own type hints.

The dataclass is the only declaration: a field added to it is in shared memory, in the C++ header and in the layout's
fingerprint without another line. float is double, int is int64_t, bool is bool, text is a NUL-terminated char array,
an enum is its number, a fixed tuple is an array, a dataclass is a struct, and `X | None` is a flag `has_x` before it.
"""

from __future__ import annotations

import dataclasses
import operator
import struct
import types
import typing
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum, IntEnum
from typing import Any, Generic, TypeVar

from target_nav.errors import DeviceError
from target_nav.ipc.cstruct import CStruct, Member, declare

T = TypeVar("T")
Buffer = bytes | bytearray | memoryview

TEXT_BYTES = {
    "class_name": 48,
    "argument": 256,
    "running_leaf": 64,
    "limited_by": 64,
    "reason": 256,
    "mission": 64,
    "notice": 160,
    "name": 64,
    "word": 48,
    "feedback": 128,
    "condition": 32,
}
"""Bytes of a text field by its name, the closing NUL included."""

CUT = frozenset(
    {"running_leaf", "limited_by", "reason", "mission", "notice", "name", "word", "feedback", "condition"}
)
"""Texts for people, cut at a whole character when too long. Any other text means something, so too long is an error."""


@dataclass(frozen=True)
class Node:
    """One field: its members in C, the values it flattens to, and the way back."""

    members: tuple[Member, ...]
    blank: tuple[Any, ...]
    flatten: Callable[[Any], Sequence[Any]]
    build: Callable[..., Any]
    """(flat values, index of the first, further arguments of a dataclass) -> the field's value."""

    plain: bool = False
    """One value that is packed as it is."""

    @property
    def width(self) -> int:
        return len(self.blank)


class Record(Generic[T]):
    """Packs and unpacks one dataclass.

    `tail` names its last field when another codec stores that one (a bounded array); `extra` are that codec's members.
    """

    def __init__(self, of: type[T], tail: str = "", extra: Sequence[Member] = ()) -> None:
        self.type = of
        self._fields = _fields(of, tail)
        self._node = _dataclass_node(of, self._fields)
        members = [member for _, node in self._fields for member in node.members]
        self.layout: CStruct = declare(of.__name__, [*members, *extra])
        self._struct = struct.Struct(self.layout.format(extra[0].name if extra else ""))
        self.size = self._struct.size

    def pack_into(self, buffer: bytearray, at: int, value: T) -> None:
        """Raises DeviceError naming the field, its value and the limit."""
        try:
            self._struct.pack_into(buffer, at, *self._node.flatten(value))
        except (struct.error, AttributeError, TypeError, ValueError) as error:
            raise DeviceError(self._explain(value, error)) from error

    def unpack_from(self, buffer: Buffer, at: int = 0, *tail: object) -> T:
        """The dataclass at `at`, with `tail` for the field that was left out."""
        built: T = self._node.build(self._struct.unpack_from(buffer, at), 0, *tail)
        return built

    def _explain(self, value: T, error: Exception) -> str:
        for name, node in self._fields:
            held = getattr(value, name, None)
            try:
                struct.pack(declare("probe", node.members).format(), *node.flatten(held))
            except (struct.error, AttributeError, TypeError, ValueError):
                wanted = _wanted(node.members)
                return f"{self.type.__name__}.{name} is {held!r}; it must be {wanted}; look at whoever filled it in"
        return f"{self.type.__name__} cannot be written: {error}"


def _wanted(members: Sequence[Member]) -> str:
    words = {"double": "a number", "int64_t": "a whole number in -2^63 ... 2^63 - 1", "bool": "true or false"}
    member = members[-1]
    if member.of == "double" and member.count > 1:
        return f"{member.count} numbers"
    return words.get(member.type_name, f"a {member.type_name} of numbers")


def _fields(of: type[Any], tail: str) -> list[tuple[str, Node]]:
    hints = typing.get_type_hints(of)
    names = [spec.name for spec in dataclasses.fields(of)]
    if tail and names[-1] != tail:
        raise TypeError(f"{of.__name__}.{tail} must be the last field to be left out")
    return [(name, _node(name, hints[name])) for name in names if name != tail]


def _node(name: str, hint: Any) -> Node:
    arguments = typing.get_args(hint)
    if typing.get_origin(hint) in (typing.Union, types.UnionType):
        (inner,) = [argument for argument in arguments if argument is not type(None)]
        return _optional_node(name, _node(name, inner))
    if typing.get_origin(hint) is tuple:
        return _array_node(name, len(arguments))
    if isinstance(hint, type):
        if dataclasses.is_dataclass(hint):
            return _nested_node(name, hint)
        if issubclass(hint, Enum):
            return _enum_node(name, hint)
        if hint in _SCALAR:
            member, blank = _SCALAR[hint]
            return Node(
                (Member(name, member),), (blank,), lambda value: (value,), lambda values, i: values[i]
            )
        if hint is str:
            return _text_node(name)
    raise TypeError(f"{name}: {hint} has no place in shared memory; see target_nav/ipc/records.py")


_SCALAR: dict[type, tuple[str, Any]] = {float: ("double", 0.0), int: ("int64_t", 0), bool: ("bool", False)}


def _text_node(name: str) -> Node:
    limit = TEXT_BYTES[name]
    cut = name in CUT

    def flatten(value: Any) -> tuple[bytes]:
        if not isinstance(value, str):
            raise DeviceError(f"{name} is {value!r}; it must be text")
        # A NUL would end the text early in C, and a lone surrogate has no UTF-8.
        raw = value.replace("\0", " ").encode("utf-8", "replace")
        if len(raw) >= limit:
            if not cut:
                raise DeviceError(
                    f"{name} {value[:60]!r}... is {len(raw)} bytes long (limit {limit - 1}); use a shorter one"
                )
            raw = raw[: limit - 1].decode("utf-8", "ignore").encode()
        return (raw,)

    def build(values: Sequence[Any], i: int) -> str:
        text: bytes = values[i]
        return text.split(b"\0", 1)[0].decode("utf-8", "replace")

    return Node((Member(name, "char", limit),), (b"",), flatten, build)


def _enum_node(name: str, of: type[Enum]) -> Node:
    numbers = enum_numbers(of)
    members = {number: member for member, number in numbers.items()}

    def flatten(value: Any) -> tuple[int]:
        return (numbers[of(value)],)

    def build(values: Sequence[Any], i: int) -> Enum:
        try:
            return members[values[i]]
        except KeyError:
            raise DeviceError(
                f"{name} is {values[i]} in shared memory; {of.__name__} knows {sorted(members)}; restart the writer"
            ) from None

    meaning = " ".join(f"{member.name}={number}" for member, number in numbers.items())
    return Node((Member(name, "int32_t", meaning=meaning),), (0,), flatten, build)


def enum_numbers(of: type[Enum]) -> dict[Enum, int]:
    """An IntEnum's own numbers; any other enum is counted from 0."""
    return {m: int(m.value) if issubclass(of, IntEnum) else i for i, m in enumerate(of)}


def _array_node(name: str, count: int) -> Node:
    def flatten(value: Any) -> tuple[Any, ...]:
        if len(value) != count:
            raise ValueError(f"{len(value)} values instead of {count}")
        return tuple(value)

    def build(values: Sequence[Any], i: int) -> tuple[Any, ...]:
        return tuple(values[i : i + count])

    return Node((Member(name, "double", count),), (0.0,) * count, flatten, build)


def _nested_node(name: str, of: type[Any]) -> Node:
    fields = _fields(of, "")
    inner = _dataclass_node(of, fields)
    layout = declare(of.__name__, [member for _, node in fields for member in node.members])
    return Node((Member(name, layout),), inner.blank, inner.flatten, inner.build)


def _optional_node(name: str, inner: Node) -> Node:
    def flatten(value: Any) -> Sequence[Any]:
        return (False, *inner.blank) if value is None else (True, *inner.flatten(value))

    def build(values: Sequence[Any], i: int) -> Any:
        return inner.build(values, i + 1) if values[i] else None

    members = (Member(f"has_{name}", "bool"), *inner.members)
    return Node(members, (False, *inner.blank), flatten, build)


def _dataclass_node(of: type[Any], fields: Sequence[tuple[str, Node]]) -> Node:
    # None stands for a field that is one value as it is, which most are: no call for those.
    flatteners = [None if node.plain else node.flatten for _, node in fields]
    builders, at = [], 0
    for _, node in fields:
        builders.append((None if node.plain else node.build, at))
        at += node.width
    all_plain = all(node.plain for _, node in fields)
    get = [name for name, _ in fields]
    values_of = operator.attrgetter(*get) if len(get) > 1 else lambda value: (getattr(value, get[0]),)

    def flatten(value: Any) -> Sequence[Any]:
        flat: list[Any] = []
        for inner, held in zip(flatteners, values_of(value)):
            if inner is None:
                flat.append(held)
            else:
                flat += inner(held)
        return flat

    def build(values: Sequence[Any], i: int, *tail: object) -> Any:
        if all_plain:
            return of(*values[i : i + at], *tail)
        built = [values[i + k] if inner is None else inner(values, i + k) for inner, k in builders]
        return of(*built, *tail)

    return Node((), tuple(value for _, node in fields for value in node.blank), flatten, build)

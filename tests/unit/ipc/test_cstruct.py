"""Offsets are those of a C compiler, for which numpy's aligned dtypes are the witness."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.ipc import channels
from target_nav.ipc.cstruct import CStruct, Member, declare
from target_nav.ipc.header import FILE_HEADER, SLOT_HEADER

NUMPY = {
    "double": "f8",
    "int64_t": "i8",
    "uint64_t": "u8",
    "int32_t": "i4",
    "uint32_t": "u4",
    "uint8_t": "u1",
    "bool": "?",
    "char": "S1",
}

scalars = st.tuples(st.sampled_from(sorted(NUMPY)), st.integers(1, 5))


def build(kinds: list[tuple[object, int]], name: str = "S") -> CStruct:
    return declare(name, [Member(f"m{i}", of, count) for i, (of, count) in enumerate(kinds)])


structs = st.recursive(
    st.lists(scalars, min_size=1, max_size=6).map(build),
    lambda inner: st.lists(scalars | st.tuples(inner, st.integers(1, 3)), min_size=1, max_size=4).map(build),
    max_leaves=6,
)


def numpy_dtype(of: CStruct) -> np.dtype:
    fields = [
        (m.name, numpy_dtype(m.of) if isinstance(m.of, CStruct) else NUMPY[m.of], (m.count,))
        for m in of.members
    ]
    return np.dtype(fields, align=True)


@given(structs)
def test_offsets_and_sizes_are_those_of_an_aligned_numpy_dtype(layout: CStruct) -> None:
    witness = numpy_dtype(layout)
    assert layout.size == witness.itemsize
    assert [m.offset for m in layout.members] == [witness.fields[m.name][1] for m in layout.members]


@given(structs)
def test_the_packing_format_covers_the_struct_to_its_last_padding_byte(layout: CStruct) -> None:
    assert struct.calcsize(layout.format()) == layout.size


@pytest.mark.parametrize(
    "layout", [FILE_HEADER, SLOT_HEADER, *(c.codec.layout for c in channels.ALL)], ids=lambda s: s.name
)
def test_every_layout_in_use_lies_as_numpy_aligns_it(layout: CStruct) -> None:
    assert layout.size == numpy_dtype(layout).itemsize


def test_a_format_may_end_before_a_member() -> None:
    layout = build([("bool", 1), ("double", 4)])
    assert struct.calcsize(layout.format("m1")) == layout["m1"].offset == 8


def test_any_change_of_a_layout_changes_its_fingerprint() -> None:
    layout = build([("double", 1), ("int64_t", 2)])
    others = [
        build([("double", 1), ("int64_t", 3)]),
        build([("double", 1), ("uint64_t", 2)]),
        build([("int64_t", 2), ("double", 1)]),
        build([("double", 1), ("int64_t", 2)], name="T"),
        declare("S", [Member("m0", "double"), Member("renamed", "int64_t", 2)]),
        declare("S", [Member("m0", "double"), Member("m1", "int64_t", 2, meaning="GO=1")]),
    ]
    assert len({layout.fingerprint, *(other.fingerprint for other in others)}) == 7


def test_an_unknown_member_is_named() -> None:
    with pytest.raises(KeyError, match="FileHeader has no member colour"):
        FILE_HEADER["colour"]

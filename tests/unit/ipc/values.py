"""Any value a channel may be given, for hypothesis, and an equality that takes NaN for equal to NaN."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from target_nav.ipc.records import TEXT_BYTES
from target_nav.state.snapshots import (
    AvoidSnapshot,
    Calibration,
    CameraFrame,
    LaserSnapshot,
    NavSnapshot,
    NodeStatus,
    ProcessRow,
    ProcessTable,
    TreeRow,
    TreeState,
)
from target_nav.state.types import (
    Command,
    CommandKind,
    Detection,
    DetectionFrame,
    Facing,
    NavState,
    Outcome,
    OutcomeKind,
    Pose2D,
    RawDetection,
    RawDetectionFrame,
    TargetSpec,
    Track,
    Twist2D,
)

numbers = st.floats(allow_nan=True, allow_infinity=True)
stamps = st.floats(min_value=0.0, max_value=1e9)
whole = st.integers(-(2**63), 2**63 - 1)


def texts(field: str) -> st.SearchStrategy[str]:
    """Texts of any script that fit the field; NUL and lone surrogates have no place in a C string of UTF-8."""
    letters = st.characters(exclude_characters="\0", exclude_categories=("Cs",))
    return st.text(letters, max_size=(TEXT_BYTES[field] - 1) // 4)


poses = st.builds(Pose2D, numbers, numbers, numbers)
twists = st.builds(Twist2D, numbers, numbers, numbers)
outcomes = st.builds(Outcome, st.sampled_from(OutcomeKind), texts("reason"))
specs = st.builds(TargetSpec, texts("class_name"), numbers, numbers)
tracks = st.builds(
    Track,
    *(numbers, numbers, numbers, st.tuples(numbers, numbers, numbers, numbers), st.booleans(), whole),
    *(numbers, numbers, numbers, numbers, st.none() | numbers, st.none() | numbers),
)
facings = st.none() | st.builds(Facing, numbers, numbers)
raw_detections = st.builds(RawDetection, texts("class_name"), *[numbers] * 5, facings, facings)
detections = st.builds(
    Detection,
    *(texts("class_name"), numbers, whole, *[numbers] * 8, st.booleans(), st.booleans(), facings, facings),
)
raw_frames = st.builds(RawDetectionFrame, stamps, whole, st.lists(raw_detections, max_size=5).map(tuple))
frames = st.builds(DetectionFrame, stamps, whole, st.lists(detections, max_size=5).map(tuple))
navs = st.builds(
    NavSnapshot,
    *(stamps, whole, st.sampled_from(NavState), st.none() | outcomes, texts("running_leaf"), texts("reason")),
    *(st.booleans(), poses, twists, texts("limited_by"), st.none() | tracks, specs),
    *(numbers, numbers, numbers, numbers, numbers, whole),
    *(texts("mission"), st.booleans(), st.booleans(), whole, texts("notice"), whole),
)
calibrations = st.builds(
    Calibration, stamps, *[numbers] * 4, st.tuples(*[numbers] * 5), numbers, texts("class_name")
)
lasers = st.builds(
    LaserSnapshot,
    stamps,
    poses,
    hnp.arrays(np.float64, st.tuples(st.integers(0, 40), st.just(2)), elements=numbers),
)
avoids = st.builds(
    AvoidSnapshot,
    *(stamps, poses, st.booleans(), numbers, numbers, st.booleans(), st.integers(0, 40)),
    hnp.arrays(np.float64, st.tuples(st.integers(0, 40), st.just(2)), elements=numbers),
)
tree_rows = st.builds(
    TreeRow,
    *(texts("name"), texts("word"), whole, st.sampled_from(NodeStatus), st.booleans(), texts("feedback")),
)
trees = st.builds(TreeState, stamps, whole, whole, st.lists(tree_rows, max_size=5).map(tuple))
process_rows = st.builds(ProcessRow, texts("name"), texts("condition"), whole, whole)
process_tables = st.builds(ProcessTable, stamps, st.lists(process_rows, max_size=5).map(tuple))
pictures = st.builds(
    CameraFrame,
    stamps,
    whole,
    hnp.arrays(np.uint8, st.tuples(st.integers(1, 9), st.integers(1, 9), st.just(3))),
)
commands = st.builds(Command, stamps, st.sampled_from(CommandKind), texts("argument"))


def same(left: Any, right: Any) -> bool:
    """Equal in every field, type and shape; NaN equals NaN."""
    if dataclasses.is_dataclass(left):
        return type(left) is type(right) and all(
            same(getattr(left, field.name), getattr(right, field.name)) for field in dataclasses.fields(left)
        )
    if isinstance(left, np.ndarray):
        return (
            left.shape == right.shape and left.dtype == right.dtype and left.tobytes() == right.tobytes()
            if left.dtype == np.uint8
            else left.shape == right.shape and np.array_equal(left, right, equal_nan=True)
        )
    if isinstance(left, tuple):
        return len(left) == len(right) and all(same(a, b) for a, b in zip(left, right))
    if isinstance(left, float):
        return isinstance(right, float) and (left == right or (left != left and right != right))
    return type(left) is type(right) and bool(left == right)


def detection(score: float = 0.9, track_id: int = 1) -> Detection:
    return Detection(
        "bowling_pin", score, track_id, 320.0, 240.0, 20.0, 70.0, 2.2, 0.08, 0.01, 0.01, False, True
    )


def frame(frame_id: int, stamp_s: float = 10.0) -> DetectionFrame:
    return DetectionFrame(stamp_s, frame_id, (detection(track_id=frame_id),))


def picture(frame_id: int, shape: tuple[int, int] = (6, 8)) -> CameraFrame:
    return CameraFrame(10.0, frame_id, np.full((*shape, 3), frame_id % 251, np.uint8))

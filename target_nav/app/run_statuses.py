"""What a recorded tree looked like at a moment of its run."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from target_nav.app.recording import RecordingError, RunHeader, read_run


@dataclass(frozen=True)
class RecordedTick:
    """`at_s` counts from the run's first tick. `statuses` is by path, of behaviours that it passed through."""

    at_s: float
    state: str
    leaf: str
    reason: str
    statuses: dict[str, str]


def recording_in(run: Path) -> Path:
    """A recording by its own path, or by that of the run's folder."""
    return run / "run.mcap" if run.is_dir() else run


def tick_at(path: Path, at_s: float | None) -> tuple[RunHeader, RecordedTick]:
    """The run's header, and the last tick that was not later than `at_s` after its first one; the last of all for None.

    Raises:
        RecordingError: not a recording, one without ticks, or a time outside of it.
    """
    header, ticks = read_run(path)
    begin_s = math.nan
    found: RecordedTick | None = None
    last_s = 0.0
    for inputs, decision in ticks:
        if math.isnan(begin_s):
            begin_s = inputs.now_s
        last_s = inputs.now_s - begin_s
        # ticks are at sums of decimal fractions: 12.35 s may be 12.3500001
        if at_s is not None and last_s > at_s + 1e-6:
            break
        found = RecordedTick(
            last_s, decision["state"], decision["leaf"] or "", decision["reason"] or "", decision["statuses"]
        )
    else:
        if at_s is not None and at_s > last_s + 1.0:
            raise RecordingError(f"{path}: {at_s:g} s is after its end; it lasts {last_s:.2f} s")
    if found is None:
        if math.isnan(begin_s):
            raise RecordingError(f"{path}: holds no ticks")
        raise RecordingError(f"{path}: {at_s:g} s is before its begin; it lasts from 0 s on")
    return header, found


@contextmanager
def mission_of(header: RunHeader) -> Iterator[Path]:
    """The mission that was recorded, as files in a folder that is gone afterwards.

    Raises:
        RecordingError: the recording names a file outside of its folder.
    """
    with tempfile.TemporaryDirectory(prefix="target_nav_run_") as name:
        folder = Path(name).resolve()
        for file, content in header.files.items():
            path = (folder / file).resolve()
            if not path.is_relative_to(folder):
                raise RecordingError(f"the recording names a file outside of its folder: {file!r}")
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(content, encoding="utf-8")
        yield folder / header.mission

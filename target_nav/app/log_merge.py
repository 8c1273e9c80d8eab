"""Many processes' logs as one file: each process writes its own, this reads on and copies.

Files and not pipes: a supervisor that is busy or gone must never block a process that wants to say something.
"""

from __future__ import annotations

import re
from collections import deque
from pathlib import Path

_TIME = re.compile(r"\d\d:\d\d:\d\d\.\d{3}")

MAX_CHUNK_BYTES = 1 << 20


class LogMerger:
    """`pump` copies what is new since the last call into `merged`, ordered by the time each line begins with.

    A line without a time (a traceback) stays behind the line it follows. `recent` keeps the newest lines for a view.
    """

    def __init__(self, sources: dict[str, Path], merged: Path, recent: int = 200) -> None:
        self._sources = sources
        self._merged = merged
        self._offsets = dict.fromkeys(sources, 0)
        self._partial = dict.fromkeys(sources, b"")
        self._times = dict.fromkeys(sources, "")
        self._width = max((len(name) for name in sources), default=0)
        self.recent: deque[str] = deque(maxlen=recent)

    def pump(self, final: bool = False) -> None:
        """Copy the new whole lines; with `final` also a last line that has no end."""
        rows: list[tuple[str, str]] = []
        for name, path in self._sources.items():
            for line in self._new_lines(name, path, final):
                found = _TIME.match(line)
                if found:
                    self._times[name] = found.group()
                rows.append((self._times[name], f"{name:<{self._width}} | {line}"))
        if not rows:
            return
        rows.sort(key=lambda row: row[0])
        texts = [text for _, text in rows]
        self.recent.extend(texts)
        with self._merged.open("a", encoding="utf-8") as out:
            out.write("\n".join(texts) + "\n")

    def _new_lines(self, name: str, path: Path, final: bool) -> list[str]:
        try:
            with path.open("rb") as source:
                if source.seek(0, 2) < self._offsets[name]:
                    # logrotate has emptied it.
                    self._offsets[name], self._partial[name] = 0, b""
                source.seek(self._offsets[name])
                data = source.read(MAX_CHUNK_BYTES)
        except FileNotFoundError:
            return []
        self._offsets[name] += len(data)
        *whole, rest = (self._partial[name] + data).split(b"\n")
        if final and rest:
            whole, rest = [*whole, rest], b""
        self._partial[name] = rest
        return [line.decode("utf-8", errors="replace") for line in whole]


def last_lines(path: Path, count: int) -> list[str]:
    """The last lines of a log, none if there is no such file."""
    try:
        with path.open("rb") as source:
            source.seek(0, 2)
            source.seek(max(source.tell() - 200 * count - 1000, 0))
            text = source.read().decode("utf-8", errors="replace")
    except FileNotFoundError:
        return []
    return text.splitlines()[-count:]

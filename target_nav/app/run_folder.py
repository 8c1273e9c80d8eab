"""`runs/<stamp>/`: everything one run leaves behind."""

from __future__ import annotations

import json
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class RunFolder:
    path: Path

    @property
    def picture(self) -> Path:
        return self.path / "run.png"

    @property
    def numbers(self) -> Path:
        return self.path / "result.json"

    @property
    def log(self) -> Path:
        return self.path / "run.log"

    @property
    def recording(self) -> Path:
        return self.path / "run.mcap"

    @property
    def truth(self) -> Path:
        return self.path / "truth.json"

    def write_numbers(self, data: dict[str, Any]) -> None:
        self.numbers.write_text(json.dumps(data, indent=2) + "\n", encoding="utf-8")


def make_run_folder(parent: Path) -> RunFolder:
    """A new folder named by the local time; a second run in the same second gets a number behind it."""
    stamp = time.strftime("%Y%m%d-%H%M%S")
    for n in range(1000):
        path = parent / (stamp if n == 0 else f"{stamp}-{n}")
        try:
            path.mkdir(parents=True)
        except FileExistsError:
            continue
        latest = parent / "latest"
        latest.unlink(missing_ok=True)
        latest.symlink_to(path.name)
        return RunFolder(path)
    raise FileExistsError(f"{parent} holds a thousand runs of {stamp}")

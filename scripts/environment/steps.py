"""Steps of the set-up: shown while they run, logged, done once, and by one process at a time."""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
STATE = ROOT / ".cache" / "setup"
LOG = STATE / "setup.log"


class SetupError(Exception):
    """Something the user has to mend; the message says what."""


class Progress:
    """Steps with elapsed seconds: a line that counts on a terminal, start and end lines anywhere else."""

    def __init__(self, total: int) -> None:
        self.total, self.number, self.text = total, 0, ""
        self.live = sys.stdout.isatty() and os.environ.get("TERM", "dumb") != "dumb"
        self.began = self.told = time.monotonic()

    def step(self, text: str) -> None:
        self.number += 1
        self.text = f"[setup {self.number}/{self.total}] {text}"
        self.began = self.told = time.monotonic()
        print(self.text, end="" if self.live else " ...\n", flush=True)

    def tick(self) -> None:
        now = time.monotonic()
        if self.live:
            print(f"\r{self.text} ... {now - self.began:.0f} s", end="", flush=True)
        elif now - self.told > 10.0:
            self.told = now
            print(f"{self.text} ... still at it after {now - self.began:.0f} s", flush=True)

    def done(self, note: str) -> None:
        start = "\r\033[K" if self.live else ""
        print(f"{start}{self.text}: {time.monotonic() - self.began:.1f} s, {note}", flush=True)


def run(
    command: Sequence[str | Path], progress: Progress, what: str, hint: str, env: dict[str, str] | None = None
) -> None:
    """Run with the output in the log; SetupError with its last lines when it fails."""
    words = [str(part) for part in command]
    with LOG.open("ab") as log:
        log.write(f"\n$ {' '.join(words)}\n".encode())
        log.flush()
        start = log.tell()
        child = subprocess.Popen(
            words, stdin=subprocess.DEVNULL, stdout=log, stderr=log, env=env or clean_environ(), cwd=ROOT
        )
        try:
            while child.poll() is None:
                with contextlib.suppress(subprocess.TimeoutExpired):
                    child.wait(timeout=0.5)
                progress.tick()
        finally:
            if child.poll() is None:
                child.terminate()
                child.wait()
    if child.returncode != 0:
        tail = LOG.read_bytes()[start:].decode(errors="replace").strip().splitlines()[-12:]
        raise SetupError("\n    ".join([f"{what} failed (exit {child.returncode}).", *tail]) + f"\n  {hint}")


def clean_environ() -> dict[str, str]:
    """This process's variables without those of another environment that was active around it."""
    env = {k: v for k, v in os.environ.items() if k not in ("VIRTUAL_ENV", "PYTHONHOME", "CONDA_PREFIX")}
    # The ROS wheels re-execute Python once with LD_LIBRARY_PATH set, and mark that; a child with the mark but in
    # another environment would look for its libraries in the wrong place.
    if env.pop("_ROS_WHEELS_BOOTSTRAP_COMPLETE", None):
        env.pop("LD_LIBRARY_PATH", None)
    return env


def output_of(python: str | Path, code: str) -> str | None:
    """What the interpreter prints for the code; None when it does not run or ends in an error."""
    try:
        done = subprocess.run(
            [str(python), "-c", code],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=60,
            env=clean_environ(),
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    return done.stdout if done.returncode == 0 else None


def digest(*parts: Path | str) -> str:
    """Hash of texts, files and whole folders (names and contents)."""
    sha = hashlib.sha256()
    for part in parts:
        if isinstance(part, str):
            sha.update(part.encode() + b"\0")
            continue
        files = sorted(part.rglob("*")) if part.is_dir() else [part]
        for file in files:
            if file.is_file() and "__pycache__" not in file.parts:
                sha.update(str(file.relative_to(ROOT)).encode() + b"\0" + file.read_bytes() + b"\0")
    return sha.hexdigest()[:20]


@contextlib.contextmanager
def exclusive(name: str) -> Iterator[None]:
    """One set-up of an environment at a time; the lock goes with its process, so nothing is left to clean up."""
    STATE.mkdir(parents=True, exist_ok=True)
    with (STATE / f"{name}.lock").open("w") as handle:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            print("[setup] another set-up of this checkout is running; waiting for it", flush=True)
            fcntl.flock(handle, fcntl.LOCK_EX)
        yield


def once(venv: Path, fingerprint: dict[str, str], steps: Callable[[bool], None]) -> None:
    """Run the steps unless the environment's stamp says that they were done with this fingerprint.

    `steps` is told whether it has to begin with a new environment: when the interpreter or the place is another
    one, and when there is no stamp, for then an earlier run was interrupted and what it left cannot be trusted.
    """
    stamp = venv / ".target_nav.json"
    try:
        old = json.loads(stamp.read_text())
    except (OSError, ValueError):
        old = {}
    if old == fingerprint:
        return
    stamp.unlink(missing_ok=True)
    LOG.write_text("")
    steps(any(old.get(key) != value for key, value in fingerprint.items() if key != "inputs"))
    stamp.write_text(json.dumps(fingerprint, indent=1) + "\n")

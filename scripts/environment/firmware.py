"""The robot's firmware as a library for the simulator, brought up to date at every set-up: 20 ms when it is."""

from __future__ import annotations

import subprocess

from environment.steps import LOG, ROOT, SetupError, clean_environ

SCRIPT = ROOT / "deploy" / "firmware" / "build-host.sh"
NO_COMPILER = 2
"""The script's exit code."""


def provide() -> None:
    """Build it if its sources have changed. Without a compiler it is left out: only the simulator needs it.

    Raises:
        SetupError: it does not compile.
    """
    done = subprocess.run(
        ["sh", str(SCRIPT)], stdin=subprocess.DEVNULL, capture_output=True, text=True, env=clean_environ()
    )
    if done.returncode == NO_COMPILER:
        print(f"[setup] the simulator's firmware is left out: {done.stderr.strip()}", flush=True)
    elif done.returncode != 0:
        with LOG.open("a") as log:
            log.write(done.stdout + done.stderr)
        tail = "\n    ".join(done.stderr.strip().splitlines()[-12:])
        raise SetupError(f"The firmware for the simulator does not compile:\n    {tail}\n  {SCRIPT}")

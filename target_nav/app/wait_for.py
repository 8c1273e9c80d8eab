"""Waits for a file and then becomes a command: what makes a process of a launch file wait for another one.

Run as a file by a bare interpreter: `python -I -S wait_for.py FILE TIMEOUT_S COMMAND...`. The supervisor, which starts
processes itself, does without it.
"""

from __future__ import annotations

import os
import sys
import time

POLL_S = 0.05
EXIT_FAILED = 1  # as in process.py, which cannot be imported here
EXIT_CANNOT_RUN = 2


def wait_for(file: str, timeout_s: float, command: list[str]) -> int:
    """Become `command` once `file` exists. Returns an exit code if it does not in time, or cannot be run."""
    deadline_s = time.monotonic() + timeout_s
    while not os.path.exists(file):
        if time.monotonic() > deadline_s:
            print(
                f"{file} did not appear within {timeout_s:g} s; see what was started before", file=sys.stderr
            )
            return EXIT_FAILED
        time.sleep(POLL_S)
    try:
        os.execvp(command[0], command)
    except OSError as error:
        print(f"{command[0]} cannot be run: {error.strerror}", file=sys.stderr)
        return EXIT_CANNOT_RUN


if __name__ == "__main__":
    try:
        sys.exit(wait_for(sys.argv[1], float(sys.argv[2]), sys.argv[3:]))
    except KeyboardInterrupt:
        sys.exit(0)

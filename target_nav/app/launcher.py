"""What happens in a supervised process before its program: dies with the supervisor, takes its core and niceness.

Run as a file by a bare interpreter (`python -I -S launcher.py PARENT CORE NICE COMMAND...`), which then becomes the
command. Not a `preexec_fn`: Python code between fork and exec of a process with threads can deadlock.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys

PR_SET_PDEATHSIG = 1  # <sys/prctl.h>
EXIT_CANNOT_RUN = 2  # as in process.py, which cannot be imported here
NONE = "-"


def launch(parent: int, core: str, nice: str, command: list[str]) -> None:
    """Become `command`. Returns only by raising or exiting."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        sys.exit(EXIT_CANNOT_RUN)  # The supervisor died before the line above.
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGPIPE):
        signal.signal(number, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_SETMASK, ())
    if core != NONE:
        try:
            os.sched_setaffinity(0, {int(core)})
        except OSError as error:
            print(f"core {core} not granted: {error.strerror}", file=sys.stderr)
    if nice != NONE:
        try:
            os.setpriority(os.PRIO_PROCESS, 0, int(nice))
        except OSError as error:
            print(
                f"nice {nice} not granted: {error.strerror}; see LimitNICE or CAP_SYS_NICE", file=sys.stderr
            )
    sys.stderr.flush()
    try:
        os.execvp(command[0], command)
    except OSError as error:
        print(f"{command[0]} cannot be run: {error.strerror}", file=sys.stderr, flush=True)
        sys.exit(EXIT_CANNOT_RUN)


if __name__ == "__main__":
    launch(int(sys.argv[1]), sys.argv[2], sys.argv[3], sys.argv[4:])

"""A program for test_supervisor.py: a supervisor with three processes, polled until it is told to end.

`python -m tests.integration.supervised_program RUN_DIR [deaf]`
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

from target_nav.app.process_spec import ProcessSpec, ReadyWhen
from target_nav.app.supervisor import StackState, Supervisor

WORKER = 'echo $$ >> {pids}; touch "$TARGET_NAV_READY_FILE"; exec sleep 1000'
DEAF_WORKER = "trap '' INT TERM; {worker}"


def main(run_dir: Path, deaf: bool) -> int:
    worker = WORKER.format(pids=run_dir / "pids")
    if deaf:
        worker = DEAF_WORKER.format(worker=worker)
    specs = [
        ProcessSpec(name, ("/bin/sh", "-c", worker), ready=ReadyWhen.REPORTED, stop_timeout_s=60.0)
        for name in "abc"
    ]
    try:
        with Supervisor(specs, run_dir) as supervisor:
            while True:
                if supervisor.poll() is StackState.RUNNING:
                    (run_dir / "running").touch()
                time.sleep(0.02)
    except KeyboardInterrupt:
        (run_dir / "stopped").touch()
        return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), "deaf" in sys.argv[2:]))

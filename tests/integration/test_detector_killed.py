"""A whole mission in the full stack, with pixels, while somebody keeps killing the detector."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
import uuid
from pathlib import Path

import pytest

from target_nav.ipc import channels

KILLS = 3
KILL_EVERY_S = 5.0
LIMIT_S = 240.0


@pytest.mark.ros
@pytest.mark.slow
@pytest.mark.linux
@pytest.mark.timeout(300)
def test_the_mission_goes_on_though_the_detector_is_killed(tmp_path: Path) -> None:
    prefix = f"t{uuid.uuid4().hex[:10]}"
    result = tmp_path / "result.json"
    with (tmp_path / "out.txt").open("wb") as out:
        run = subprocess.Popen(
            [
                *(sys.executable, "-m", "target_nav.app.cli", "run", "--sim", "open_floor", "--headless"),
                *("--prefix", prefix, "--out", str(tmp_path / "runs"), "--json", str(result)),
            ],
            stdout=out,
            stderr=subprocess.STDOUT,
        )
    killed: list[int] = []
    try:
        next_s = time.monotonic()
        deadline_s = next_s + LIMIT_S
        while run.poll() is None and time.monotonic() < deadline_s:
            pid = detector_of(prefix)
            if len(killed) < KILLS and pid is not None and pid not in killed and time.monotonic() > next_s:
                os.kill(pid, signal.SIGKILL)
                killed.append(pid)
                next_s = time.monotonic() + KILL_EVERY_S
            time.sleep(0.05)
        text = (tmp_path / "out.txt").read_text()
        assert run.poll() == 0, text
    finally:
        run.send_signal(signal.SIGINT)
        run.wait(timeout=30.0)
        for file in Path("/dev/shm").glob(f"{prefix}_*"):
            file.unlink()
    assert len(killed) == KILLS
    data = json.loads(result.read_text())
    assert data["outcome"] == "succeeded"
    assert data["success"] is True
    camera_log = (tmp_path / "runs" / "latest" / "logs" / "camera.log").read_text()
    assert "was ended by SIGKILL and is started again" in camera_log


def detector_of(prefix: str) -> int | None:
    """The live writer of the boxes."""
    (status,) = [s for s in channels.describe(prefix) if s.name == "detections"]
    return status.writer_pid if status.exists and status.alive else None

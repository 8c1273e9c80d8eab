"""Who may write a channel's file, and what is said when something else stands there."""

from __future__ import annotations

import errno
import fcntl
import os
import subprocess
import sys
from pathlib import Path

import pytest

from target_nav.errors import ConfigError, DeviceError
from target_nav.ipc import files, header
from target_nav.ipc.channels import CAMERA, DET, NAV, open_reader, open_writer, remove
from target_nav.ipc.files import path_of
from tests.unit.ipc.values import frame, picture

HOLD = """
import sys
from target_nav.ipc import channels
writer = channels.open_writer(channels.DET, sys.argv[1])
print("claimed", flush=True)
sys.stdin.read()
"""


def poke(path: Path, member: str, value: int) -> None:
    with path.open("r+b") as file:
        file.seek(header.FILE_HEADER[member].offset)
        file.write(value.to_bytes(4, "little"))


# One writer


def test_a_second_writer_is_refused_with_channel_pid_and_advice(prefix: str) -> None:
    with open_writer(DET, prefix):
        with pytest.raises(DeviceError) as refusal:
            open_writer(DET, prefix)
        assert str(refusal.value) == (
            f"another instance (pid {os.getpid()}) writes {prefix}_det; stop it or choose another prefix (ipc.prefix)"
        )
        open_writer(NAV, prefix).close()
    open_writer(DET, prefix).close()


def test_a_writer_in_another_process_is_named_and_its_claim_dies_with_it(prefix: str) -> None:
    holder = subprocess.Popen(
        [sys.executable, "-c", HOLD, prefix], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    try:
        assert holder.stdout.readline() == "claimed\n"
        with pytest.raises(DeviceError, match=rf"\(pid {holder.pid}\) writes {prefix}_det"):
            open_writer(DET, prefix)
    finally:
        holder.kill()
        holder.wait()
        holder.stdout.close()
        holder.stdin.close()
    open_writer(DET, prefix).close()


def test_a_lock_on_a_file_that_lost_its_name_meanwhile_is_no_claim(
    prefix: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, flock = path_of(prefix, "det"), fcntl.flock
    open_writer(DET, prefix).close()

    def renamed_before(descriptor: int, operation: int) -> None:
        monkeypatch.setattr(fcntl, "flock", flock)
        path.unlink()
        path.write_bytes(b"")
        flock(descriptor, operation)

    monkeypatch.setattr(fcntl, "flock", renamed_before)
    with open_writer(DET, prefix) as writer, open_reader(DET, prefix) as reader:
        assert files.is_claimed(path)
        writer.write(frame(1))
        assert reader.latest() == frame(1)
        assert writer.statistics.reclaimed == 0


def test_asking_whether_a_writer_lives_takes_no_claim_away(prefix: str) -> None:
    path = path_of(prefix, "det")
    assert not files.is_claimed(path)
    with open_writer(DET, prefix):
        assert files.is_claimed(path)
    assert not files.is_claimed(path)


# Other layouts


@pytest.mark.parametrize(("member", "value"), [("layout_version", 7), ("layout_hash", 0xABCD)])
def test_a_reader_that_meets_a_live_writer_of_another_layout_says_both_versions(
    prefix: str, member: str, value: int
) -> None:
    with open_writer(DET, prefix), open_reader(DET, prefix) as reader:
        poke(path_of(prefix, "det"), member, value)
        ours = DET.geometry.layout_hash
        version, found = (7, ours) if member == "layout_version" else (header.LAYOUT_VERSION, 0xABCD)
        with pytest.raises(DeviceError) as refusal:
            reader.latest()
        assert str(refusal.value) == (
            f"{prefix}_det has layout version {version} (hash {found:08x}), this program reads version "
            f"{header.LAYOUT_VERSION} (hash {ours:08x}); its writer (pid {os.getpid()}) is of another build: "
            "stop it, and start both from the "
            "same one"
        )


def test_a_leftover_of_another_layout_is_not_there_for_a_reader_and_is_replaced_by_a_writer(
    prefix: str,
) -> None:
    with open_writer(DET, prefix) as writer:
        writer.write(frame(1))
    path = path_of(prefix, "det")
    poke(path, "layout_version", 7)
    inode = path.stat().st_ino
    with open_reader(DET, prefix) as reader:
        assert reader.latest() is None
        with open_writer(DET, prefix) as writer:
            assert path.stat().st_ino != inode
            assert reader.latest() is None
            writer.write(frame(2))
            assert reader.latest() == frame(2)


def test_a_reader_with_the_old_layout_mapped_hears_of_the_new_one(prefix: str) -> None:
    with open_reader(DET, prefix) as reader:
        with open_writer(DET, prefix) as writer:
            writer.write(frame(1))
            assert reader.latest() == frame(1)
        path_of(prefix, "det").unlink()
        with open_writer(DET, prefix):
            poke(path_of(prefix, "det"), "layout_version", 7)
            with pytest.raises(DeviceError, match="has layout version 7"):
                reader.latest()


def test_a_file_of_another_size_is_replaced_not_resized(prefix: str) -> None:
    open_writer(DET, prefix).close()
    path = path_of(prefix, "det")
    inode = path.stat().st_ino
    with path.open("ab") as file:
        file.write(bytes(100))
    with open_reader(DET, prefix) as reader:
        assert reader.latest() is None
        open_writer(DET, prefix).close()
        assert path.stat().st_ino != inode
        assert path.stat().st_size == DET.geometry.file_bytes


@pytest.mark.parametrize("left", [b"", bytes(8), bytes(4096), header.MAGIC + bytes(100)])
def test_a_file_its_maker_never_finished_is_finished_by_the_next_writer(prefix: str, left: bytes) -> None:
    path_of(prefix, "det").write_bytes(left)
    with open_reader(DET, prefix) as reader:
        assert reader.latest() is None
        with open_writer(DET, prefix) as writer:
            writer.write(frame(1))
            assert reader.latest() == frame(1)


def test_somebody_elses_file_is_left_alone(prefix: str) -> None:
    path = path_of(prefix, "det")
    path.write_bytes(b"seq_start" + bytes(100))
    message = f"{path} is not a channel of target_nav .*remove it or choose another prefix"
    with pytest.raises(DeviceError, match=message):
        open_writer(DET, prefix)
    with open_reader(DET, prefix) as reader, pytest.raises(DeviceError, match=message):
        reader.latest()
    assert remove(prefix) == []
    assert path.read_bytes().startswith(b"seq_start")


def test_a_link_is_not_followed(prefix: str, tmp_path: Path) -> None:
    path_of(prefix, "det").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(DeviceError, match=f"{prefix}_det: "):
        open_writer(DET, prefix)
    assert not (tmp_path / "elsewhere").exists()


# What the system refuses


def test_shared_memory_that_is_full_says_how_much_is_missing(
    prefix: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(descriptor: int, offset: int, length: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    with open_writer(CAMERA, prefix) as writer:
        monkeypatch.setattr(os, "posix_fallocate", full)
        with pytest.raises(
            DeviceError, match=r"_camera: No space left on device; 3.7 MB wanted, .* --shm-size"
        ):
            writer.write(picture(1, (480, 640)))
    with pytest.raises(DeviceError, match=f"{prefix}_det: No space left on device"):
        open_writer(DET, prefix)


def test_a_machine_without_shared_memory_says_so(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(files, "SHM_DIRECTORY", tmp_path / "nowhere")
    with pytest.raises(DeviceError, match="No such file or directory; is shared memory mounted at /dev/shm"):
        open_writer(DET, "x")
    assert open_reader(DET, "x").latest() is None


def test_another_users_file_is_explained(monkeypatch: pytest.MonkeyPatch, prefix: str) -> None:
    def refused(path: object, flags: int, mode: int = 0o777) -> int:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(os, "open", refused)
    with pytest.raises(DeviceError, match="Permission denied; it belongs to another user"):
        open_writer(DET, prefix)
    with pytest.raises(DeviceError, match="Permission denied; it belongs to another user"):
        open_reader(DET, prefix).latest()


@pytest.mark.parametrize("bad", ["", "a/b", "../etc", "_x", "v2n_sim", "x" * 65, "a b", "a\n"])
def test_a_prefix_that_is_no_name_is_refused(bad: str) -> None:
    with pytest.raises(ConfigError, match=r"ipc.prefix is .*; it must be 1 to 64 letters"):
        open_writer(DET, bad)
    with pytest.raises(ConfigError, match=r"ipc\.prefix"):
        open_reader(DET, bad)


def test_remove_takes_what_nobody_writes(prefix: str) -> None:
    open_writer(NAV, prefix).close()
    with open_writer(DET, prefix):
        assert remove(prefix) == [f"{prefix}_nav"]
        assert path_of(prefix, "det").exists()
    assert remove(prefix) == [f"{prefix}_det"]
    assert remove(prefix) == []

"""Shared memory beside what else could carry a value from one process to another.

Peers: the reference's own protocol (counter, payload, counter; fast and torn), pickles through a multiprocessing pipe
or queue, JSON through a Unix socket, and a pickle in a mapped file under `flock`.
"""

from __future__ import annotations

import fcntl
import json
import mmap
import multiprocessing
import os
import pickle
import socket
import statistics
import struct
import time
import zlib
from collections.abc import Callable
from dataclasses import asdict
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import OURS, Row, time_call
from target_nav.ipc import channels
from target_nav.ipc.codecs import pixel_sum
from target_nav.state.snapshots import CameraFrame, LaserSnapshot
from target_nav.state.types import Command, CommandKind, Detection, DetectionFrame, FloatArray, Pose2D

PREFIX = f"bench{os.getpid()}"
HANDOVERS = 300
TORN_S = 2.0


def run() -> list[Row]:
    try:
        return [
            *hand_over_detections(5),
            *hand_over_detections(64),
            *hand_over_pictures(),
            *guards_of_a_picture(),
            *small_calls(),
            *latency_between_processes(),
            *torn_values(),
        ]
    finally:
        channels.remove(PREFIX)
        for path in Path("/dev/shm").glob(f"{PREFIX}_*"):
            path.unlink()


def detections(number: int, frame_id: int = 1) -> DetectionFrame:
    # All different: a pickle stores an object it has met before as a reference.
    boxes = [
        Detection("pin", i / 64, i, 1.5 * i, 240.0 + i, 20.0, 70.0, i / 9, 0.08, i / 7, 0.01, False, True)
        for i in range(number)
    ]
    return DetectionFrame(time.monotonic(), frame_id, tuple(boxes))


def picture(frame_id: int = 1) -> CameraFrame:
    image = np.random.default_rng(frame_id).integers(0, 255, (480, 640, 3), np.uint8)
    return CameraFrame(time.monotonic(), frame_id, image)


def microseconds(function: Callable[[], object]) -> float:
    return 1e6 * time_call(function)


# Write and read one value, in one process: the cost without the waiting


def hand_over_detections(number: int) -> list[Row]:
    task = f"{number} detections, write + read"
    value = detections(number)
    with (
        channels.open_writer(channels.DET, PREFIX) as writer,
        channels.open_reader(channels.DET, PREFIX) as reader,
    ):

        def ours() -> None:
            writer.write(value)
            assert reader.take_new() is not None

        return [
            Row(task, OURS, microseconds(ours), "us", "typed, verified"),
            Row(task, "pipe", microseconds(through_pipe(value)), "us", "multiprocessing.Pipe, pickle"),
            Row(
                task, "socket", microseconds(through_socket(value)), "us", "Unix datagram, JSON, left a dict"
            ),
            Row(
                task,
                "flock",
                microseconds(through_flock(value)),
                "us",
                "mmap, pickle, readers block the writer",
            ),
        ]


def through_pipe(value: object) -> Callable[[], object]:
    receiving, sending = multiprocessing.Pipe(duplex=False)

    def hand_over() -> object:
        sending.send(value)
        return receiving.recv()

    return hand_over


def through_socket(value: DetectionFrame) -> Callable[[], object]:
    receiving, sending = socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM)

    def hand_over() -> object:
        sending.send(json.dumps(asdict(value)).encode())
        return json.loads(receiving.recv(1 << 20))

    return hand_over


def through_flock(value: object) -> Callable[[], object]:
    path = Path(f"/dev/shm/{PREFIX}_flock")
    path.write_bytes(bytes(1 << 20))
    one, two = os.open(path, os.O_RDWR), os.open(path, os.O_RDWR)
    memory = mmap.mmap(one, 1 << 20)

    def hand_over() -> object:
        raw = pickle.dumps(value)
        fcntl.flock(one, fcntl.LOCK_EX)
        memory[: len(raw)] = raw
        fcntl.flock(one, fcntl.LOCK_UN)
        fcntl.flock(two, fcntl.LOCK_SH)
        copy = memory[: len(raw)]
        fcntl.flock(two, fcntl.LOCK_UN)
        return pickle.loads(copy)

    return hand_over


def hand_over_pictures() -> list[Row]:
    task = "picture 640x480, write + read"
    value, buffer = picture(), np.empty((480, 640, 3), np.uint8)
    shared = np.empty_like(buffer)
    with (
        channels.open_writer(channels.CAMERA, PREFIX) as writer,
        channels.open_reader(channels.CAMERA, PREFIX) as reader,
    ):

        def ours() -> None:
            writer.write(value)
            assert reader.read_into(buffer) is not None

        def ours_into_new_array() -> None:
            writer.write(value)
            assert reader.take_new() is not None

        def unguarded() -> None:
            shared[:] = value.image_bgr
            buffer[:] = shared

        return [
            Row(task, OURS, microseconds(ours), "us", "read_into, every byte summed twice"),
            Row(task, "target_nav, new array", microseconds(ours_into_new_array), "us", "take_new"),
            Row(task, "two copies", microseconds(unguarded), "us", "unguarded memcpy: the floor, and torn"),
            Row(
                task,
                "flock",
                microseconds(through_flock_raw(value, buffer)),
                "us",
                "readers block the writer",
            ),
        ]


def through_flock_raw(value: CameraFrame, buffer: np.ndarray) -> Callable[[], object]:
    path = Path(f"/dev/shm/{PREFIX}_flock")
    path.write_bytes(bytes(1 << 20))
    one, two = os.open(path, os.O_RDWR), os.open(path, os.O_RDWR)
    memory = memoryview(mmap.mmap(one, 1 << 20))[: buffer.nbytes]
    source, target = value.image_bgr.reshape(-1).data, buffer.reshape(-1).data

    def hand_over() -> None:
        fcntl.flock(one, fcntl.LOCK_EX)
        memory[:] = source
        fcntl.flock(one, fcntl.LOCK_UN)
        fcntl.flock(two, fcntl.LOCK_SH)
        target[:] = memory
        fcntl.flock(two, fcntl.LOCK_UN)

    return hand_over


def guards_of_a_picture() -> list[Row]:
    task = "guard of 921,600 bytes, once"
    flat = picture().image_bgr.reshape(-1)
    return [
        Row(task, OURS, microseconds(lambda: pixel_sum(flat)), "us", "sum of 8-byte words"),
        Row(task, "crc32", microseconds(lambda: zlib.crc32(flat.data)), "us", "zlib"),
        Row(task, "adler32", microseconds(lambda: zlib.adler32(flat.data)), "us", "zlib"),
    ]


def small_calls() -> list[Row]:
    go = Command(1.0, CommandKind.GO)
    with (
        channels.open_writer(channels.DET, PREFIX) as writer,
        channels.open_reader(channels.DET, PREFIX) as reader,
        channels.open_command_reader(PREFIX) as commands,
        channels.open_command_writer(PREFIX) as operator,
    ):
        writer.write(detections(5))
        reader.latest()
        return [
            Row("poll, nothing new", OURS, microseconds(reader.take_new), "us"),
            Row(
                "describe, all channels",
                OURS,
                microseconds(lambda: channels.describe(PREFIX)),
                "us",
                "for doctor and status",
            ),
            Row(
                "command, push + pop",
                OURS,
                microseconds(lambda: (operator.push(go), commands.pop_all())),
                "us",
            ),
        ]


# Two processes: from the stamp in the writer to the value in the reader, which polls without a pause


def latency_between_processes() -> list[Row]:
    task = "5 detections, latency between processes"
    rows = []
    for name, note in ((OURS, "reader polls"), ("pipe", "reader blocks"), ("queue", "multiprocessing.Queue")):
        context = multiprocessing.get_context("spawn")
        pipe, queue = context.Pipe(duplex=False), context.Queue()
        process = context.Process(target=send_stamped, args=(name, PREFIX, pipe[1], queue), daemon=True)
        receive: Callable[[], Any] = {"pipe": pipe[0].recv, "queue": queue.get}.get(name, lambda: None)
        reader = channels.open_reader(channels.DET, PREFIX)
        if name == OURS:
            receive = reader.take_new
        process.start()
        delays_s: list[float] = []
        give_up_s = time.monotonic() + 20.0
        while len(delays_s) < HANDOVERS and time.monotonic() < give_up_s:
            frame = receive()
            if frame is not None:
                delays_s.append(time.monotonic() - frame.stamp_s)
        process.join(5)
        reader.close()
        rows.append(
            Row(task, name, 1e6 * statistics.median(delays_s), "us", f"median of {len(delays_s)}, {note}")
        )
    return rows


def send_stamped(name: str, prefix: str, pipe: Any, queue: Any) -> None:
    with channels.open_writer(channels.DET, prefix) as writer:
        send: Callable[[Any], object] = {"pipe": pipe.send, "queue": queue.put}.get(name, writer.write)
        for i in range(HANDOVERS + 20):
            time.sleep(0.003)
            send(detections(5, i))


# How often a torn value is taken for a whole one


def torn_values() -> list[Row]:
    """A scan of 544 points, 8,704 bytes: all of them hold one number, so a mixture of two scans shows."""
    task = f"torn of a million accepted, {TORN_S:.0f} s flat out"
    rows = []
    for name, write, read in ((OURS, write_scans, read_scans), ("reference", write_naively, read_naively)):
        process = multiprocessing.get_context("spawn").Process(target=write, args=(PREFIX,), daemon=True)
        process.start()
        try:
            accepted, torn = read(PREFIX)
        finally:
            process.kill()
            process.join()
        rows.append(
            Row(task, name, 1e6 * torn / max(accepted, 1), "1e-6", f"{torn} of {accepted:,}, 8.7 kB each")
        )
    return rows


POINTS = [np.full((544, 2), float(i)) for i in range(17)]
SCAN_BYTES = POINTS[0].nbytes


def write_scans(prefix: str) -> None:
    with channels.open_writer(channels.LASER, prefix) as writer:
        for i in count():
            writer.write(LaserSnapshot(time.monotonic(), Pose2D(), POINTS[i % 17]))


def read_scans(prefix: str) -> tuple[int, int]:
    with channels.open_reader(channels.LASER, prefix) as reader:
        return judge(lambda: None if (scan := reader.take_new()) is None else scan.points_in_base_m)


def write_naively(prefix: str) -> None:
    """Counter, payload, the same counter at the end, one slot; `struct.pack_into` throughout."""
    path = Path(f"/dev/shm/{prefix}_naive")
    path.write_bytes(bytes(16 + SCAN_BYTES))
    raw = [points.tobytes() for points in POINTS]
    with path.open("r+b") as file, mmap.mmap(file.fileno(), 0) as memory:
        for i in count(1):
            struct.pack_into("<I", memory, 0, i & 0xFFFF_FFFF)
            memory[8 : 8 + SCAN_BYTES] = raw[i % 17]
            struct.pack_into("<I", memory, 8 + SCAN_BYTES, i & 0xFFFF_FFFF)


def read_naively(prefix: str) -> tuple[int, int]:
    path = Path(f"/dev/shm/{prefix}_naive")
    while not path.exists() or path.stat().st_size < 16 + SCAN_BYTES:
        time.sleep(0.01)
    last = 0
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as memory:

        def take() -> FloatArray | None:
            nonlocal last
            (start,) = struct.unpack_from("<I", memory, 0)
            (end,) = struct.unpack_from("<I", memory, 8 + SCAN_BYTES)
            if start != end or start == last:
                return None
            last = start
            return np.frombuffer(memory[8 : 8 + SCAN_BYTES])

        return judge(take)


def judge(take: Callable[[], FloatArray | None]) -> tuple[int, int]:
    """(accepted, of these not all of one number)."""
    accepted = torn = 0
    end_s = time.monotonic() + 20.0
    while time.monotonic() < end_s:
        points = take()
        if points is None:
            continue
        if accepted == 0:
            end_s = time.monotonic() + TORN_S
        accepted += 1
        torn += int(points.min() != points.max())
    return accepted, torn

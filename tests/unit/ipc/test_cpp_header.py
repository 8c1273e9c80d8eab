"""The generated header, compiled: every size and offset, and both directions of the protocol, against Python."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from target_nav.ipc import channels, cpp_header, header
from target_nav.ipc.channels import CALIBRATION, DETECTIONS, open_reader, open_writer
from target_nav.ipc.cstruct import CStruct
from target_nav.state.snapshots import Calibration
from target_nav.state.types import RawDetection, RawDetectionFrame

COMPILER = shutil.which("g++") or shutil.which("clang++")
needs_compiler = pytest.mark.skipif(COMPILER is None, reason="no C++ compiler")

# What the detector process of a robot does: reads `calibration`, claims and writes `detections`.
DETECTOR = r"""
#include "channels.hpp"
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <unistd.h>
using namespace target_nav::ipc;

static std::uint32_t crc32(const unsigned char* data, std::size_t size) {
  std::uint32_t crc = ~0u;
  while (size--) {
    crc ^= *data++;
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xEDB88320u : 0u);
  }
  return ~crc;
}

template <class Channel> static unsigned char* map(const char* prefix, bool write) {
  char path[256];
  std::snprintf(path, sizeof path, "/dev/shm/%s_%s", prefix, Channel::NAME);
  int fd = open(path, write ? O_RDWR : O_RDONLY);
  if (fd < 0 || (write && flock(fd, LOCK_EX | LOCK_NB))) std::exit(3);
  void* at = mmap(nullptr, Channel::FILE_BYTES, write ? PROT_READ | PROT_WRITE : PROT_READ, MAP_SHARED, fd, 0);
  auto* file = static_cast<FileHeader*>(at);
  if (at == MAP_FAILED || std::memcmp(file->magic, MAGIC, 8) || file->layout_hash != Channel::LAYOUT_HASH) std::exit(4);
  return static_cast<unsigned char*>(at);
}

int main(int argc, char** argv) {
  if (argc < 2) {
    // SIZES
    return 0;
  }
  {
    unsigned char* base = map<CalibrationChannel>(argv[1], false);
    auto* file = reinterpret_cast<FileHeader*>(base);
    std::uint32_t s = file->published.load(std::memory_order_acquire);
    unsigned char* at = base + sizeof(FileHeader) + s % CalibrationChannel::SLOT_COUNT * CalibrationChannel::SLOT_BYTES;
    auto* slot = reinterpret_cast<SlotHeader*>(at);
    if (slot->lock.load(std::memory_order_acquire) != lock_done(s)) return 5;
    if (slot->crc != crc32(at + offsetof(SlotHeader, sequence), 16 + slot->length)) return 6;
    Calibration c;
    std::memcpy(&c, at + sizeof(SlotHeader), sizeof c);
    std::printf("%.17g %.17g %.17g %.17g %s\n", c.stamp_s, c.focal_x_px, c.distortion[4], c.score_min, c.class_name);
  }
  unsigned char* base = map<DetectionsChannel>(argv[1], true);
  auto* file = reinterpret_cast<FileHeader*>(base);
  timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  std::uint64_t sequence = now.tv_sec * 1000000000ull + now.tv_nsec;
  file->claim.fetch_or(1);
  file->writer_pid = getpid();
  file->generation_low = static_cast<std::uint32_t>(sequence);
  file->generation_high = static_cast<std::uint32_t>(sequence >> 32);
  file->published.store(static_cast<std::uint32_t>(sequence - 1));
  file->claim.fetch_add(1);
  for (int i = 0; i < 6; ++i, ++sequence) {
    unsigned char* at =
        base + sizeof(FileHeader) + sequence % DetectionsChannel::SLOT_COUNT * DetectionsChannel::SLOT_BYTES;
    auto* slot = reinterpret_cast<SlotHeader*>(at);
    slot->lock.store(lock_busy(sequence), std::memory_order_relaxed);
    std::atomic_thread_fence(std::memory_order_release);
    auto* frame = reinterpret_cast<RawDetectionFrame*>(at + sizeof(SlotHeader));
    frame->stamp_s = 100.5 + i;
    frame->frame_id = i;
    frame->detections_count = 2;
    for (int k = 0; k < 2; ++k) {
      RawDetection& d = frame->detections[k];
      std::memset(&d, 0, sizeof d);
      std::strcpy(d.class_name, k ? "bottle" : "bowling_pin");
      d.score = 0.5 + 0.25 * k; d.u_px = 320; d.v_px = 240 - k; d.width_px = 20; d.height_px = 70;
    }
    slot->sequence = sequence;
    slot->length = offsetof(RawDetectionFrame, detections) + 2 * sizeof(RawDetection);
    slot->reserved = 0;
    slot->crc = crc32(at + offsetof(SlotHeader, sequence), 16 + slot->length);
    slot->lock.store(lock_done(sequence), std::memory_order_release);
    file->published.store(static_cast<std::uint32_t>(sequence), std::memory_order_release);
  }
  std::puts("written");
  std::fflush(stdout);
  std::getchar();
}
"""

LAYOUTS: dict[str, CStruct] = {
    layout.name: layout
    for layout in (header.FILE_HEADER, header.SLOT_HEADER, *(c.codec.layout for c in channels.ALL))
}
NESTED = {inner.name: inner for layout in LAYOUTS.values() for inner in layout.nested()}


def expected() -> list[str]:
    lines = []
    for name, layout in {**LAYOUTS, **NESTED}.items():
        lines.append(f"{name} {layout.size} {layout.align}")
        lines += [f"{name}.{m.name} {m.offset} {m.size}" for m in layout.members]
    return lines


def questions() -> str:
    """Statements that print what the compiler thinks, in the words of `expected`."""
    lines = []
    for name, layout in {**LAYOUTS, **NESTED}.items():
        lines.append(f'std::printf("{name} %zu %zu\\n", sizeof({name}), alignof({name}));')
        lines += [
            f'std::printf("{name}.{m.name} %zu %zu\\n", offsetof({name}, {m.name}), sizeof({name}::{m.name}));'
            for m in layout.members
        ]
    return "\n    ".join(lines)


@pytest.fixture(scope="module")
def detector(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("cpp")
    (folder / "channels.hpp").write_text(cpp_header.generate())
    (folder / "detector.cpp").write_text(DETECTOR.replace("// SIZES", questions()))
    command = [COMPILER, "-std=c++17", "-Wall", "-Wextra", "-Werror", "-o", str(folder / "detector")]
    built = subprocess.run([*command, str(folder / "detector.cpp")], capture_output=True, text=True)
    assert built.returncode == 0, built.stderr
    return folder / "detector"


@needs_compiler
def test_the_compiler_agrees_with_python_on_every_size_and_offset(detector: Path) -> None:
    said = subprocess.run([detector], capture_output=True, text=True, check=True).stdout.splitlines()
    assert said == expected()
    assert len(said) > 100


@needs_compiler
def test_a_cpp_detector_reads_a_python_calibration_and_python_reads_its_detections(
    detector: Path, prefix: str
) -> None:
    calibration = Calibration(
        3.25, 554.125, 554.0, 320.0, 240.0, (0.1, -0.2, 0.0, 0.0, 0.03125), 0.5, "bowling_pin"
    )
    open_writer(DETECTIONS, prefix).close()
    with open_writer(CALIBRATION, prefix) as writer, open_reader(DETECTIONS, prefix) as reader:
        writer.write(calibration)
        process = subprocess.Popen(
            [detector, prefix], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        try:
            assert process.stdout.readline() == "3.25 554.125 0.03125 0.5 bowling_pin\n"
            assert process.stdout.readline() == "written\n"
            assert reader.take_new() == RawDetectionFrame(
                105.5,
                5,
                (
                    RawDetection("bowling_pin", 0.5, 320.0, 240.0, 20.0, 70.0),
                    RawDetection("bottle", 0.75, 320.0, 239.0, 20.0, 70.0),
                ),
            )
            assert reader.statistics.crc_errors == 0
            assert [s.writer_pid for s in channels.describe(prefix) if s.name == "detections"] == [
                process.pid
            ]
        finally:
            process.communicate("\n")


def test_the_header_on_the_command_line_is_the_generated_one() -> None:
    printed = subprocess.run(
        [sys.executable, "-m", "target_nav.ipc.cpp_header"], capture_output=True, text=True, check=True
    ).stdout
    assert printed == cpp_header.generate()
    assert "#pragma once" in printed


def test_every_channel_is_in_the_header_with_its_hash() -> None:
    text = cpp_header.generate()
    for channel in channels.ALL:
        assert f'NAME = "{channel.name}"' in text
        assert f"0x{channel.geometry.layout_hash:08x}u" in text

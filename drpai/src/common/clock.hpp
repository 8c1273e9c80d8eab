// CLOCK_MONOTONIC in seconds: the clock of every stamp in this project.
#pragma once

#include <cstdint>
#include <ctime>

namespace yolo_cam {

inline std::int64_t monotonic_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::int64_t>(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
}

inline double monotonic_s() { return static_cast<double>(monotonic_ns()) * 1e-9; }

}  // namespace yolo_cam

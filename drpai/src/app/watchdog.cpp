#include "app/watchdog.hpp"

#include <chrono>

#include "common/clock.hpp"

namespace yolo_cam {

Watchdog::Watchdog(double limit_s, std::function<void(const std::string&)> bite)
    : limit_s_(limit_s), bite_(std::move(bite)), thread_([this] { watch(); }) {}

Watchdog::~Watchdog() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ended_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void Watchdog::beat(const char* where) {
  where_.store(where, std::memory_order_relaxed);
  last_s_.store(monotonic_s(), std::memory_order_relaxed);
}

void Watchdog::watch() {
  constexpr double LOOKS_PER_LIMIT = 4.0;
  const std::chrono::duration<double> period(limit_s_ / LOOKS_PER_LIMIT);
  std::unique_lock<std::mutex> lock(mutex_);
  while (!wake_.wait_for(lock, period, [this] { return ended_; })) {
    const double last_s = last_s_.load(std::memory_order_relaxed);
    if (last_s > 0.0 && monotonic_s() - last_s > limit_s_) {
      bite_(where_.load(std::memory_order_relaxed));
      return;
    }
  }
}

}  // namespace yolo_cam

// Lets files be played at a rate: pictures of a file are due, not there.
#pragma once

#include <algorithm>
#include <thread>

#include "common/clock.hpp"

namespace yolo_cam {

constexpr double POLL_LIMIT_S = 0.05;

inline void sleep_s(double seconds) {
  if (seconds > 0.0) {
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  }
}

class Pacer {
 public:
  explicit Pacer(double rate_hz) : period_s_(1.0 / rate_hz), due_s_(monotonic_s()) {}

  // Waits for at most POLL_LIMIT_S; true when the next picture is due, and then the one after it is set.
  bool wait() {
    const double now_s = monotonic_s();
    const double left_s = due_s_ - now_s;
    if (left_s > POLL_LIMIT_S) {
      sleep_s(POLL_LIMIT_S);
      return false;
    }
    sleep_s(left_s);
    // A reader that was held up does not catch up by hurrying.
    due_s_ = std::max(due_s_ + period_s_, now_s);
    return true;
  }

 private:
  double period_s_;
  double due_s_;
};

}  // namespace yolo_cam

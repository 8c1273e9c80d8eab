// A robot with four wheels on a bench: speed follows PWM with a lag, motors differ as motors do.
#pragma once

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "robot.h"

namespace firmware {

class Bench {
 public:
  static constexpr Micros LOOP_US = 2000;

  explicit Bench(const Params& params = REFERENCE, Micros start_us = 0)
      : robot(params, start_us), now_us(start_us), params_(params), next_control_us_(start_us + CONTROL_PERIOD_US) {}

  void send(const std::string& bytes) {
    for (const char byte : bytes) robot.receive(static_cast<uint8_t>(byte), now_us);
  }

  // With `resend` now and then every `every_ms`.
  void run(int ms, const std::string& resend = "", int every_ms = 50) {
    for (int loop = 0; loop < ms * 1000 / static_cast<int>(LOOP_US); ++loop) {
      if (!resend.empty() && loop % (every_ms * 1000 / static_cast<int>(LOOP_US)) == 0) send(resend);
      now_us += LOOP_US;
      elapsed_ms += LOOP_US / 1000.0;
      turn();
      if (isDue(now_us, next_control_us_)) {
        next_control_us_ += CONTROL_PERIOD_US;
        robot.control(now_us, ticks(), 1);
      }
      robot.poll(now_us, ticks());
      take();
    }
  }

  // Lines that begin so, newest last.
  std::vector<std::string> of(const std::string& word) const {
    std::vector<std::string> found;
    for (const auto& line : lines) {
      if (line.second.compare(0, word.size(), word) == 0) found.push_back(line.second);
    }
    return found;
  }

  double timeOf(const std::string& word) const {
    for (const auto& line : lines) {
      if (line.second.compare(0, word.size(), word) == 0) return line.first;
    }
    return -1.0;
  }

  bool stands() const {
    for (uint8_t i = 0; i < WHEELS; ++i) {
      if (robot.pwm()[i] != 0) return false;
    }
    return true;
  }

  Ticks ticks() const {
    Ticks counts;
    for (uint8_t i = 0; i < WHEELS; ++i) {
      const int64_t count = first_ticks[i] + static_cast<int64_t>(std::floor(travel_um[i] * 1000.0 / params_.tick_nm));
      counts[i] = static_cast<int32_t>(static_cast<uint32_t>(static_cast<uint64_t>(count)));
    }
    return counts;
  }

  Robot robot;
  Micros now_us;
  double elapsed_ms = 0.0;
  bool held[WHEELS] = {};
  double travel_um[WHEELS] = {};
  int64_t first_ticks[WHEELS] = {};
  std::vector<std::pair<double, std::string>> lines;

 private:
  void turn() {
    constexpr double GAINS[WHEELS] = {1.0, 0.9, 1.05, 0.85};
    constexpr double LAG_US = 80000.0;
    for (uint8_t i = 0; i < WHEELS; ++i) {
      const double target = robot.pwm()[i] * GAINS[i] * params_.top_speed_umps / MAX_PWM;
      speed_umps_[i] = held[i] ? 0.0 : speed_umps_[i] + (target - speed_umps_[i]) * LOOP_US / LAG_US;
      travel_um[i] += speed_umps_[i] * LOOP_US / 1e6;
    }
  }

  void take() {
    while (!robot.output().empty()) {
      const char byte = static_cast<char>(robot.output().pop());
      if (byte != '\n') {
        partial_ += byte;
        continue;
      }
      lines.emplace_back(elapsed_ms, partial_);
      partial_.clear();
    }
  }

  Params params_;
  Micros next_control_us_;
  double speed_umps_[WHEELS] = {};
  std::string partial_;
};

}  // namespace firmware

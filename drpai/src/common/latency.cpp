#include "common/latency.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace yolo_cam {
namespace {

constexpr double MS = 1e3;
constexpr double P99 = 0.99;

std::string formatted(const char* format, const char* name, const Quantiles& q) {
  std::array<char, 96> text{};
  const int size = std::snprintf(text.data(), text.size(), format, name, MS * q.p50_s, MS * q.p99_s, MS * q.max_s);
  return {text.data(), static_cast<std::size_t>(size)};
}

}  // namespace

const char* name_of(Stage stage) {
  constexpr std::array<const char*, STAGES> NAMES{"arrive", "undistort", "prepare", "infer", "decode", "publish", "total"};
  return NAMES.at(static_cast<std::size_t>(stage));
}

Quantiles quantiles_of(std::vector<double> sample) {
  std::sort(sample.begin(), sample.end());
  const std::size_t last = sample.size() - 1;
  const auto at = [&](double share) {
    return sample[static_cast<std::size_t>(std::lround(share * static_cast<double>(last)))];
  };
  return {at(0.5), at(P99), sample[last]};
}

std::optional<std::string> StageTimes::take(double now_s) {
  const double span_s = now_s - start_s_;
  if (span_s < window_s_) {
    return std::nullopt;
  }
  start_s_ = now_s;
  const auto& total = samples_[static_cast<std::size_t>(Stage::Total)];
  std::string text;
  if (total.empty()) {
    text = "no pictures in " + std::to_string(std::lround(span_s)) + " s";
  } else {
    std::array<char, 64> rate{};
    std::snprintf(rate.data(), rate.size(), "%.1f pictures/s; ms p50/p99/max:", static_cast<double>(total.size()) / span_s);
    text = rate.data();
    for (std::size_t i = 0; i < STAGES; ++i) {
      if (!samples_[i].empty()) {
        text += formatted(" %s %.1f/%.1f/%.1f", name_of(static_cast<Stage>(i)), quantiles_of(samples_[i]));
      }
    }
  }
  for (auto& sample : samples_) {
    sample.clear();
  }
  return text;
}

}  // namespace yolo_cam

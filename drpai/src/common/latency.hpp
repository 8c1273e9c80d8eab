// How long the stages of a frame take, over a window: collected with every frame, told now and then.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace yolo_cam {

// In the order in which a frame goes through them.
enum class Stage : std::size_t { Arrive, Undistort, Prepare, Infer, Decode, Publish, Total };
constexpr std::size_t STAGES = 7;
const char* name_of(Stage stage);

struct Quantiles {
  double p50_s;
  double p99_s;
  double max_s;
};

// Median, 99th percentile (nearest rank) and largest of a non-empty sample.
Quantiles quantiles_of(std::vector<double> sample);

class StageTimes {
 public:
  StageTimes(double window_s, double start_s) : window_s_(window_s), start_s_(start_s) {}

  void add(Stage stage, double seconds) { samples_[static_cast<std::size_t>(stage)].push_back(seconds); }

  // A line with rate and stages when the window is over, which begins a new one; nothing while it is still open.
  std::optional<std::string> take(double now_s);

 private:
  double window_s_;
  double start_s_;
  std::array<std::vector<double>, STAGES> samples_;
};

}  // namespace yolo_cam

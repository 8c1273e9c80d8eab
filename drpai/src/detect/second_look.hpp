// Glance, then look: what is small in the whole picture is looked at once more, enlarged.
//
// The rule is that of target_nav/detectors/second_look.py, with its numbers; docs/model.md has it as a contract.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include <opencv2/core.hpp>

#include "detect/decoder.hpp"
#include "detect/detection.hpp"
#include "detect/inference_backend.hpp"

namespace yolo_cam {

// What the network gets to see of a part, pixels.
constexpr int LOOK_WIDTH = 160;
constexpr int LOOK_HEIGHT = 128;
constexpr InputSize LOOK_INPUT{LOOK_WIDTH, LOOK_HEIGHT};
// Of a part in the picture, pixels. A part is the smallest of which a box fills no more than this share, in height and
// in width.
constexpr std::array<InputSize, 4> PART_SIZES{{{80, 64}, {100, 80}, {120, 96}, {160, 128}}};
constexpr double PART_FILL_MAX = 0.625;
// A box less high and less wide than this is small.
constexpr double LOOK_BELOW_PX = 96.0;
constexpr int LOOKS_MAX = 2;
// From which score on a small box is worth a look.
constexpr double GLANCE_SCORE_MIN = 0.15;
// A box nearer than this to the part's border may be cut by it, unless the picture ends there.
constexpr double LOOK_MARGIN_PX = 4.0;
// So far above and below the thing this network's looks end, in the picture's pixels.
constexpr double EDGE_BIAS_PX = 0.25;
// Of what was glanced at and what the look sees, to be one thing.
constexpr double SAME_OVERLAP_MIN = 0.3;

// What is looked at, pixels of the picture.
struct Part {
  int left;
  int top;
  int width;
  int height;
};

// With the box in its middle as far as the picture's borders allow.
Part part_around(const Detection& box, int picture_width, int picture_height);

// The whole box, with its margin where the picture goes on.
bool holds(const Part& part, const Detection& box, int picture_width, int picture_height);

// Geometric mean of the two scores, the look's taken twice: both have to see something.
double combined(double glance, double look);

// Boxes of a part in the picture's pixels, from `score_min` on, best first, after suppression.
using Look = std::function<std::vector<Detection>(const Part&)>;

// Boxes of one picture, best first. `glanced` are those of the whole picture from min(limits.score_min,
// GLANCE_SCORE_MIN) on, best first, after suppression.
std::vector<Detection> look_again(const std::vector<Detection>& glanced, const Look& look, int picture_width,
                                  int picture_height, const DecoderLimits& limits);

// Runs the network on parts of pictures. A backend of a larger input sees the part in its upper left corner.
class PartLooker {
 public:
  explicit PartLooker(InferenceBackend& backend);

  std::vector<Detection> look(const cv::Mat& image_bgr, const Part& part, const DecoderLimits& limits);

 private:
  InferenceBackend& backend_;
  cv::Mat enlarged_;
  std::vector<float> input_;
};

}  // namespace yolo_cam

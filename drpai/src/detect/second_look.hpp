// Glance, then look: what is small in the whole picture is looked at once more in the picture's own pixels.
//
// The rule is that of target_nav/detectors/second_look.py, with its numbers; docs/model.md has it as a contract.
#pragma once

#include <functional>
#include <vector>

#include <opencv2/core.hpp>

#include "detect/decoder.hpp"
#include "detect/detection.hpp"
#include "detect/inference_backend.hpp"

namespace yolo_cam {

// Of the part, pixels of the picture and of the network alike.
constexpr int LOOK_WIDTH = 160;
constexpr int LOOK_HEIGHT = 128;
constexpr InputSize LOOK_INPUT{LOOK_WIDTH, LOOK_HEIGHT};
// A box less high and less wide than this is small.
constexpr double LOOK_BELOW_PX = 96.0;
constexpr int LOOKS_MAX = 2;
// From which score on a small box is worth a look.
constexpr double GLANCE_SCORE_MIN = 0.15;
// A box nearer than this to the part's border may be cut by it, unless the picture ends there.
constexpr double LOOK_MARGIN_PX = 4.0;
// Of what was glanced at and what the look sees, to be one thing.
constexpr double SAME_OVERLAP_MIN = 0.3;

// The corner of what is looked at.
struct Part {
  int left;
  int top;
};

// With the box in its middle as far as the picture's borders allow.
Part part_around(const Detection& box, int picture_width, int picture_height);

// The whole box, with its margin where the picture goes on.
bool holds(const Part& part, const Detection& box, int picture_width, int picture_height);

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
  std::vector<float> input_;
};

}  // namespace yolo_cam

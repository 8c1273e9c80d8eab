// From a picture to the network's input: scaled to fit, grey bars round it, RGB, 0 to 1, planar.
#pragma once

#include <vector>

#include <opencv2/core.hpp>

#include "detect/inference_backend.hpp"

namespace yolo_cam {

// How the picture lies in the network's input: input = picture * scale + offset.
struct Placement {
  double scale = 1.0;
  double left = 0.0;
  double top = 0.0;
  int width = 0;
  int height = 0;
};

Placement placement_of(int picture_width, int picture_height);

// The grey of the bars: what the network was trained with.
constexpr float PAD = 114.0F / 255.0F;

// Writes `image_bgr` into the planes of `input`, which are of `size`, at a column and a row: RGB, 0 to 1.
void fill_planes(const cv::Mat& image_bgr, int left, int top, InputSize size, std::vector<float>& input);

class Letterbox {
 public:
  Letterbox();

  // The input for `image_bgr` (8-bit, 3 channels); the pointer is good until the next call.
  const float* prepare(const cv::Mat& image_bgr);
  const Placement& placement() const { return placement_; }

 private:
  Placement placement_;
  cv::Mat scaled_;
  std::vector<float> input_;
};

}  // namespace yolo_cam

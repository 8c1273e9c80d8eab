// From raw heads to boxes: sigmoid, distances to edges, non-maximum suppression. The same for every backend.
//
// Anchor-free, as in Tian et al., "FCOS: Fully Convolutional One-Stage Object Detection", ICCV 2019.
#pragma once

#include <vector>

#include "detect/detection.hpp"
#include "detect/inference_backend.hpp"
#include "detect/letterbox.hpp"

namespace yolo_cam {

struct DecoderLimits {
  double score_min = 0.3;
  // Two boxes that overlap by more (intersection over union) are one object; the better one stays.
  double overlap_max = 0.5;
  // A box smaller than this in the picture is no object.
  double side_min_px = 2.0;
  // The best so many cells are looked at, and so many boxes returned.
  std::size_t candidates_max = 512;
  std::size_t detections_max = 64;
};

// Boxes of one picture, best score first, clipped at its borders. Cells with numbers that are none are left out.
std::vector<Detection> decode(const std::vector<HeadTensor>& heads, const Placement& placement, int picture_width,
                              int picture_height, const DecoderLimits& limits);

// Intersection over union, 0 to 1.
double overlap(const Detection& first, const Detection& second);

// Greedy suppression of `boxes`, which come best first.
std::vector<Detection> suppress(const std::vector<Detection>& boxes, double overlap_max, std::size_t detections_max);

}  // namespace yolo_cam

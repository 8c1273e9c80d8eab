#include "detect/second_look.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <utility>

#include "detect/letterbox.hpp"

namespace yolo_cam {
namespace {

bool is_small(const Detection& box) { return box.height_px < LOOK_BELOW_PX && box.width_px < LOOK_BELOW_PX; }

int start_of(double middle, int size, int limit) {
  return std::clamp(static_cast<int>(std::floor(middle - 0.5 * size + 0.5)), 0, limit - size);
}

bool inside(double middle, double size, int start, int length, int limit) {
  const double low = middle - 0.5 * size;
  const double high = middle + 0.5 * size;
  return (start == 0 || low >= start + LOOK_MARGIN_PX) && (start + length == limit || high <= start + length - LOOK_MARGIN_PX);
}

void keep_above(const std::vector<Detection>& boxes, double score_min, std::vector<Detection>& kept) {
  std::copy_if(boxes.begin(), boxes.end(), std::back_inserter(kept),
               [&](const Detection& box) { return box.score >= score_min; });
}

}  // namespace

Part part_around(const Detection& box, int picture_width, int picture_height) {
  return {start_of(box.u_px, LOOK_WIDTH, picture_width), start_of(box.v_px, LOOK_HEIGHT, picture_height)};
}

bool holds(const Part& part, const Detection& box, int picture_width, int picture_height) {
  return inside(box.u_px, box.width_px, part.left, LOOK_WIDTH, picture_width) &&
         inside(box.v_px, box.height_px, part.top, LOOK_HEIGHT, picture_height);
}

std::vector<Detection> look_again(const std::vector<Detection>& glanced, const Look& look, int picture_width,
                                  int picture_height, const DecoderLimits& limits) {
  std::vector<Detection> kept;
  if (picture_width < LOOK_WIDTH || picture_height < LOOK_HEIGHT) {
    keep_above(glanced, limits.score_min, kept);
    return kept;
  }
  std::vector<Detection> open;
  for (const Detection& box : glanced) {
    if (is_small(box)) {
      open.push_back(box);
    } else if (box.score >= limits.score_min) {
      kept.push_back(box);
    }
  }
  for (int looks = 0; looks < LOOKS_MAX && !open.empty() && open.front().score >= GLANCE_SCORE_MIN; ++looks) {
    const Part part = part_around(open.front(), picture_width, picture_height);
    std::vector<Detection> settled{open.front()};
    std::vector<Detection> rest;
    for (auto box = open.begin() + 1; box != open.end(); ++box) {
      (holds(part, *box, picture_width, picture_height) ? settled : rest).push_back(*box);
    }
    open = std::move(rest);
    for (const Detection& seen : look(part)) {
      const auto same = [&](const Detection& box) { return overlap(seen, box) >= SAME_OVERLAP_MIN; };
      if (holds(part, seen, picture_width, picture_height) && std::any_of(settled.begin(), settled.end(), same)) {
        kept.push_back(seen);
      }
    }
  }
  keep_above(open, limits.score_min, kept);
  // Of equal scores the earlier stays.
  std::stable_sort(kept.begin(), kept.end(), [](const Detection& a, const Detection& b) { return a.score > b.score; });
  return suppress(kept, limits.overlap_max, limits.detections_max);
}

PartLooker::PartLooker(InferenceBackend& backend) : backend_(backend), input_(backend.input_size().values(), PAD) {}

std::vector<Detection> PartLooker::look(const cv::Mat& image_bgr, const Part& part, const DecoderLimits& limits) {
  const InputSize size = backend_.input_size();
  fill_planes(image_bgr({part.left, part.top, LOOK_WIDTH, LOOK_HEIGHT}), 0, 0, size, input_);
  const Placement placement{1.0, -part.left, -part.top, LOOK_WIDTH, LOOK_HEIGHT};
  return decode(backend_.run(input_.data()), placement, image_bgr.cols, image_bgr.rows, limits);
}

}  // namespace yolo_cam

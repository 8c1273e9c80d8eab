#include "detect/second_look.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <utility>

#include <opencv2/imgproc.hpp>

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

InputSize part_size(const Detection& box) {
  for (const InputSize& size : PART_SIZES) {
    if (box.height_px <= PART_FILL_MAX * size.height && box.width_px <= PART_FILL_MAX * size.width) {
      return size;
    }
  }
  return PART_SIZES.back();
}

// Less the bias of both edges; an edge at the picture's border stays there, so that the border rule flags it.
Detection measured(const Detection& seen, double score, int picture_height) {
  double top = seen.v_px - 0.5 * seen.height_px;
  double bottom = seen.v_px + 0.5 * seen.height_px;
  top += top > 0.0 ? EDGE_BIAS_PX : 0.0;
  bottom -= bottom < picture_height ? EDGE_BIAS_PX : 0.0;
  return {score, seen.u_px, 0.5 * (top + bottom), seen.width_px, bottom - top};
}

void keep_above(const std::vector<Detection>& boxes, double score_min, std::vector<Detection>& kept) {
  std::copy_if(boxes.begin(), boxes.end(), std::back_inserter(kept),
               [&](const Detection& box) { return box.score >= score_min; });
}

}  // namespace

Part part_around(const Detection& box, int picture_width, int picture_height) {
  const InputSize size = part_size(box);
  return {start_of(box.u_px, size.width, picture_width), start_of(box.v_px, size.height, picture_height), size.width,
          size.height};
}

double combined(double glance, double look) { return std::cbrt(glance * look * look); }

bool holds(const Part& part, const Detection& box, int picture_width, int picture_height) {
  return inside(box.u_px, box.width_px, part.left, part.width, picture_width) &&
         inside(box.v_px, box.height_px, part.top, part.height, picture_height);
}

std::vector<Detection> look_again(const std::vector<Detection>& glanced, const Look& look, int picture_width,
                                  int picture_height, const DecoderLimits& limits) {
  std::vector<Detection> kept;
  if (picture_width < PART_SIZES.back().width || picture_height < PART_SIZES.back().height) {
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
      if (!holds(part, seen, picture_width, picture_height)) {
        continue;
      }
      // Best first, so it is the best glance at the same thing.
      const auto same = std::find_if(settled.begin(), settled.end(),
                                     [&](const Detection& box) { return overlap(seen, box) >= SAME_OVERLAP_MIN; });
      if (same == settled.end()) {
        continue;
      }
      if (const double score = combined(same->score, seen.score); score >= limits.score_min) {
        kept.push_back(measured(seen, score, picture_height));
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
  cv::resize(image_bgr({part.left, part.top, part.width, part.height}), enlarged_, {LOOK_WIDTH, LOOK_HEIGHT});
  fill_planes(enlarged_, 0, 0, size, input_);
  const double scale = static_cast<double>(LOOK_WIDTH) / part.width;
  const Placement placement{scale, -scale * part.left, -scale * part.top, LOOK_WIDTH, LOOK_HEIGHT};
  return decode(backend_.run(input_.data()), placement, image_bgr.cols, image_bgr.rows, limits);
}

}  // namespace yolo_cam

#include "detect/decoder.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace yolo_cam {
namespace {

struct Candidate {
  float logit;
  std::size_t head;
  std::size_t cell;
};

double sigmoid(double logit) { return 1.0 / (1.0 + std::exp(-logit)); }

// The logit of a score: comparing logits saves an exponential a cell.
double logit_of(double score) {
  if (score <= 0.0) {
    return -std::numeric_limits<double>::infinity();
  }
  return score >= 1.0 ? std::numeric_limits<double>::infinity() : std::log(score / (1.0 - score));
}

std::vector<Candidate> candidates_of(const std::vector<HeadTensor>& heads, const DecoderLimits& limits) {
  const auto logit_min = static_cast<float>(logit_of(limits.score_min));
  std::vector<Candidate> found;
  for (std::size_t head = 0; head < heads.size(); ++head) {
    const std::size_t cells = static_cast<std::size_t>(heads[head].rows) * heads[head].columns;
    for (std::size_t cell = 0; cell < cells; ++cell) {
      const float logit = heads[head].values[cell];
      // Also false for NaN.
      if (logit >= logit_min && std::isfinite(logit)) {
        found.push_back({logit, head, cell});
      }
    }
  }
  // Of equal scores the first cell of the finest head is better, so that the result does not depend on the sort.
  const auto better = [](const Candidate& a, const Candidate& b) {
    if (a.logit != b.logit) {
      return a.logit > b.logit;
    }
    return a.head != b.head ? a.head < b.head : a.cell < b.cell;
  };
  const std::size_t kept = std::min(found.size(), limits.candidates_max);
  std::partial_sort(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(kept), found.end(), better);
  found.resize(kept);
  return found;
}

}  // namespace

std::vector<Detection> decode(const std::vector<HeadTensor>& heads, const Placement& placement, int picture_width,
                              int picture_height, const DecoderLimits& limits) {
  std::vector<Detection> boxes;
  for (const Candidate& candidate : candidates_of(heads, limits)) {
    const HeadTensor& head = heads[candidate.head];
    const std::size_t plane = static_cast<std::size_t>(head.rows) * head.columns;
    const auto distance_px = [&](std::size_t edge) {
      return static_cast<double>(head.values[edge * plane + candidate.cell]) * head.stride;
    };
    const double left_px = distance_px(1);
    const double top_px = distance_px(2);
    const double right_px = distance_px(3);
    const double bottom_px = distance_px(4);
    if (!std::isfinite(left_px + top_px + right_px + bottom_px)) {
      continue;
    }
    const std::size_t row = candidate.cell / head.columns;
    const std::size_t column = candidate.cell % head.columns;
    const double u = (static_cast<double>(column) + 0.5) * head.stride - placement.left;
    const double v = (static_cast<double>(row) + 0.5) * head.stride - placement.top;
    const auto clipped = [&](double value, int limit) {
      return std::clamp(value / placement.scale, 0.0, static_cast<double>(limit));
    };
    const double left = clipped(u - left_px, picture_width);
    const double right = clipped(u + right_px, picture_width);
    const double top = clipped(v - top_px, picture_height);
    const double bottom = clipped(v + bottom_px, picture_height);
    if (right - left < limits.side_min_px || bottom - top < limits.side_min_px) {
      continue;
    }
    boxes.push_back({sigmoid(candidate.logit), 0.5 * (left + right), 0.5 * (top + bottom), right - left, bottom - top});
  }
  return suppress(boxes, limits.overlap_max, limits.detections_max);
}

double overlap(const Detection& first, const Detection& second) {
  const auto shared = [](double a, double a_size, double b, double b_size) {
    return std::max(0.0, std::min(a + 0.5 * a_size, b + 0.5 * b_size) - std::max(a - 0.5 * a_size, b - 0.5 * b_size));
  };
  const double common = shared(first.u_px, first.width_px, second.u_px, second.width_px) *
                        shared(first.v_px, first.height_px, second.v_px, second.height_px);
  const double whole = first.width_px * first.height_px + second.width_px * second.height_px - common;
  return whole > 0.0 ? common / whole : 0.0;
}

std::vector<Detection> suppress(const std::vector<Detection>& boxes, double overlap_max, std::size_t detections_max) {
  std::vector<Detection> kept;
  for (const Detection& box : boxes) {
    if (kept.size() == detections_max) {
      break;
    }
    if (std::all_of(kept.begin(), kept.end(), [&](const Detection& other) { return overlap(box, other) <= overlap_max; })) {
      kept.push_back(box);
    }
  }
  return kept;
}

}  // namespace yolo_cam

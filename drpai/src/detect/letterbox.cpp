#include "detect/letterbox.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "detect/inference_backend.hpp"

namespace yolo_cam {
namespace {

// The grey of the bars: what the network was trained with.
constexpr float BAR = 114.0F / 255.0F;

constexpr std::array<float, 256> unit_values() {
  std::array<float, 256> table{};
  for (std::size_t i = 0; i < table.size(); ++i) {
    table[i] = static_cast<float>(i) / 255.0F;
  }
  return table;
}

constexpr std::array<float, 256> UNIT = unit_values();

}  // namespace

Placement placement_of(int picture_width, int picture_height) {
  const double scale = std::min(static_cast<double>(INPUT_WIDTH) / picture_width,
                                static_cast<double>(INPUT_HEIGHT) / picture_height);
  const int width = static_cast<int>(std::lround(scale * picture_width));
  const int height = static_cast<int>(std::lround(scale * picture_height));
  return {scale, (INPUT_WIDTH - width) / 2, (INPUT_HEIGHT - height) / 2, width, height};
}

Letterbox::Letterbox() : input_(INPUT_VALUES, BAR) {}

const float* Letterbox::prepare(const cv::Mat& image_bgr) {
  const Placement placement = placement_of(image_bgr.cols, image_bgr.rows);
  if (placement.width != placement_.width || placement.height != placement_.height) {
    std::fill(input_.begin(), input_.end(), BAR);
    placement_ = placement;
  }
  // At exactly one half both ways of shrinking are the mean of four pixels.
  const int method = placement.scale < 1.0 ? cv::INTER_AREA : cv::INTER_LINEAR;
  cv::resize(image_bgr, scaled_, {placement.width, placement.height}, 0.0, 0.0, method);
  constexpr std::size_t PLANE = static_cast<std::size_t>(INPUT_HEIGHT) * INPUT_WIDTH;
  for (int row = 0; row < placement.height; ++row) {
    const auto* from = scaled_.ptr<std::uint8_t>(row);
    float* red = input_.data() + static_cast<std::size_t>(placement.top + row) * INPUT_WIDTH + placement.left;
    float* green = red + PLANE;
    float* blue = green + PLANE;
    for (int column = 0; column < placement.width; ++column, from += INPUT_CHANNELS) {
      blue[column] = UNIT[from[0]];
      green[column] = UNIT[from[1]];
      red[column] = UNIT[from[2]];
    }
  }
  return input_.data();
}

}  // namespace yolo_cam

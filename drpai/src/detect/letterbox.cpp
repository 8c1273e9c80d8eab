#include "detect/letterbox.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace yolo_cam {
namespace {

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
  const int left = (INPUT_WIDTH - width) / 2;
  const int top = (INPUT_HEIGHT - height) / 2;
  return {scale, static_cast<double>(left), static_cast<double>(top), width, height};
}

void fill_planes(const cv::Mat& image_bgr, int left, int top, InputSize size, std::vector<float>& input) {
  const std::size_t plane = static_cast<std::size_t>(size.height) * size.width;
  for (int row = 0; row < image_bgr.rows; ++row) {
    const auto* from = image_bgr.ptr<std::uint8_t>(row);
    float* red = input.data() + static_cast<std::size_t>(top + row) * size.width + left;
    float* green = red + plane;
    float* blue = green + plane;
    for (int column = 0; column < image_bgr.cols; ++column, from += INPUT_CHANNELS) {
      blue[column] = UNIT[from[0]];
      green[column] = UNIT[from[1]];
      red[column] = UNIT[from[2]];
    }
  }
}

Letterbox::Letterbox() : input_(INPUT_VALUES, PAD) {}

const float* Letterbox::prepare(const cv::Mat& image_bgr) {
  const Placement placement = placement_of(image_bgr.cols, image_bgr.rows);
  if (placement.width != placement_.width || placement.height != placement_.height) {
    std::fill(input_.begin(), input_.end(), PAD);
    placement_ = placement;
  }
  // At exactly one half both ways of shrinking are the mean of four pixels.
  const int method = placement.scale < 1.0 ? cv::INTER_AREA : cv::INTER_LINEAR;
  cv::resize(image_bgr, scaled_, {placement.width, placement.height}, 0.0, 0.0, method);
  fill_planes(scaled_, static_cast<int>(placement.left), static_cast<int>(placement.top), WHOLE_INPUT, input_);
  return input_.data();
}

}  // namespace yolo_cam

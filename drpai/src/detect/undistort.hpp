// Straightens a lens's distortion, so that what follows may take the camera for a pinhole.
#pragma once

#include <array>
#include <optional>

#include <opencv2/core.hpp>

namespace yolo_cam {

// Focal lengths and principal point in continuous picture coordinates (column i covers i to i + 1); distortion is the
// Brown-Conrady model in OpenCV's order: k1 k2 p1 p2 k3.
struct Lens {
  double focal_x_px = 0.0;
  double focal_y_px = 0.0;
  double center_u_px = 0.0;
  double center_v_px = 0.0;
  std::array<double, 5> distortion{};

  bool operator==(const Lens& other) const;
  bool distorts() const;
  bool valid() const;
};

class Undistorter {
 public:
  // The picture a pinhole camera of the same focal length and centre would have taken. Without distortion it is the
  // picture itself, otherwise a buffer that lasts until the next call.
  const cv::Mat& apply(const cv::Mat& image, const std::optional<Lens>& lens);

 private:
  void prepare(const Lens& lens, cv::Size size);

  std::optional<Lens> prepared_;
  cv::Size size_;
  cv::Mat map_whole_;
  cv::Mat map_fraction_;
  cv::Mat straight_;
};

}  // namespace yolo_cam

#include "detect/undistort.hpp"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace yolo_cam {

bool Lens::operator==(const Lens& other) const {
  return focal_x_px == other.focal_x_px && focal_y_px == other.focal_y_px && center_u_px == other.center_u_px &&
         center_v_px == other.center_v_px && distortion == other.distortion;
}

bool Lens::distorts() const {
  return std::any_of(distortion.begin(), distortion.end(), [](double k) { return k != 0.0; });
}

bool Lens::valid() const {
  return std::isfinite(focal_x_px + focal_y_px + center_u_px + center_v_px) && focal_x_px > 0.0 && focal_y_px > 0.0 &&
         std::all_of(distortion.begin(), distortion.end(), [](double k) { return std::isfinite(k); });
}

const cv::Mat& Undistorter::apply(const cv::Mat& image, const std::optional<Lens>& lens) {
  if (!lens || !lens->valid() || !lens->distorts()) {
    return image;
  }
  if (!prepared_ || !(*prepared_ == *lens) || size_ != image.size()) {
    prepare(*lens, image.size());
  }
  cv::remap(image, straight_, map_whole_, map_fraction_, cv::INTER_LINEAR);
  return straight_;
}

void Undistorter::prepare(const Lens& lens, cv::Size size) {
  const auto [k1, k2, p1, p2, k3] = lens.distortion;
  cv::Mat map_u(size, CV_32F);
  cv::Mat map_v(size, CV_32F);
  for (int row = 0; row < size.height; ++row) {
    auto* to_u = map_u.ptr<float>(row);
    auto* to_v = map_v.ptr<float>(row);
    const double y = (row + 0.5 - lens.center_v_px) / lens.focal_y_px;
    for (int column = 0; column < size.width; ++column) {
      // Brown, "Close-range camera calibration", 1971: where a straight ray ends up behind the real lens.
      const double x = (column + 0.5 - lens.center_u_px) / lens.focal_x_px;
      const double r2 = x * x + y * y;
      const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
      const double bent_x = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x);
      const double bent_y = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y;
      // remap counts from the middle of the first pixel.
      to_u[column] = static_cast<float>(lens.focal_x_px * bent_x + lens.center_u_px - 0.5);
      to_v[column] = static_cast<float>(lens.focal_y_px * bent_y + lens.center_v_px - 0.5);
    }
  }
  cv::convertMaps(map_u, map_v, map_whole_, map_fraction_, CV_16SC2);
  prepared_ = lens;
  size_ = size;
}

}  // namespace yolo_cam

#pragma once

namespace yolo_cam {

// One box in pixels of the full picture: continuous coordinates (column i covers i to i + 1), (u, v) is its centre.
struct Detection {
  double score;
  double u_px;
  double v_px;
  double width_px;
  double height_px;
};

}  // namespace yolo_cam

#include "detect/inference_backend.hpp"

#include "common/error.hpp"

namespace yolo_cam {

int stride_of_values(std::size_t values, const std::string& where) {
  constexpr int STRIDE_MIN = 4;
  constexpr int STRIDE_MAX = 64;
  for (int stride = STRIDE_MIN; stride <= STRIDE_MAX; stride *= 2) {
    if (values == static_cast<std::size_t>(HEAD_PLANES) * (INPUT_HEIGHT / stride) * (INPUT_WIDTH / stride)) {
      return stride;
    }
  }
  throw DeviceError(where + " has an output of " + std::to_string(values) + " values; a head has 5 x 256/s x 320/s, s " +
                    "being 4, 8 ... 64: is it the network of deploy/model?");
}

}  // namespace yolo_cam

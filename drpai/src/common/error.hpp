// The errors this program raises on purpose. A message has the value, the limit and what to look at next.
#pragma once

#include <stdexcept>

namespace yolo_cam {

// Something cannot be used as it was asked to: a device, a channel, a model, an option. Exit code 2.
class DeviceError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace yolo_cam

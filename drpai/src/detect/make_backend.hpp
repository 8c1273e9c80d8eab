#pragma once

#include <memory>
#include <string>

#include "detect/inference_backend.hpp"

namespace yolo_cam {

// `name` is `cpu` (`model` an ONNX file) or `drpai` (`model` a folder). Throws DeviceError, also for a backend that
// this program was built without.
std::unique_ptr<InferenceBackend> make_backend(const std::string& name, const std::string& model, int drpai_frequency);

}  // namespace yolo_cam

// The network on the DRP-AI accelerator of the RZ/V2N, through Renesas' MERA2 runtime.
//
// Compiled only where that SDK is (CMake: -DMERA2_ROOT=...). The compiled model is a folder made by the DRP-AI
// translator from the same ONNX, cut at the head convolutions and quantised to INT8.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "MeraDrpRuntimeWrapper.h"
#include "detect/inference_backend.hpp"

namespace yolo_cam {

// Where the kernel keeps memory for the accelerator. Throws DeviceError: no accelerator, or it may not be used.
std::uint64_t drpai_area_address(const std::string& device = "/dev/drpai0");

class DrpaiBackend final : public InferenceBackend {
 public:
  // `area_address` is where the runtime may load the model. Throws DeviceError: no model in the folder, or another one.
  DrpaiBackend(const std::string& model_dir, int frequency_index, std::uint64_t area_address);

  const std::vector<HeadTensor>& run(const float* input) override;
  std::string description() const override;

 private:
  std::string model_dir_;
  int frequency_index_;
  MeraDrpRuntimeWrapper runtime_;
  // One head's values each, in single precision.
  std::vector<std::vector<float>> values_;
  std::vector<HeadTensor> heads_;
};

}  // namespace yolo_cam

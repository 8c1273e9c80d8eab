// What runs the network: a prepared picture in, raw head tensors out. Decoding is the same for all of them.
#pragma once

#include <string>
#include <vector>

namespace yolo_cam {

// The network's input: 1 x 3 x 256 x 320 (N, C, H, W), RGB, 0 to 1.
constexpr int INPUT_WIDTH = 320;
constexpr int INPUT_HEIGHT = 256;
constexpr int INPUT_CHANNELS = 3;
constexpr int INPUT_VALUES = INPUT_CHANNELS * INPUT_HEIGHT * INPUT_WIDTH;

// Planes of a head: the logit of "the target's box is here", and the distances from the cell's centre to the box's
// left, top, right and bottom, >= 0, in units of the stride.
constexpr int HEAD_PLANES = 5;

// One head's output, HEAD_PLANES x rows x columns. `values` belongs to the backend and lasts until its next run.
struct HeadTensor {
  int stride;
  int rows;
  int columns;
  const float* values;
};

class InferenceBackend {
 public:
  InferenceBackend() = default;
  InferenceBackend(const InferenceBackend&) = delete;
  InferenceBackend& operator=(const InferenceBackend&) = delete;
  InferenceBackend(InferenceBackend&&) = delete;
  InferenceBackend& operator=(InferenceBackend&&) = delete;
  virtual ~InferenceBackend() = default;

  // `input` holds INPUT_VALUES floats. Throws DeviceError when the network or its hardware fails.
  virtual const std::vector<HeadTensor>& run(const float* input) = 0;

  // For the log: which library, which version.
  virtual std::string description() const = 0;
};

// The stride of a head with so many values: INPUT / stride cells each way. Throws DeviceError if none fits, naming
// `where`.
int stride_of_values(std::size_t values, const std::string& where);

}  // namespace yolo_cam

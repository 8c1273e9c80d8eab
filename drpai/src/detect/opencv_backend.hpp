// The network on the processor, through OpenCV's dnn: 4.6 (Debian 12) and newer, 5.x included.
#pragma once

#include <string>
#include <vector>

#include <opencv2/dnn.hpp>

#include "detect/inference_backend.hpp"

namespace yolo_cam {

class OpencvBackend final : public InferenceBackend {
 public:
  // Throws DeviceError: the file is not there, is no network that OpenCV reads, or has other outputs than heads.
  explicit OpencvBackend(const std::string& model_path);

  const std::vector<HeadTensor>& run(const float* input) override;
  std::string description() const override;

 private:
  void check_heads();

  std::string model_path_;
  cv::dnn::Net network_;
  std::vector<cv::String> output_names_;
  std::vector<cv::Mat> outputs_;
  std::vector<HeadTensor> heads_;
};

}  // namespace yolo_cam

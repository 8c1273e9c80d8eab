#include "detect/opencv_backend.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>

#include <opencv2/core.hpp>

#include "common/error.hpp"

namespace yolo_cam {
namespace {

// The first line of OpenCV's words. They quote names out of the file, which in a corrupt one are anything.
std::string first_line(const std::string& text) {
  constexpr std::size_t LONGEST = 200;
  std::string line = text.substr(0, std::min(text.find('\n'), LONGEST));
  std::replace_if(line.begin(), line.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return line;
}

cv::dnn::Net read_network(const std::string& path) {
  if (!std::ifstream(path).good()) {
    throw DeviceError("model " + path + " is not there or may not be read; --model names an ONNX file");
  }
  try {
    cv::dnn::Net network = cv::dnn::readNetFromONNX(path);
    if (network.empty()) {
      throw DeviceError("model " + path + " holds no network; fetch it again (deploy/model)");
    }
    network.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
    network.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
    return network;
  } catch (const cv::Exception& error) {
    throw DeviceError("model " + path + " cannot be read by OpenCV " CV_VERSION ", it may be corrupt: " +
                      first_line(error.err) + "; fetch it again (deploy/model)");
  }
}

}  // namespace

OpencvBackend::OpencvBackend(const std::string& model_path)
    : model_path_(model_path), network_(read_network(model_path)), output_names_(network_.getUnconnectedOutLayersNames()) {
  const std::vector<float> grey(INPUT_VALUES, 0.5F);
  run(grey.data());
  check_heads();
}

const std::vector<HeadTensor>& OpencvBackend::run(const float* input) {
  const int shape[] = {1, INPUT_CHANNELS, INPUT_HEIGHT, INPUT_WIDTH};
  // The header only reads: OpenCV's Mat cannot say so.
  const cv::Mat blob(4, shape, CV_32F, const_cast<float*>(input));
  try {
    network_.setInput(blob);
    network_.forward(outputs_, output_names_);
  } catch (const cv::Exception& error) {
    throw DeviceError("model " + model_path_ + " fails on a picture of 320x256 in OpenCV " CV_VERSION ": " +
                      first_line(error.err) + "; is it the network of deploy/model?");
  }
  heads_.clear();
  for (const cv::Mat& output : outputs_) {
    if (output.dims != 4 || output.size[0] != 1 || output.size[1] != HEAD_PLANES || output.type() != CV_32F ||
        !output.isContinuous()) {
      throw DeviceError("model " + model_path_ + " has an output that is no head; each must be float32 [1, 5, 256/s, 320/s]");
    }
    const int stride = stride_of_values(output.total(), "model " + model_path_);
    heads_.push_back({stride, output.size[2], output.size[3], output.ptr<float>()});
  }
  std::sort(heads_.begin(), heads_.end(), [](const HeadTensor& a, const HeadTensor& b) { return a.stride < b.stride; });
  return heads_;
}

std::string OpencvBackend::description() const { return "OpenCV " CV_VERSION " dnn on the processor"; }

void OpencvBackend::check_heads() {
  if (heads_.empty()) {
    throw DeviceError("model " + model_path_ + " has no output; is it the network of deploy/model?");
  }
  for (const HeadTensor& head : heads_) {
    const auto values = static_cast<std::size_t>(HEAD_PLANES) * head.rows * head.columns;
    if (head.rows != INPUT_HEIGHT / head.stride ||
        !std::all_of(head.values, head.values + values, [](float value) { return std::isfinite(value); })) {
      throw DeviceError("model " + model_path_ + " answers nonsense to a grey picture; it may be corrupt, fetch it again");
    }
  }
}

}  // namespace yolo_cam

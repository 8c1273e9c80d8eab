#include "detect/drpai_backend.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <exception>
#include <system_error>
#include <tuple>

#include <fcntl.h>
#include <linux/drpai.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/error.hpp"
#include "detect/half_float.hpp"

namespace yolo_cam {
namespace {

void check_folder(const std::string& model_dir) {
  struct stat status {};
  if (::stat(model_dir.c_str(), &status) != 0 || !S_ISDIR(status.st_mode)) {
    throw DeviceError("model folder " + model_dir + " is not there; --model names the folder the DRP-AI translator made");
  }
}

}  // namespace

std::uint64_t drpai_area_address(const std::string& device) {
  const int descriptor = ::open(device.c_str(), O_RDWR | O_CLOEXEC);
  if (descriptor < 0) {
    throw DeviceError("accelerator " + device + ": " + std::generic_category().message(errno) +
                      "; is the drpai driver loaded, and may this user use it? --backend cpu does without");
  }
  // The width of its address is the driver's own and differs between chips.
  drpai_data_t area{};
  const int result = ::ioctl(descriptor, DRPAI_GET_DRPAI_AREA, &area);
  const int error = errno;
  ::close(descriptor);
  if (result != 0) {
    throw DeviceError("accelerator " + device + " does not tell its memory: " + std::generic_category().message(error));
  }
  return area.address;
}

DrpaiBackend::DrpaiBackend(const std::string& model_dir, int frequency_index, std::uint64_t area_address)
    : model_dir_(model_dir), frequency_index_(frequency_index) {
  check_folder(model_dir);
  try {
    if (!runtime_.LoadModel(model_dir, area_address)) {
      throw DeviceError("model folder " + model_dir + " cannot be loaded; was it compiled for this chip and this runtime?");
    }
  } catch (const DeviceError&) {
    throw;
  } catch (const std::exception& error) {
    throw DeviceError("model folder " + model_dir + " cannot be loaded: " + error.what());
  }
  if (runtime_.GetInputDataType(0) != InOutDataType::FLOAT32) {
    throw DeviceError("model in " + model_dir + " does not take single precision; compile it with a float32 input");
  }
  const std::vector<float> grey(INPUT_VALUES, 0.5F);
  run(grey.data());
}

const std::vector<HeadTensor>& DrpaiBackend::run(const float* input) {
  try {
    runtime_.SetInput(0, input);
    runtime_.Run(frequency_index_);
  } catch (const std::exception& error) {
    throw DeviceError(std::string("the accelerator failed: ") + error.what());
  }
  const int outputs = runtime_.GetNumOutput();
  if (outputs <= 0) {
    throw DeviceError("model in " + model_dir_ + " gives no output");
  }
  values_.resize(static_cast<std::size_t>(outputs));
  heads_.clear();
  for (int i = 0; i < outputs; ++i) {
    const auto [type, data, count] = runtime_.GetOutput(i);
    auto& values = values_[static_cast<std::size_t>(i)];
    values.resize(static_cast<std::size_t>(std::max<std::int64_t>(count, 0)));
    if (type == InOutDataType::FLOAT16) {
      const auto* halves = static_cast<const std::uint16_t*>(data);
      std::transform(halves, halves + values.size(), values.begin(), float_of_half);
    } else if (type == InOutDataType::FLOAT32) {
      std::memcpy(values.data(), data, values.size() * sizeof(float));
    } else {
      throw DeviceError("model in " + model_dir_ + " has an output of neither half nor single precision");
    }
    const int stride = stride_of_values(values.size(), "model in " + model_dir_);
    heads_.push_back({stride, INPUT_HEIGHT / stride, INPUT_WIDTH / stride, values.data()});
  }
  std::sort(heads_.begin(), heads_.end(), [](const HeadTensor& a, const HeadTensor& b) { return a.stride < b.stride; });
  return heads_;
}

std::string DrpaiBackend::description() const {
  return "DRP-AI, frequency index " + std::to_string(frequency_index_);
}

}  // namespace yolo_cam

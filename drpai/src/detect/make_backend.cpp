#include "detect/make_backend.hpp"

#include "common/error.hpp"
#include "detect/opencv_backend.hpp"
#ifdef WITH_DRPAI
#include "detect/drpai_backend.hpp"
#endif

namespace yolo_cam {

std::unique_ptr<InferenceBackend> make_backend(const std::string& name, const std::string& model,
                                               [[maybe_unused]] int drpai_frequency) {
  if (name == "cpu") {
    return std::make_unique<OpencvBackend>(model);
  }
  if (name == "drpai") {
#ifdef WITH_DRPAI
    return std::make_unique<DrpaiBackend>(model, drpai_frequency, drpai_area_address());
#else
    throw DeviceError("this program was built without the DRP-AI runtime; build it with -DMERA2_ROOT, or use --backend cpu");
#endif
  }
  throw DeviceError("--backend is '" + name + "'; it must be cpu or drpai");
}

}  // namespace yolo_cam

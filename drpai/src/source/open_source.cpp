#include <algorithm>
#include <cctype>
#include <filesystem>

#include "common/error.hpp"
#include "source/file_sources.hpp"
#include "source/frame_source.hpp"
#include "source/v4l2_source.hpp"

namespace yolo_cam {

std::unique_ptr<FrameSource> open_source(const SourceOptions& options) {
  const std::string& source = options.source;
  if (source == "sim") {
    return std::make_unique<SharedMemorySource>(options.prefix);
  }
  const bool number = !source.empty() && std::all_of(source.begin(), source.end(), [](unsigned char c) { return std::isdigit(c); });
  if (number || source.rfind("/dev/", 0) == 0) {
    const std::string device = number ? "/dev/video" + source : source;
    return std::make_unique<V4l2Source>(device, options.width_px, options.height_px, options.rate_hz);
  }
  std::error_code ignored;
  if (std::filesystem::is_directory(source, ignored)) {
    return std::make_unique<FolderSource>(source, options.width_px, options.height_px, options.rate_hz, options.loop);
  }
  if (std::filesystem::is_regular_file(source, ignored)) {
    return std::make_unique<VideoFileSource>(source, options.rate_hz, options.loop);
  }
  throw DeviceError("source " + source +
                    " is not there; --source takes sim, a camera (0, /dev/video0), a video file or a folder of images");
}

}  // namespace yolo_cam

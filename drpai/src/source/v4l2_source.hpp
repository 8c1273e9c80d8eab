// A USB camera through Video4Linux, with the driver's own time of exposure.
//
// OpenCV's VideoCapture hands out neither that time nor an error for a camera that was unplugged.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "source/frame_source.hpp"
#include "source/v4l2_api.hpp"

namespace yolo_cam {

class V4l2Source final : public FrameSource {
 public:
  // Throws DeviceError: no such camera, not readable, or it has neither YUYV nor MJPEG pictures of this size.
  V4l2Source(std::string device, int width_px, int height_px, double rate_hz, V4l2Api& api = system_v4l2());
  V4l2Source(const V4l2Source&) = delete;
  V4l2Source& operator=(const V4l2Source&) = delete;
  V4l2Source(V4l2Source&&) = delete;
  V4l2Source& operator=(V4l2Source&&) = delete;
  ~V4l2Source() override;

  // The newest picture of those that have come; older ones are thrown away.
  std::optional<Picture> poll() override;

 private:
  struct Buffer {
    void* at;
    std::size_t size;
  };

  void open();
  void choose_format();
  void start();
  void close();
  [[noreturn]] void refuse(const std::string& what) const;
  bool convert(const Buffer& buffer, std::size_t used, cv::Mat& image) const;
  void lose(const std::string& why);

  std::string device_;
  int width_px_;
  int height_px_;
  double rate_hz_;
  V4l2Api& api_;
  int descriptor_ = -1;
  std::uint32_t pixel_format_ = 0;
  bool streaming_ = false;
  std::vector<Buffer> buffers_;
  double last_s_ = 0.0;
  double given_s_ = 0.0;
  std::int64_t count_ = 0;
  unsigned broken_ = 0;
};

}  // namespace yolo_cam

// Where pictures come from.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "ipc/channel_reader.hpp"

namespace yolo_cam {

// Why there will be no more pictures. `lost`: this was not the end of a file, so the program has failed.
struct SourceEnd {
  bool lost;
  std::string why;
};

class FrameSource {
 public:
  FrameSource() = default;
  FrameSource(const FrameSource&) = delete;
  FrameSource& operator=(const FrameSource&) = delete;
  FrameSource(FrameSource&&) = delete;
  FrameSource& operator=(FrameSource&&) = delete;
  virtual ~FrameSource() = default;

  // The newest picture, stamped with the time at which it was taken. Nothing if none came within about 50 ms, or ever
  // will: see `end`.
  virtual std::optional<Picture> poll() = 0;

  const std::optional<SourceEnd>& end() const { return end_; }

 protected:
  void finish(bool lost, std::string why) { end_ = SourceEnd{lost, std::move(why)}; }

 private:
  std::optional<SourceEnd> end_;
};

struct SourceOptions {
  // sim, a camera (0, /dev/video0), a video file or a folder of images.
  std::string source;
  std::string prefix;
  int width_px;
  int height_px;
  // The most pictures a second of a camera, a file or a folder.
  double rate_hz;
  // Begin a file or folder anew when it ends.
  bool loop;
};

// Throws DeviceError: it is not there, may not be read, or is none of these.
std::unique_ptr<FrameSource> open_source(const SourceOptions& options);

}  // namespace yolo_cam

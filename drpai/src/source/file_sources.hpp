// Pictures from shared memory, a video file and a folder of images.
#pragma once

#include <string>
#include <vector>

#include <opencv2/videoio.hpp>

#include "source/frame_source.hpp"
#include "source/pacer.hpp"

namespace yolo_cam {

// The simulator's pictures. It never ends: a simulator that is gone may come back.
class SharedMemorySource final : public FrameSource {
 public:
  explicit SharedMemorySource(const std::string& prefix) : reader_(prefix) {}
  std::optional<Picture> poll() override;

 private:
  PictureReader reader_;
};

class VideoFileSource final : public FrameSource {
 public:
  VideoFileSource(std::string path, double rate_hz, bool loop);
  std::optional<Picture> poll() override;

 private:
  cv::VideoCapture& opened();

  std::string path_;
  cv::VideoCapture capture_;
  Pacer pacer_;
  bool loop_;
  std::int64_t count_ = 0;
};

// Every image of a folder, by name; scaled to the configured size, cut to its shape first.
class FolderSource final : public FrameSource {
 public:
  FolderSource(const std::string& folder, int width_px, int height_px, double rate_hz, bool loop);
  std::optional<Picture> poll() override;

 private:
  std::string folder_;
  cv::Size size_;
  Pacer pacer_;
  bool loop_;
  std::vector<std::string> paths_;
  std::size_t next_ = 0;
  std::int64_t count_ = 0;
};

// The largest piece of `image` round its middle that has `size`'s shape, scaled to it.
cv::Mat fitted(const cv::Mat& image, cv::Size size);

}  // namespace yolo_cam

// The only writer of a newest-value channel, and what this program writes: boxes and pictures.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "detect/detection.hpp"
#include "ipc/mapped_channel.hpp"
#include "ipc/slots.hpp"

namespace yolo_cam {

// Throws DeviceError on opening if another live process writes the channel.
class ChannelWriter {
 public:
  // `head_bytes` is the most that lies under a payload's CRC.
  ChannelWriter(const std::string& prefix, const Geometry& geometry, std::size_t head_bytes);

  // Publishes a payload. A file that was removed meanwhile is made again.
  void write(Bytes head, Bytes bulk = {});

  unsigned repaired() const { return repaired_; }
  unsigned reclaimed() const { return reclaimed_; }

 private:
  void claim();

  std::string path_;
  Geometry geometry_;
  std::size_t head_bytes_;
  std::optional<MappedChannel> channel_;
  std::uint64_t sequence_ = 0;
  unsigned repaired_ = 0;
  unsigned reclaimed_ = 0;
};

// Channel `detections`.
class DetectionsWriter {
 public:
  explicit DetectionsWriter(const std::string& prefix);

  // Of more boxes than fit the best ones are kept: they come best first. Throws DeviceError for a class name that is
  // too long, for half a name is another class.
  void write(double stamp_s, std::int64_t frame_id, const std::vector<Detection>& detections, const std::string& class_name);

 private:
  target_nav::ipc::RawDetectionFrame frame_{};
  ChannelWriter writer_;
};

// Channel `camera`.
class PictureWriter {
 public:
  explicit PictureWriter(const std::string& prefix, const Geometry& geometry = geometry_of<target_nav::ipc::CameraChannel>());

  // Throws DeviceError for a picture that is not 8-bit BGR, or too large.
  void write(double stamp_s, std::int64_t frame_id, const cv::Mat& image_bgr);

 private:
  ChannelWriter writer_;
};

// What guards pixels: the sum modulo 2^64 of their 8-byte words, the last one filled up with zeros.
std::uint64_t pixel_sum(const void* data, std::size_t size);

}  // namespace yolo_cam

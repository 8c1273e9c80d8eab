// A reader of a newest-value channel, and what this program reads: the calibration and the simulator's pictures.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "ipc/mapped_channel.hpp"
#include "ipc/slots.hpp"

namespace yolo_cam {

// Follows a channel through absence, restarts of its writer and re-created files.
class ChannelReader {
 public:
  // `head_bytes` is the most that lies under a payload's CRC.
  ChannelReader(const std::string& prefix, const Geometry& geometry, std::size_t head_bytes);

  // The bytes of the newest payload's head, once: nothing until a newer one has come. Bulk goes to `sink`;
  // `verify`, if there is one, judges head and bulk before they count as read.
  // Throws DeviceError: a live writer uses another layout, or the file is no channel.
  const std::vector<std::byte>* take_new(const BulkSink& sink = {}, const std::function<bool(const std::byte*)>& verify = {});

 private:
  bool fetch(const BulkSink& sink, const std::function<bool(const std::byte*)>& verify);
  bool follow_reign();

  std::string path_;
  Geometry geometry_;
  std::size_t head_bytes_;
  std::vector<std::byte> head_;
  std::optional<MappedChannel> channel_;
  std::optional<std::uint32_t> claim_;
  std::uint64_t generation_ = 0;
  std::uint64_t taken_ = 0;
};

// Channel `calibration`.
class CalibrationReader {
 public:
  explicit CalibrationReader(const std::string& prefix);
  std::optional<target_nav::ipc::Calibration> take_new();

 private:
  ChannelReader reader_;
};

struct Picture {
  double stamp_s = 0.0;
  std::int64_t frame_id = 0;
  cv::Mat image_bgr;
};

// Channel `sim_camera`, or another of pictures.
class PictureReader {
 public:
  explicit PictureReader(const std::string& prefix, const Geometry& geometry = geometry_of<target_nav::ipc::SimCameraChannel>());
  std::optional<Picture> take_new();

 private:
  ChannelReader reader_;
};

}  // namespace yolo_cam

#include "ipc/channel_writer.hpp"

#include <algorithm>
#include <cstring>

#include "common/clock.hpp"
#include "common/error.hpp"

namespace yolo_cam {
namespace {

using target_nav::ipc::CameraFrame;
using target_nav::ipc::DetectionsChannel;
using target_nav::ipc::RawDetection;
using target_nav::ipc::RawDetectionFrame;
using target_nav::ipc::SlotHeader;

constexpr std::size_t RESERVED_AT_ONCE = 1U << 16U;
constexpr std::size_t PICTURE_HEAD = offsetof(CameraFrame, image_bgr);

}  // namespace

ChannelWriter::ChannelWriter(const std::string& prefix, const Geometry& geometry, std::size_t head_bytes)
    : path_(path_of(prefix, geometry.channel)), geometry_(geometry), head_bytes_(head_bytes) {
  claim();
}

void ChannelWriter::write(Bytes head, Bytes bulk) {
  if (channel_->removed()) {
    // Somebody cleaned up /dev/shm (systemd's RemoveIPC does at logout): readers would never hear of us again.
    channel_.reset();
    ++reclaimed_;
    claim();
  }
  channel_->reserve(sizeof(SlotHeader) + head.size + bulk.size);
  SlotStore store(*channel_, sequence_);
  store.mark_busy();
  store.copy(head, bulk);
  store.mark_done();
  store.publish();
  ++sequence_;
}

void ChannelWriter::claim() {
  channel_ = MappedChannel::claim(path_, geometry_);
  const Reign reign = take_over(*channel_, head_bytes_, static_cast<std::uint64_t>(monotonic_ns()));
  channel_->reserve(sizeof(SlotHeader) + std::min(head_bytes_, RESERVED_AT_ONCE));
  sequence_ = reign.generation;
  repaired_ += reign.repaired;
}

DetectionsWriter::DetectionsWriter(const std::string& prefix)
    : writer_(prefix, geometry_of<DetectionsChannel>(), sizeof(RawDetectionFrame)) {}

void DetectionsWriter::write(double stamp_s, std::int64_t frame_id, const std::vector<Detection>& detections,
                             const std::string& class_name) {
  constexpr std::size_t NAME_BYTES = sizeof RawDetection::class_name;
  if (class_name.size() >= NAME_BYTES) {
    throw DeviceError("class name '" + class_name + "' has " + std::to_string(class_name.size()) +
                      " bytes; at most " + std::to_string(NAME_BYTES - 1) + " fit");
  }
  const std::size_t count = std::min(detections.size(), std::size(frame_.detections));
  frame_.stamp_s = stamp_s;
  frame_.frame_id = frame_id;
  frame_.detections_count = static_cast<std::uint32_t>(count);
  for (std::size_t i = 0; i < count; ++i) {
    RawDetection& to = frame_.detections[i];
    const Detection& from = detections[i];
    std::memset(to.class_name, 0, NAME_BYTES);
    std::memcpy(to.class_name, class_name.data(), class_name.size());
    to.score = from.score;
    to.u_px = from.u_px;
    to.v_px = from.v_px;
    to.width_px = from.width_px;
    to.height_px = from.height_px;
  }
  writer_.write({&frame_, offsetof(RawDetectionFrame, detections) + count * sizeof(RawDetection)});
}

PictureWriter::PictureWriter(const std::string& prefix, const Geometry& geometry)
    : writer_(prefix, geometry, PICTURE_HEAD) {}

void PictureWriter::write(double stamp_s, std::int64_t frame_id, const cv::Mat& image_bgr) {
  if (image_bgr.type() != CV_8UC3 || image_bgr.empty()) {
    throw DeviceError("a picture of type " + std::to_string(image_bgr.type()) + "; it must be 8-bit BGR");
  }
  const cv::Mat whole = image_bgr.isContinuous() ? image_bgr : image_bgr.clone();
  const std::size_t size = whole.total() * whole.elemSize();
  if (size > sizeof CameraFrame::image_bgr) {
    throw DeviceError("a picture of " + std::to_string(whole.cols) + "x" + std::to_string(whole.rows) +
                      "; at most 1920x1080 fits: set camera.width_px and camera.height_px lower");
  }
  // The fixed part of a CameraFrame; the pixels follow it in the slot.
  struct Head {
    double stamp_s;
    std::int64_t frame_id;
    std::uint32_t height_px;
    std::uint32_t width_px;
    std::uint64_t pixel_sum;
  };
  static_assert(sizeof(Head) == PICTURE_HEAD && offsetof(Head, pixel_sum) == offsetof(CameraFrame, pixel_sum));
  const Head head{stamp_s, frame_id, static_cast<std::uint32_t>(whole.rows), static_cast<std::uint32_t>(whole.cols),
                  pixel_sum(whole.data, size)};
  writer_.write({&head, sizeof head}, {whole.data, size});
}

std::uint64_t pixel_sum(const void* data, std::size_t size) {
  const auto* byte = static_cast<const unsigned char*>(data);
  std::uint64_t sum = 0;
  std::size_t at = 0;
  for (; at + sizeof sum <= size; at += sizeof sum) {
    std::uint64_t word = 0;
    std::memcpy(&word, byte + at, sizeof word);
    sum += word;
  }
  std::uint64_t rest = 0;
  std::memcpy(&rest, byte + at, size - at);
  return sum + rest;
}

}  // namespace yolo_cam

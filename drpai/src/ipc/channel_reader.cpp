#include "ipc/channel_reader.hpp"

#include <cstring>

#include "common/error.hpp"
#include "ipc/channel_writer.hpp"

namespace yolo_cam {
namespace {

using target_nav::ipc::Calibration;
using target_nav::ipc::CalibrationChannel;
using target_nav::ipc::CameraFrame;

// Copies attempted in one call before a reader is content with what it has.
constexpr int TRIES = 16;
constexpr std::size_t PICTURE_HEAD = offsetof(CameraFrame, image_bgr);

template <class T>
T value_at(const std::byte* data, std::size_t offset) {
  T value{};
  std::memcpy(&value, data + offset, sizeof value);
  return value;
}

}  // namespace

ChannelReader::ChannelReader(const std::string& prefix, const Geometry& geometry, std::size_t head_bytes)
    : path_(path_of(prefix, geometry.channel)), geometry_(geometry), head_bytes_(head_bytes) {}

const std::vector<std::byte>* ChannelReader::take_new(const BulkSink& sink,
                                                      const std::function<bool(const std::byte*)>& verify) {
  for (int attempt = 0; attempt < 2; ++attempt) {
    if (!channel_) {
      channel_ = MappedChannel::open_for_reading(path_, geometry_);
    }
    if (!channel_) {
      return nullptr;
    }
    if (fetch(sink, verify)) {
      return &head_;
    }
    // Nothing new: perhaps because the writer writes another file of the same name by now.
    const auto inode = inode_of(path_);
    if (!inode || *inode == channel_->inode()) {
      return nullptr;
    }
    channel_.reset();
    claim_.reset();
  }
  return nullptr;
}

bool ChannelReader::fetch(const BulkSink& sink, const std::function<bool(const std::byte*)>& verify) {
  if (!follow_reign()) {
    return false;
  }
  for (int attempt = 0; attempt < TRIES; ++attempt) {
    const std::uint32_t low = channel_->header().published.load(std::memory_order_acquire);
    if (low == static_cast<std::uint32_t>(taken_) || low == static_cast<std::uint32_t>(generation_ - 1)) {
      return false;
    }
    head_.resize(head_bytes_);
    const auto result = load(*channel_, low, head_.data(), head_.size(), sink);
    const auto* loaded = std::get_if<Loaded>(&result);
    if (loaded == nullptr) {
      continue;
    }
    if (loaded->sequence < generation_ || loaded->sequence <= taken_) {
      return false;
    }
    head_.resize(loaded->head_bytes);
    if (verify && !verify(head_.data())) {
      continue;
    }
    taken_ = loaded->sequence;
    return true;
  }
  return false;
}

bool ChannelReader::follow_reign() {
  const auto& header = channel_->header();
  const std::uint32_t before = header.claim.load(std::memory_order_acquire);
  if (claim_ == before) {
    return true;
  }
  const std::uint64_t generation = static_cast<std::uint64_t>(header.generation_high) << 32 | header.generation_low;
  std::atomic_thread_fence(std::memory_order_acquire);
  if ((before & 1U) != 0 || generation == 0 || header.claim.load(std::memory_order_relaxed) != before) {
    return false;
  }
  generation_ = generation;
  claim_ = before;
  return true;
}

CalibrationReader::CalibrationReader(const std::string& prefix)
    : reader_(prefix, geometry_of<CalibrationChannel>(), sizeof(Calibration)) {}

std::optional<Calibration> CalibrationReader::take_new() {
  const auto* head = reader_.take_new();
  if (head == nullptr || head->size() != sizeof(Calibration)) {
    return std::nullopt;
  }
  Calibration calibration{};
  std::memcpy(&calibration, head->data(), sizeof calibration);
  calibration.class_name[sizeof calibration.class_name - 1] = '\0';
  return calibration;
}

PictureReader::PictureReader(const std::string& prefix, const Geometry& geometry)
    : reader_(prefix, geometry, PICTURE_HEAD) {}

std::optional<Picture> PictureReader::take_new() {
  Picture picture;
  const auto allocate = [&](const std::byte* head, std::size_t head_bytes, std::size_t bulk_bytes) -> void* {
    if (head_bytes != PICTURE_HEAD) {
      return nullptr;
    }
    const auto rows = value_at<std::uint32_t>(head, offsetof(CameraFrame, height_px));
    const auto columns = value_at<std::uint32_t>(head, offsetof(CameraFrame, width_px));
    if (bulk_bytes == 0 || static_cast<std::size_t>(rows) * columns * 3 != bulk_bytes) {
      return nullptr;
    }
    picture.image_bgr.create(static_cast<int>(rows), static_cast<int>(columns), CV_8UC3);
    return picture.image_bgr.data;
  };
  const auto intact = [&](const std::byte* head) {
    const cv::Mat& image = picture.image_bgr;
    return pixel_sum(image.data, image.total() * image.elemSize()) ==
           value_at<std::uint64_t>(head, offsetof(CameraFrame, pixel_sum));
  };
  const auto* head = reader_.take_new(allocate, intact);
  if (head == nullptr) {
    return std::nullopt;
  }
  picture.stamp_s = value_at<double>(head->data(), offsetof(CameraFrame, stamp_s));
  picture.frame_id = value_at<std::int64_t>(head->data(), offsetof(CameraFrame, frame_id));
  return picture;
}

}  // namespace yolo_cam

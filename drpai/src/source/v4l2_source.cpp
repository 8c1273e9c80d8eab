#include "source/v4l2_source.hpp"

#include <cerrno>
#include <cmath>
#include <system_error>
#include <utility>

#include <linux/videodev2.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "common/clock.hpp"
#include "common/error.hpp"
#include "common/log.hpp"
#include "source/pacer.hpp"

namespace yolo_cam {
namespace {

constexpr std::uint32_t BUFFERS = 4;
// No picture for so long and the camera is gone, whatever the driver says.
constexpr double SILENCE_MAX_S = 2.0;
// A picture that comes when this much of the period has gone by is not too early: cameras jitter.
constexpr double EARLY_SHARE = 0.75;
// A stamp farther off than this is not of the monotonic clock, whatever its flag says.
constexpr double STAMP_AGE_MAX_S = 1.0;
constexpr double US = 1e-6;

std::string last_error() { return std::generic_category().message(errno); }

double stamp_of(const v4l2_buffer& buffer, double now_s) {
  const bool monotonic = (buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  const double stamp_s = static_cast<double>(buffer.timestamp.tv_sec) + US * static_cast<double>(buffer.timestamp.tv_usec);
  return monotonic && stamp_s <= now_s && now_s - stamp_s < STAMP_AGE_MAX_S ? stamp_s : now_s;
}

v4l2_buffer capture_buffer(std::uint32_t index = 0) {
  v4l2_buffer buffer{};
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.memory = V4L2_MEMORY_MMAP;
  buffer.index = index;
  return buffer;
}

}  // namespace

V4l2Source::V4l2Source(std::string device, int width_px, int height_px, double rate_hz, V4l2Api& api)
    : device_(std::move(device)), width_px_(width_px), height_px_(height_px), rate_hz_(rate_hz), api_(api) {
  try {
    open();
    choose_format();
    start();
  } catch (...) {
    close();
    throw;
  }
}

V4l2Source::~V4l2Source() { close(); }

void V4l2Source::refuse(const std::string& what) const { throw DeviceError("camera " + device_ + " " + what); }

void V4l2Source::open() {
  descriptor_ = api_.open(device_);
  if (descriptor_ < 0) {
    const int error = errno;
    if (error == ENOENT || error == ENODEV || error == ENXIO) {
      refuse("is not there; plug it in or choose another --source");
    }
    if (error == EACCES || error == EPERM) {
      refuse("may not be read; add the user to the group `video` and log in again");
    }
    if (error == EBUSY) {
      refuse("is in use; does another program hold it?");
    }
    refuse("cannot be opened: " + std::generic_category().message(error));
  }
  v4l2_capability capability{};
  if (api_.control(descriptor_, VIDIOC_QUERYCAP, &capability) < 0) {
    refuse("is no camera: " + last_error());
  }
  const std::uint32_t can =
      (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? capability.device_caps : capability.capabilities;
  if ((can & V4L2_CAP_VIDEO_CAPTURE) == 0 || (can & V4L2_CAP_STREAMING) == 0) {
    refuse("takes no pictures (a metadata node?); cameras often have two nodes, try the other one");
  }
}

void V4l2Source::choose_format() {
  // Uncompressed first: what JPEG does to edges moves a small box by a pixel.
  for (const std::uint32_t wanted : {V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_MJPEG}) {
    v4l2_format format{};
    format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    format.fmt.pix.width = static_cast<std::uint32_t>(width_px_);
    format.fmt.pix.height = static_cast<std::uint32_t>(height_px_);
    format.fmt.pix.pixelformat = wanted;
    format.fmt.pix.field = V4L2_FIELD_ANY;
    if (api_.control(descriptor_, VIDIOC_S_FMT, &format) < 0) {
      if (errno == EBUSY) {
        refuse("is in use; does another program hold it?");
      }
      continue;
    }
    const bool fits = format.fmt.pix.pixelformat == wanted && format.fmt.pix.width == static_cast<std::uint32_t>(width_px_) &&
                      format.fmt.pix.height == static_cast<std::uint32_t>(height_px_);
    if (fits) {
      pixel_format_ = wanted;
      return;
    }
  }
  refuse("gives no pictures of " + std::to_string(width_px_) + "x" + std::to_string(height_px_) +
         " as YUYV or MJPEG; set camera.width_px, camera.height_px and the focal_px that belongs to them");
}

void V4l2Source::start() {
  v4l2_streamparm parameters{};
  parameters.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  parameters.parm.capture.timeperframe = {1, static_cast<std::uint32_t>(std::lround(std::ceil(rate_hz_)))};
  // A camera that cannot be told keeps its own rate; what is too much is left out in `poll`.
  api_.control(descriptor_, VIDIOC_S_PARM, &parameters);
  v4l2_requestbuffers request{};
  request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  request.memory = V4L2_MEMORY_MMAP;
  request.count = BUFFERS;
  if (api_.control(descriptor_, VIDIOC_REQBUFS, &request) < 0 || request.count < 2) {
    refuse("gives no buffers: " + last_error());
  }
  for (std::uint32_t index = 0; index < request.count; ++index) {
    v4l2_buffer buffer = capture_buffer(index);
    if (api_.control(descriptor_, VIDIOC_QUERYBUF, &buffer) < 0) {
      refuse("does not tell of its buffers: " + last_error());
    }
    void* at = api_.map(descriptor_, buffer.length, buffer.m.offset);
    if (at == nullptr) {
      refuse("does not share its buffers: " + last_error());
    }
    buffers_.push_back({at, buffer.length});
    if (api_.control(descriptor_, VIDIOC_QBUF, &buffer) < 0) {
      refuse("does not take its buffers: " + last_error());
    }
  }
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (api_.control(descriptor_, VIDIOC_STREAMON, &type) < 0) {
    refuse("does not start: " + last_error());
  }
  streaming_ = true;
  last_s_ = monotonic_s();
}

void V4l2Source::close() {
  if (descriptor_ < 0) {
    return;
  }
  if (streaming_) {
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    api_.control(descriptor_, VIDIOC_STREAMOFF, &type);
  }
  for (const Buffer& buffer : buffers_) {
    api_.unmap(buffer.at, buffer.size);
  }
  api_.close(descriptor_);
  descriptor_ = -1;
}

std::optional<Picture> V4l2Source::poll() {
  if (end()) {
    return std::nullopt;
  }
  if (api_.wait(descriptor_, POLL_LIMIT_S) < 0) {
    lose(last_error());
    return std::nullopt;
  }
  // All that is there, so that what is given is the newest: a slow network must not work through a queue.
  std::optional<v4l2_buffer> newest;
  while (true) {
    v4l2_buffer buffer = capture_buffer();
    if (api_.control(descriptor_, VIDIOC_DQBUF, &buffer) < 0) {
      if (errno == EAGAIN) {
        break;
      }
      lose(last_error());
      return std::nullopt;
    }
    if (newest) {
      api_.control(descriptor_, VIDIOC_QBUF, &*newest);
    }
    newest = buffer;
  }
  const double now_s = monotonic_s();
  if (!newest) {
    if (now_s - last_s_ > SILENCE_MAX_S) {
      lose("no picture for 2 s");
    }
    return std::nullopt;
  }
  last_s_ = now_s;
  const double stamp_s = stamp_of(*newest, now_s);
  Picture picture;
  const bool due = stamp_s - given_s_ >= EARLY_SHARE / rate_hz_;
  const bool whole = (newest->flags & V4L2_BUF_FLAG_ERROR) == 0 && newest->index < buffers_.size();
  const bool good = due && whole && convert(buffers_[newest->index], newest->bytesused, picture.image_bgr);
  if (api_.control(descriptor_, VIDIOC_QBUF, &*newest) < 0) {
    lose(last_error());
    return std::nullopt;
  }
  if (!good) {
    if (due && ++broken_ % 30 == 1) {
      log::warning("camera " + device_ + " gave a broken picture, the " + std::to_string(broken_) + "th; is the cable sound?");
    }
    return std::nullopt;
  }
  given_s_ = stamp_s;
  picture.stamp_s = stamp_s;
  picture.frame_id = ++count_;
  return picture;
}

bool V4l2Source::convert(const Buffer& buffer, std::size_t used, cv::Mat& image) const {
  if (pixel_format_ == V4L2_PIX_FMT_YUYV) {
    if (used < static_cast<std::size_t>(width_px_) * height_px_ * 2 || used > buffer.size) {
      return false;
    }
    const cv::Mat yuyv(height_px_, width_px_, CV_8UC2, buffer.at);
    cv::cvtColor(yuyv, image, cv::COLOR_YUV2BGR_YUYV);
    return true;
  }
  if (used == 0 || used > buffer.size) {
    return false;
  }
  image = cv::imdecode(cv::Mat(1, static_cast<int>(used), CV_8U, buffer.at), cv::IMREAD_COLOR);
  return image.cols == width_px_ && image.rows == height_px_;
}

void V4l2Source::lose(const std::string& why) {
  finish(true, "camera " + device_ + " gives no more pictures (" + why + "); is it still plugged in?");
}

}  // namespace yolo_cam

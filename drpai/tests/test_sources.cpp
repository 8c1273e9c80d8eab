// Pictures from files, from shared memory, and from a camera that can be unplugged.
#include <cerrno>
#include <cstring>
#include <deque>
#include <fstream>

#include <doctest/doctest.h>
#include <linux/videodev2.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "common/error.hpp"
#include "ipc/channel_writer.hpp"
#include "source/file_sources.hpp"
#include "source/v4l2_source.hpp"
#include "support.hpp"

using namespace yolo_cam;

namespace {

constexpr int WIDTH = 64;
constexpr int HEIGHT = 48;

std::vector<Picture> until_end(FrameSource& source) {
  std::vector<Picture> pictures;
  while (!source.end()) {
    if (auto picture = source.poll()) {
      pictures.push_back(*picture);
    }
  }
  return pictures;
}

// A camera made of memory. What it does is set by the test; -1 and errno as the kernel would.
class FakeCamera final : public V4l2Api {
 public:
  int open(const std::string&) override {
    errno = open_error;
    return open_error != 0 ? -1 : 7;
  }
  void close(int) override { ++closed; }
  int wait(int, double) override {
    if (unplugged) {
      errno = ENODEV;
      return -1;
    }
    return ready.empty() ? 0 : 1;
  }
  void* map(int, std::size_t, std::size_t offset) override { return memory[offset].data(); }
  void unmap(void*, std::size_t) override { ++unmapped; }

  int control(int, unsigned long request, void* argument) override {
    if (unplugged) {
      errno = ENODEV;
      return -1;
    }
    switch (request) {
      case VIDIOC_QUERYCAP:
        static_cast<v4l2_capability*>(argument)->capabilities = capabilities;
        return 0;
      case VIDIOC_S_FMT: {
        auto& pix = static_cast<v4l2_format*>(argument)->fmt.pix;
        if (pix.pixelformat != format) {
          pix.pixelformat = format;  // As drivers do: they answer with what they would give.
        }
        pix.width = width;
        pix.height = height;
        return 0;
      }
      case VIDIOC_S_PARM:
        asked_rate = static_cast<v4l2_streamparm*>(argument)->parm.capture.timeperframe.denominator;
        return 0;
      case VIDIOC_REQBUFS:
        memory.assign(static_cast<v4l2_requestbuffers*>(argument)->count, std::vector<unsigned char>(WIDTH * HEIGHT * 4));
        return 0;
      case VIDIOC_QUERYBUF: {
        auto& buffer = *static_cast<v4l2_buffer*>(argument);
        buffer.length = static_cast<std::uint32_t>(memory[buffer.index].size());
        buffer.m.offset = buffer.index;
        return 0;
      }
      case VIDIOC_QBUF:
        free.push_back(static_cast<v4l2_buffer*>(argument)->index);
        return 0;
      case VIDIOC_DQBUF: {
        if (ready.empty()) {
          errno = EAGAIN;
          return -1;
        }
        *static_cast<v4l2_buffer*>(argument) = ready.front();
        ready.pop_front();
        return 0;
      }
      case VIDIOC_STREAMON:
        streaming = true;
        return 0;
      case VIDIOC_STREAMOFF:
        streaming = false;
        return 0;
      default:
        errno = ENOTTY;
        return -1;
    }
  }

  void expose(const std::vector<unsigned char>& bytes, double stamp_s, std::uint32_t flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC) {
    REQUIRE(!free.empty());
    v4l2_buffer buffer{};
    buffer.index = free.front();
    free.pop_front();
    std::copy(bytes.begin(), bytes.end(), memory[buffer.index].begin());
    buffer.bytesused = static_cast<std::uint32_t>(bytes.size());
    buffer.flags = flags;
    buffer.timestamp.tv_sec = static_cast<long>(stamp_s);
    buffer.timestamp.tv_usec = std::lround(1e6 * (stamp_s - std::floor(stamp_s))) % 1'000'000;
    ready.push_back(buffer);
  }

  int open_error = 0;
  std::uint32_t capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  std::uint32_t format = V4L2_PIX_FMT_YUYV;
  std::uint32_t width = WIDTH;
  std::uint32_t height = HEIGHT;
  std::uint32_t asked_rate = 0;
  bool unplugged = false;
  bool streaming = false;
  int closed = 0;
  int unmapped = 0;
  std::deque<v4l2_buffer> ready;
  std::deque<std::uint32_t> free;
  std::vector<std::vector<unsigned char>> memory;
};

std::vector<unsigned char> grey_yuyv(unsigned char luma) {
  std::vector<unsigned char> bytes(WIDTH * HEIGHT * 2, 128);
  for (std::size_t i = 0; i < bytes.size(); i += 2) {
    bytes[i] = luma;
  }
  return bytes;
}

struct Camera {
  // So fast a camera that no picture comes too early for it.
  explicit Camera(double rate_hz = 1e6) : source("/dev/video9", WIDTH, HEIGHT, rate_hz, api) {}
  FakeCamera api;
  V4l2Source source;
};

std::string refusal(FakeCamera& api) {
  try {
    const V4l2Source source("/dev/video9", WIDTH, HEIGHT, 10.0, api);
  } catch (const DeviceError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a folder of images is gone through by name, scaled, and ends") {
  const support::Folder folder;
  for (const auto& [name, grey] : {std::pair("b.PNG", 20), {"a.jpg", 10}, {"c.txt", 0}}) {
    const std::string path = (folder.path / name).string();
    if (std::string(name) == "c.txt") {
      std::ofstream(path) << "no image";
    } else {
      cv::imwrite(path, cv::Mat(96, 200, CV_8UC3, cv::Scalar::all(grey)));
    }
  }
  std::ofstream((folder.path / "d.png").string()) << "broken";
  const auto source = open_source({folder.path.string(), "t", WIDTH, HEIGHT, 1000.0, false});
  const auto pictures = until_end(*source);
  REQUIRE(pictures.size() == 2);
  CHECK(pictures[0].image_bgr.size() == cv::Size(WIDTH, HEIGHT));
  CHECK(std::abs(pictures[0].image_bgr.at<cv::Vec3b>(5, 5)[0] - 10) <= 2);
  CHECK(pictures[1].frame_id == 2);
  CHECK(pictures[1].stamp_s > pictures[0].stamp_s);
  CHECK_FALSE(source->end()->lost);
  CHECK(source->end()->why.find("after 2 pictures") != std::string::npos);
}

TEST_CASE("a folder that is to begin anew does") {
  const support::Folder folder;
  cv::imwrite((folder.path / "a.png").string(), cv::Mat(HEIGHT, WIDTH, CV_8UC3, cv::Scalar::all(1)));
  FolderSource source(folder.path.string(), WIDTH, HEIGHT, 1000.0, true);
  int count = 0;
  while (count < 3) {
    count += source.poll().has_value() ? 1 : 0;
  }
  CHECK_FALSE(source.end());
}

TEST_CASE("cutting to shape keeps the middle") {
  cv::Mat wide(100, 400, CV_8UC3, cv::Scalar::all(0));
  wide(cv::Rect(134, 0, 132, 100)).setTo(cv::Scalar::all(200));
  const cv::Mat result = fitted(wide, {64, 48});
  CHECK(result.at<cv::Vec3b>(24, 1)[0] == 200);
  CHECK(result.at<cv::Vec3b>(24, 62)[0] == 200);
}

TEST_CASE("a video is played to its end at no more than its own rate") {
  const support::Folder folder;
  const std::string path = (folder.path / "v.avi").string();
  cv::VideoWriter writer(path, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 50.0, {WIDTH, HEIGHT});
  REQUIRE(writer.isOpened());
  for (int i = 0; i < 8; ++i) {
    writer.write(cv::Mat(HEIGHT, WIDTH, CV_8UC3, cv::Scalar::all(10 * i)));
  }
  writer.release();
  const auto source = open_source({path, "t", WIDTH, HEIGHT, 1000.0, false});
  const double begin_s = monotonic_s();
  const auto pictures = until_end(*source);
  CHECK(pictures.size() == 8);
  CHECK(monotonic_s() - begin_s > 7 * 0.02 * 0.9);
  CHECK_FALSE(source->end()->lost);
  CHECK(source->end()->why.find("end of") == 0);
}

TEST_CASE("what is neither camera nor file is told") {
  const support::Folder folder;
  CHECK_THROWS_WITH_AS(open_source({"/nowhere", "t", WIDTH, HEIGHT, 10.0, false}), doctest::Contains("/nowhere is not there"), DeviceError);
  CHECK_THROWS_WITH_AS(open_source({folder.path.string(), "t", WIDTH, HEIGHT, 10.0, false}), doctest::Contains("no image"), DeviceError);
  const std::string text = (folder.path / "v.avi").string();
  std::ofstream(text) << "no video";
  CHECK_THROWS_WITH_AS(open_source({text, "t", WIDTH, HEIGHT, 10.0, false}), doctest::Contains("cannot be opened"), DeviceError);
  CHECK_THROWS_WITH_AS(open_source({"/dev/video_none", "t", WIDTH, HEIGHT, 10.0, false}), doctest::Contains("camera /dev/video_none is not there"), DeviceError);
}

TEST_CASE("the simulator's pictures come through shared memory, and it may come late") {
  const support::Prefix prefix;
  SharedMemorySource source(prefix.name);
  CHECK_FALSE(source.poll());
  PictureWriter writer(prefix.name, geometry_of<target_nav::ipc::SimCameraChannel>());
  writer.write(3.25, 4, cv::Mat(HEIGHT, WIDTH, CV_8UC3, cv::Scalar::all(9)));
  const auto picture = source.poll();
  REQUIRE(picture);
  CHECK(picture->stamp_s == 3.25);
  CHECK(picture->image_bgr.at<cv::Vec3b>(1, 1)[2] == 9);
  CHECK_FALSE(source.end());
}

TEST_CASE("a camera's picture carries the driver's time of exposure") {
  Camera camera;
  CHECK(camera.api.asked_rate == 1000000);
  CHECK_FALSE(camera.source.poll());
  const double stamp_s = monotonic_s() - 0.04;
  camera.api.expose(grey_yuyv(235), stamp_s);
  const auto picture = camera.source.poll();
  REQUIRE(picture);
  CHECK(picture->stamp_s == doctest::Approx(stamp_s).epsilon(1e-9));
  CHECK(picture->image_bgr.size() == cv::Size(WIDTH, HEIGHT));
  CHECK(picture->image_bgr.at<cv::Vec3b>(10, 10)[1] >= 250);
  CHECK(camera.api.free.size() == 4);
}

TEST_CASE("a stamp that is not of the monotonic clock is not believed") {
  Camera camera;
  const double now_s = monotonic_s();
  camera.api.expose(grey_yuyv(100), 12.0);
  CHECK(camera.source.poll()->stamp_s >= now_s);
  camera.api.expose(grey_yuyv(100), monotonic_s() + 5.0);
  CHECK(camera.source.poll()->stamp_s < now_s + 4.0);
  camera.api.expose(grey_yuyv(100), monotonic_s() - 0.01, 0);
  CHECK(camera.source.poll()->stamp_s > now_s);
}

TEST_CASE("of pictures that waited only the newest is given, and every buffer goes back") {
  Camera camera;
  const double now_s = monotonic_s();
  for (int i = 0; i < 3; ++i) {
    camera.api.expose(grey_yuyv(static_cast<unsigned char>(50 + 50 * i)), now_s - 0.03 + 0.01 * i);
  }
  const auto picture = camera.source.poll();
  REQUIRE(picture);
  CHECK(picture->image_bgr.at<cv::Vec3b>(10, 10)[1] > 140);
  CHECK(camera.api.free.size() == 4);
  CHECK(picture->frame_id == 1);
}

TEST_CASE("a camera faster than wanted is thinned out") {
  Camera camera(10.0);
  int given = 0;
  const double begin_s = monotonic_s() - 0.95;
  for (int i = 0; i < 30; ++i) {
    camera.api.expose(grey_yuyv(100), begin_s + i / 32.0);
    given += camera.source.poll().has_value() ? 1 : 0;
  }
  CHECK(given >= 8);
  CHECK(given <= 12);
}

TEST_CASE("broken pictures are left out") {
  Camera camera;
  camera.api.expose(std::vector<unsigned char>(100, 0), monotonic_s());
  CHECK_FALSE(camera.source.poll());
  camera.api.expose(grey_yuyv(100), monotonic_s(), V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_ERROR);
  CHECK_FALSE(camera.source.poll());
  camera.api.expose(grey_yuyv(100), monotonic_s());
  CHECK(camera.source.poll());
  CHECK(camera.api.free.size() == 4);
}

TEST_CASE("a camera of JPEG pictures") {
  FakeCamera api;
  api.format = V4L2_PIX_FMT_MJPEG;
  V4l2Source source("/dev/video9", WIDTH, HEIGHT, 1e6, api);
  std::vector<unsigned char> jpeg;
  cv::imencode(".jpg", cv::Mat(HEIGHT, WIDTH, CV_8UC3, cv::Scalar(0, 0, 200)), jpeg);
  api.expose(jpeg, monotonic_s());
  const auto picture = source.poll();
  REQUIRE(picture);
  CHECK(std::abs(picture->image_bgr.at<cv::Vec3b>(10, 10)[2] - 200) < 6);
  api.expose({1, 2, 3}, monotonic_s());
  CHECK_FALSE(source.poll());
}

TEST_CASE("an unplugged camera ends the source and says so") {
  Camera camera;
  camera.api.unplugged = true;
  CHECK_FALSE(camera.source.poll());
  REQUIRE(camera.source.end());
  CHECK(camera.source.end()->lost);
  CHECK(camera.source.end()->why.find("still plugged in?") != std::string::npos);
  CHECK_FALSE(camera.source.poll());
}

TEST_CASE("a camera that cannot be used is refused with the reason, and closed") {
  FakeCamera gone;
  gone.open_error = ENOENT;
  CHECK(refusal(gone).find("is not there") != std::string::npos);
  FakeCamera forbidden;
  forbidden.open_error = EACCES;
  CHECK(refusal(forbidden).find("group `video`") != std::string::npos);
  FakeCamera metadata;
  metadata.capabilities = V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING;
  CHECK(refusal(metadata).find("takes no pictures") != std::string::npos);
  FakeCamera strange;
  strange.format = V4L2_PIX_FMT_H264;
  CHECK(refusal(strange).find("gives no pictures of 64x48") != std::string::npos);
  FakeCamera large;
  large.width = 1280;
  CHECK(refusal(large).find("camera.width_px") != std::string::npos);
  CHECK(large.closed == 1);
  CHECK_FALSE(large.streaming);
}

TEST_CASE("a camera is left as it was found") {
  FakeCamera api;
  {
    const V4l2Source source("/dev/video9", WIDTH, HEIGHT, 10.0, api);
    CHECK(api.streaming);
  }
  CHECK_FALSE(api.streaming);
  CHECK(api.unmapped == 4);
  CHECK(api.closed == 1);
}

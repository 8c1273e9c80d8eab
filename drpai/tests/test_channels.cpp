// The channels: what is written is read, what a dead writer leaves is not, and who may write.
#include <cstring>
#include <fstream>
#include <thread>

#include <doctest/doctest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/error.hpp"
#include "ipc/channel_reader.hpp"
#include "ipc/channel_writer.hpp"
#include "ipc/crc32.hpp"
#include "support.hpp"

using namespace yolo_cam;
using target_nav::ipc::CameraChannel;
using target_nav::ipc::Calibration;
using target_nav::ipc::CalibrationChannel;
using target_nav::ipc::DetectionsChannel;

namespace {

ChannelWriter calibration_writer(const std::string& prefix) {
  return {prefix, geometry_of<CalibrationChannel>(), sizeof(Calibration)};
}

Calibration calibration(double focal_px) {
  Calibration value{};
  value.stamp_s = 1.0;
  value.focal_x_px = value.focal_y_px = focal_px;
  std::strcpy(value.class_name, "bowling_pin");
  return value;
}

cv::Mat picture(int rows, int columns, int seed) {
  cv::Mat image(rows, columns, CV_8UC3);
  cv::RNG(static_cast<std::uint64_t>(seed)).fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

bool same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && std::memcmp(a.data, b.data, a.total() * a.elemSize()) == 0;
}

}  // namespace

TEST_CASE("crc32 is zlib's") {
  CHECK(crc32("123456789", 9) == 0xCBF43926U);
  CHECK(crc32("456789", 6, crc32("123", 3)) == 0xCBF43926U);
  CHECK(crc32("", 0) == 0U);
}

TEST_CASE("pixel_sum adds words and fills the last one up with zeros") {
  const unsigned char bytes[10] = {1, 0, 0, 0, 0, 0, 0, 0, 2, 1};
  CHECK(pixel_sum(bytes, 8) == 1);
  CHECK(pixel_sum(bytes, 10) == 1 + 2 + 256);
}

TEST_CASE("a calibration arrives once, and the newest one counts") {
  const support::Prefix prefix;
  CalibrationReader reader(prefix.name);
  CHECK_FALSE(reader.take_new());
  auto writer = calibration_writer(prefix.name);
  CHECK_FALSE(reader.take_new());
  for (const double focal_px : {500.0, 510.0, 520.0}) {
    const auto value = calibration(focal_px);
    writer.write({&value, sizeof value});
  }
  const auto taken = reader.take_new();
  REQUIRE(taken);
  CHECK(taken->focal_x_px == 520.0);
  CHECK(std::string(taken->class_name) == "bowling_pin");
  CHECK_FALSE(reader.take_new());
}

TEST_CASE("a picture arrives byte by byte, of any size that fits") {
  const support::Prefix prefix;
  PictureWriter writer(prefix.name);
  PictureReader reader(prefix.name, geometry_of<CameraChannel>());
  int id = 0;
  for (const cv::Size size : {cv::Size(640, 480), cv::Size(641, 3), cv::Size(1, 1), cv::Size(1920, 1080)}) {
    const cv::Mat image = picture(size.height, size.width, ++id);
    writer.write(0.5 + id, id, image);
    const auto taken = reader.take_new();
    REQUIRE(taken);
    CHECK(taken->stamp_s == 0.5 + id);
    CHECK(taken->frame_id == id);
    CHECK(same(taken->image_bgr, image));
  }
}

TEST_CASE("a part of a larger picture is written as it is seen") {
  const support::Prefix prefix;
  PictureWriter writer(prefix.name);
  PictureReader reader(prefix.name, geometry_of<CameraChannel>());
  const cv::Mat whole = picture(100, 100, 1);
  const cv::Mat part = whole(cv::Rect(10, 20, 30, 40));
  writer.write(1.0, 1, part);
  CHECK(same(reader.take_new()->image_bgr, part.clone()));
}

TEST_CASE("pictures that no reader could take are refused") {
  const support::Prefix prefix;
  PictureWriter writer(prefix.name);
  CHECK_THROWS_AS(writer.write(1.0, 1, cv::Mat(8, 8, CV_8UC1)), DeviceError);
  CHECK_THROWS_AS(writer.write(1.0, 1, cv::Mat()), DeviceError);
  CHECK_THROWS_AS(writer.write(1.0, 1, cv::Mat(1081, 1920, CV_8UC3)), DeviceError);
}

TEST_CASE("half a class name is another class, so it is refused") {
  const support::Prefix prefix;
  DetectionsWriter writer(prefix.name);
  CHECK_THROWS_AS(writer.write(1.0, 1, {}, std::string(48, 'x')), DeviceError);
  CHECK_NOTHROW(writer.write(1.0, 1, {}, std::string(47, 'x')));
}

TEST_CASE("of more boxes than fit the first ones are kept") {
  const support::Prefix prefix;
  DetectionsWriter writer(prefix.name);
  writer.write(1.0, 1, std::vector<Detection>(100, Detection{0.5, 1.0, 1.0, 2.0, 2.0}), "pin");
  ChannelReader reader(prefix.name, geometry_of<DetectionsChannel>(), sizeof(target_nav::ipc::RawDetectionFrame));
  const auto* head = reader.take_new();
  REQUIRE(head != nullptr);
  target_nav::ipc::RawDetectionFrame frame{};
  std::memcpy(&frame, head->data(), head->size());
  CHECK(frame.detections_count == 64);
  CHECK(std::string(frame.detections[63].class_name) == "pin");
}

TEST_CASE("a second writer is refused while the first one lives, and welcome after") {
  const support::Prefix prefix;
  auto first = std::make_unique<DetectionsWriter>(prefix.name);
  // The lock belongs to the open file: a second one in the same process is as foreign as another process's.
  CHECK_THROWS_WITH_AS(DetectionsWriter(prefix.name), doctest::Contains(std::to_string(::getpid()).c_str()), DeviceError);
  first.reset();
  CHECK_NOTHROW(DetectionsWriter(prefix.name));
}

TEST_CASE("a prefix that is no file name is refused") {
  for (const char* bad : {"", "/x", "a/b", "..", "_x", "v2n_sim", "a b"}) {
    CHECK_THROWS_AS(path_of(bad, "camera"), DeviceError);
  }
  CHECK(path_of("v2n", "camera") == "/dev/shm/v2n_camera");
}

TEST_CASE("a file that is no channel is left alone") {
  const support::Prefix prefix;
  const std::string path = path_of(prefix.name, "detections");
  std::ofstream(path) << std::string(4096, 'x');
  CHECK_THROWS_WITH_AS(DetectionsWriter(prefix.name), doctest::Contains("not a channel"), DeviceError);
  CHECK(std::filesystem::file_size(path) == 4096);
}

TEST_CASE("a leftover of another layout is replaced by a writer and not there for a reader") {
  const support::Prefix prefix;
  Geometry other = geometry_of<CalibrationChannel>();
  other.layout_hash ^= 1U;
  auto old = std::make_unique<ChannelWriter>(prefix.name, other, sizeof(Calibration));
  CalibrationReader reader(prefix.name);
  CHECK_THROWS_WITH_AS(reader.take_new(), doctest::Contains("another layout"), DeviceError);
  old.reset();
  CHECK_FALSE(reader.take_new());
  auto writer = calibration_writer(prefix.name);
  const auto value = calibration(500.0);
  writer.write({&value, sizeof value});
  CHECK(reader.take_new());
}

TEST_CASE("a removed file is made again, and readers follow") {
  const support::Prefix prefix;
  auto writer = calibration_writer(prefix.name);
  CalibrationReader reader(prefix.name);
  const auto value = calibration(500.0);
  writer.write({&value, sizeof value});
  REQUIRE(reader.take_new());
  std::filesystem::remove(path_of(prefix.name, "calibration"));
  writer.write({&value, sizeof value});
  CHECK(writer.reclaimed() == 1);
  CHECK(reader.take_new());
}

TEST_CASE("what a writer that died left is not taken for its successor's") {
  const support::Prefix prefix;
  CalibrationReader reader(prefix.name);
  const auto value = calibration(500.0);
  calibration_writer(prefix.name).write({&value, sizeof value});
  auto second = calibration_writer(prefix.name);
  CHECK_FALSE(reader.take_new());
  second.write({&value, sizeof value});
  CHECK(reader.take_new());
  CHECK(second.repaired() == 0);
}

// The writer dies with SIGKILL after each step of a store.
TEST_CASE("a slot that a dead writer left half-written is cleaned and never read") {
  for (int step = 0; step < 4; ++step) {
    CAPTURE(step);
    const support::Prefix prefix;
    CalibrationReader reader(prefix.name);
    const auto good = calibration(500.0);
    const pid_t child = ::fork();
    REQUIRE(child >= 0);
    if (child == 0) {
      const Geometry geometry = geometry_of<CalibrationChannel>();
      auto channel = MappedChannel::claim(path_of(prefix.name, geometry.channel), geometry);
      const auto reign = take_over(channel, sizeof(Calibration), 1000);
      channel.reserve(geometry.slot_bytes);
      std::uint64_t sequence = reign.generation;
      for (; sequence < reign.generation + 5; ++sequence) {
        SlotStore store(channel, sequence);
        store.mark_busy();
        store.copy({&good, sizeof good}, {});
        store.mark_done();
        store.publish();
      }
      const auto bad = calibration(-1.0);
      SlotStore store(channel, sequence);
      store.mark_busy();
      if (step > 0) {
        store.copy({&bad, step == 1 ? sizeof bad / 2 : sizeof bad}, {});
      }
      if (step > 2) {
        store.mark_done();
      }
      ::kill(::getpid(), SIGKILL);
    }
    int status = 0;
    REQUIRE(::waitpid(child, &status, 0) == child);
    CHECK(WIFSIGNALED(status));
    // The last word of the dead one is still there, whole.
    const auto last = reader.take_new();
    REQUIRE(last);
    CHECK(last->focal_x_px == 500.0);
    auto successor = calibration_writer(prefix.name);
    CHECK(successor.repaired() == (step < 3 ? 1 : 0));
    CHECK_FALSE(reader.take_new());
    const auto fresh = calibration(600.0);
    for (int i = 0; i < 6; ++i) {
      successor.write({&fresh, sizeof fresh});
      const auto taken = reader.take_new();
      REQUIRE(taken);
      CHECK(taken->focal_x_px == 600.0);
    }
  }
}

TEST_CASE("a reader beside a writer that never rests accepts nothing torn and nothing twice") {
  const support::Prefix prefix;
  PictureWriter writer(prefix.name);
  std::atomic<bool> done{false};
  std::thread flat_out([&] {
    cv::Mat image(48, 64, CV_8UC3);
    for (int id = 1; id <= 20000; ++id) {
      image.setTo(cv::Scalar::all(id % 251));
      writer.write(id, id, image);
    }
    done = true;
  });
  PictureReader reader(prefix.name, geometry_of<CameraChannel>());
  std::int64_t last = 0;
  int accepted = 0;
  bool whole = true;
  bool newer = true;
  while (!done) {
    if (const auto taken = reader.take_new()) {
      newer = newer && taken->frame_id > last;
      last = taken->frame_id;
      const cv::Mat expected(48, 64, CV_8UC3, cv::Scalar::all(static_cast<double>(last % 251)));
      whole = whole && same(taken->image_bgr, expected);
      ++accepted;
    }
  }
  flat_out.join();
  CHECK(whole);
  CHECK(newer);
  CHECK(accepted > 0);
}

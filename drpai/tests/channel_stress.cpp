// Writes a channel flat out, for a reader in another process to check: channel_stress KIND PREFIX SECONDS [die]
//
// KIND is `detections` or `camera`. Everything in a value follows from its number, so that a reader can tell any
// mixture of two. With `die` the program kills itself in the middle of a slot at the end.
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include <unistd.h>

#include "common/clock.hpp"
#include "ipc/channel_writer.hpp"

namespace {

using namespace yolo_cam;
using target_nav::ipc::DetectionsChannel;
using target_nav::ipc::RawDetection;
using target_nav::ipc::RawDetectionFrame;

constexpr int WIDTH = 640;
constexpr int HEIGHT = 480;

std::vector<Detection> boxes_of(std::int64_t number) {
  const auto count = static_cast<std::size_t>(number % 65);
  const auto value = static_cast<double>(number);
  return std::vector<Detection>(count, Detection{value, value, value, value, value});
}

// Leaves a slot as a writer does that is killed while it copies.
[[noreturn]] void die_inside(const std::string& prefix, std::int64_t number) {
  const Geometry geometry = geometry_of<DetectionsChannel>();
  auto channel = MappedChannel::claim(path_of(prefix, geometry.channel), geometry);
  const auto reign = take_over(channel, sizeof(RawDetectionFrame), static_cast<std::uint64_t>(monotonic_ns()));
  channel.reserve(geometry.slot_bytes);
  std::vector<std::byte> half(geometry.payload_bytes / 2, std::byte{0x5A});
  std::uint64_t sequence = reign.generation;
  SlotStore store(channel, sequence + static_cast<std::uint64_t>(number % 4));
  store.mark_busy();
  store.copy({half.data(), half.size()}, {});
  ::raise(SIGKILL);
  std::abort();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) {
    return 2;
  }
  const std::string kind = argv[1];
  const std::string prefix = argv[2];
  const double end_s = monotonic_s() + std::atof(argv[3]);
  const bool die = argc > 4 && std::strcmp(argv[4], "die") == 0;
  std::int64_t number = 0;
  if (kind == "camera") {
    PictureWriter writer(prefix);
    cv::Mat image(HEIGHT, WIDTH, CV_8UC3);
    while (monotonic_s() < end_s) {
      ++number;
      std::memset(image.data, static_cast<int>(number % 251), image.total() * image.elemSize());
      writer.write(monotonic_s(), number, image);
    }
  } else {
    DetectionsWriter writer(prefix);
    while (monotonic_s() < end_s) {
      ++number;
      writer.write(monotonic_s(), number, boxes_of(number), "bowling_pin");
    }
  }
  std::printf("%lld\n", static_cast<long long>(number));
  std::fflush(stdout);
  if (die) {
    die_inside(prefix, number);
  }
  return 0;
}

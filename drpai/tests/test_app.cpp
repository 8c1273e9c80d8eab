// Options, times, the watchdog, and the loop from a picture to what readers get.
#include <cmath>
#include <cstring>
#include <future>

#include <doctest/doctest.h>
#include <opencv2/imgproc.hpp>

#include "app/detector_loop.hpp"
#include "app/options.hpp"
#include "app/watchdog.hpp"
#include "common/error.hpp"
#include "common/latency.hpp"
#include "detect/opencv_backend.hpp"
#include "support.hpp"

using namespace yolo_cam;
using target_nav::ipc::Calibration;
using target_nav::ipc::RawDetectionFrame;

namespace {

Options parsed(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "app_yolo_cam");
  return parse_options(static_cast<int>(arguments.size()), arguments.data());
}

// Gives what a test puts into it.
class ListSource final : public FrameSource {
 public:
  std::optional<Picture> poll() override {
    if (pictures.empty()) {
      return std::nullopt;
    }
    Picture picture = pictures.front();
    pictures.erase(pictures.begin());
    return picture;
  }
  std::vector<Picture> pictures;
};

cv::Mat with_square() {
  cv::Mat image(480, 640, CV_8UC3, cv::Scalar::all(90));
  cv::rectangle(image, cv::Rect(304, 208, 48, 48), {30, 30, 220}, -1);
  return image;
}

struct Bench {
  Bench() : options(parsed({"--model", "x", "--prefix", prefix.name.c_str()})) {}
  std::optional<RawDetectionFrame> frame() {
    const auto* head = reader.take_new();
    if (head == nullptr) {
      return std::nullopt;
    }
    RawDetectionFrame value{};
    std::memcpy(&value, head->data(), head->size());
    return value;
  }
  void calibrate(double score_min, double k1 = 0.0, const char* class_name = "bowling_pin") {
    Calibration value{1.0, 554.0, 554.0, 320.0, 240.0, {k1, 0, 0, 0, 0}, score_min, {}};
    std::strcpy(value.class_name, class_name);
    calibrations.write({&value, sizeof value});
  }
  support::Prefix prefix;
  Options options;
  ListSource source;
  OpencvBackend backend{support::model_path()};
  Watchdog watchdog{60.0, [](const std::string&) {}};
  ChannelReader reader{prefix.name, geometry_of<target_nav::ipc::DetectionsChannel>(), sizeof(RawDetectionFrame)};
  PictureReader pictures{prefix.name, geometry_of<target_nav::ipc::CameraChannel>()};
  ChannelWriter calibrations{prefix.name, geometry_of<target_nav::ipc::CalibrationChannel>(), sizeof(Calibration)};
};

}  // namespace

TEST_CASE("options: defaults, values, and what is wrong with them") {
  const Options options = parsed({"--model", "m.onnx", "--rate", "15.5", "--width", "320", "--loop", "--source", "2"});
  CHECK(options.model == "m.onnx");
  CHECK(options.source.rate_hz == 15.5);
  CHECK(options.source.width_px == 320);
  CHECK(options.source.height_px == 480);
  CHECK(options.source.loop);
  CHECK(options.source.source == "2");
  CHECK(parsed({"--help"}).help);
  CHECK_THROWS_WITH_AS(parsed({}), doctest::Contains("--model"), DeviceError);
  CHECK_THROWS_WITH_AS(parsed({"--modle", "x"}), doctest::Contains("--modle"), DeviceError);
  CHECK_THROWS_WITH_AS(parsed({"--model"}), doctest::Contains("needs a value"), DeviceError);
  for (const char* bad : {"", "0", "x", "5x", "nan", "inf", "-1", "1e9"}) {
    CAPTURE(bad);
    CHECK_THROWS_AS(parsed({"--model", "m", "--rate", bad}), DeviceError);
  }
  CHECK_THROWS_AS(parsed({"--model", "m", "--width", "640.5"}), DeviceError);
  CHECK_THROWS_AS(parsed({"--model", "m", "--score", "1.1"}), DeviceError);
}

TEST_CASE("every option of the usage is understood") {
  const std::string usage = USAGE;
  for (const char* name : {"--model", "--backend", "--source", "--prefix", "--width", "--height", "--rate", "--class", "--score",
                           "--overlap", "--drpai-frequency", "--report", "--watchdog"}) {
    CHECK(usage.find(name) != std::string::npos);
    CHECK_THROWS_WITH_AS(parsed({name}), doctest::Contains("needs a value"), DeviceError);
  }
}

TEST_CASE("quantiles are ordered and taken from the sample") {
  std::vector<double> sample;
  for (int i = 100; i >= 0; --i) {
    sample.push_back(i);
  }
  const Quantiles q = quantiles_of(sample);
  CHECK(q.p50_s == 50.0);
  CHECK(q.p99_s == 99.0);
  CHECK(q.max_s == 100.0);
  CHECK(quantiles_of({3.0}).p50_s == 3.0);
}

TEST_CASE("times are told once a window and forgotten then") {
  StageTimes times(10.0, 100.0);
  times.add(Stage::Infer, 0.008);
  times.add(Stage::Total, 0.020);
  CHECK_FALSE(times.take(109.9));
  const auto line = times.take(110.0);
  REQUIRE(line);
  CHECK(line->find("0.1 pictures/s") == 0);
  CHECK(line->find("infer 8.0/8.0/8.0") != std::string::npos);
  CHECK(line->find("decode") == std::string::npos);
  CHECK(times.take(121.0)->find("no pictures in 11 s") == 0);
}

TEST_CASE("the watchdog bites a loop that stands still and says where, and no other") {
  std::promise<std::string> bitten;
  Watchdog watchdog(0.2, [&](const std::string& where) { bitten.set_value(where); });
  auto answer = bitten.get_future();
  // Not armed before the first beat: loading a network may take long.
  CHECK(answer.wait_for(std::chrono::milliseconds(500)) == std::future_status::timeout);
  watchdog.beat("running the network");
  REQUIRE(answer.wait_for(std::chrono::seconds(20)) == std::future_status::ready);
  CHECK(answer.get() == "running the network");
}

TEST_CASE("a picture becomes boxes and a picture with its own stamp and number") {
  Bench bench;
  DetectorLoop loop(bench.options, bench.source, bench.backend, bench.watchdog);
  CHECK_FALSE(loop.step());
  bench.source.pictures.push_back({12.5, 7, with_square()});
  CHECK(loop.step());
  const auto frame = bench.frame();
  REQUIRE(frame);
  CHECK(frame->stamp_s == 12.5);
  CHECK(frame->frame_id == 7);
  REQUIRE(frame->detections_count >= 1);
  CHECK(std::string(frame->detections[0].class_name) == "bowling_pin");
  CHECK(std::abs(frame->detections[0].u_px - 328.0) <= 16.0);
  const auto shown = bench.pictures.take_new();
  REQUIRE(shown);
  CHECK(shown->stamp_s == 12.5);
  CHECK(cv::norm(shown->image_bgr, with_square(), cv::NORM_INF) == 0.0);
}

TEST_CASE("a calibration is followed while running: score and lens") {
  Bench bench;
  DetectorLoop loop(bench.options, bench.source, bench.backend, bench.watchdog);
  for (int i = 0; i < 4; ++i) {
    bench.source.pictures.push_back({1.0 + i, i, with_square()});
  }
  bench.calibrate(1.0);
  loop.step();
  CHECK(bench.frame()->detections_count == 0);
  bench.calibrate(0.3, -0.3);
  loop.step();
  CHECK(bench.frame()->detections_count > 0);
  CHECK(cv::norm(bench.pictures.take_new()->image_bgr, with_square(), cv::NORM_INF) > 0.0);
  bench.calibrate(0.3, 0.0);
  loop.step();
  CHECK(cv::norm(bench.pictures.take_new()->image_bgr, with_square(), cv::NORM_INF) == 0.0);
  bench.calibrate(std::nan(""), 0.1);
  loop.step();
  CHECK(cv::norm(bench.pictures.take_new()->image_bgr, with_square(), cv::NORM_INF) == 0.0);
}

TEST_CASE("pictures of another size are refused, for ranges would be wrong") {
  Bench bench;
  DetectorLoop loop(bench.options, bench.source, bench.backend, bench.watchdog);
  bench.source.pictures.push_back({1.0, 1, cv::Mat(240, 320, CV_8UC3)});
  CHECK_THROWS_WITH_AS(loop.step(), doctest::Contains("pictures are 320x240, the configuration has 640x480"), DeviceError);
  CHECK_FALSE(bench.frame());
}

TEST_CASE("a second detector of the same prefix is refused") {
  Bench bench;
  DetectorLoop loop(bench.options, bench.source, bench.backend, bench.watchdog);
  CHECK_THROWS_AS(DetectorLoop(bench.options, bench.source, bench.backend, bench.watchdog), DeviceError);
}

// What happens to a picture before the network sees it: straightened, scaled, put into bars.
#include <doctest/doctest.h>
#include <opencv2/imgproc.hpp>

#include "detect/inference_backend.hpp"
#include "detect/letterbox.hpp"
#include "detect/undistort.hpp"

using namespace yolo_cam;

namespace {

constexpr std::size_t PLANE = static_cast<std::size_t>(INPUT_HEIGHT) * INPUT_WIDTH;

cv::Mat noise(int rows, int columns) {
  cv::Mat image(rows, columns, CV_8UC3);
  cv::RNG(3).fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

}  // namespace

TEST_CASE("640x480 becomes 320x240 with 8 rows of grey above and below") {
  const Placement placement = placement_of(640, 480);
  CHECK(placement.scale == 0.5);
  CHECK(placement.left == 0);
  CHECK(placement.top == 8);
  CHECK(placement.width == 320);
  CHECK(placement.height == 240);
}

TEST_CASE("the input is RGB from 0 to 1, each value the mean of four pixels") {
  const cv::Mat image = noise(480, 640);
  Letterbox letterbox;
  const float* input = letterbox.prepare(image);
  for (const cv::Point at : {cv::Point(0, 0), cv::Point(319, 239), cv::Point(100, 50)}) {
    for (int channel = 0; channel < 3; ++channel) {
      int sum = 0;
      for (int i = 0; i < 4; ++i) {
        sum += image.at<cv::Vec3b>(2 * at.y + i / 2, 2 * at.x + i % 2)[2 - channel];
      }
      const float value = input[static_cast<std::size_t>(channel) * PLANE + (at.y + 8) * INPUT_WIDTH + at.x];
      CHECK(value == doctest::Approx(sum / 4.0 / 255.0).epsilon(0.01));
    }
  }
}

TEST_CASE("the bars are grey and stay so when the shape of the pictures changes") {
  Letterbox letterbox;
  letterbox.prepare(noise(480, 640));
  letterbox.prepare(noise(640, 480));
  const float* input = letterbox.prepare(noise(480, 640));
  const float grey = 114.0F / 255.0F;
  for (std::size_t channel = 0; channel < 3; ++channel) {
    CHECK(input[channel * PLANE] == grey);
    CHECK(input[channel * PLANE + 7 * INPUT_WIDTH + 319] == grey);
    CHECK(input[channel * PLANE + 248 * INPUT_WIDTH] == grey);
    CHECK(input[channel * PLANE + 255 * INPUT_WIDTH + 319] == grey);
  }
  const Placement upright = placement_of(480, 640);
  CHECK(upright.height == 256);
  CHECK(upright.width == 192);
  CHECK(upright.left == 64);
}

TEST_CASE("without distortion a picture stays the very same") {
  const cv::Mat image = noise(48, 64);
  Undistorter undistorter;
  CHECK(undistorter.apply(image, std::nullopt).data == image.data);
  const Lens pinhole{50.0, 50.0, 32.0, 24.0, {}};
  CHECK(undistorter.apply(image, pinhole).data == image.data);
  const Lens broken{0.0, 50.0, 32.0, 24.0, {0.1, 0, 0, 0, 0}};
  CHECK(undistorter.apply(image, broken).data == image.data);
}

TEST_CASE("straightening undoes what a lens does to points") {
  // White dots at pixels' middles; where the lens puts them is computed here, from the model's definition.
  const Lens lens{554.0, 550.0, 320.0, 240.0, {-0.25, 0.08, 0.001, -0.002, -0.01}};
  const auto [k1, k2, p1, p2, k3] = lens.distortion;
  Undistorter undistorter;
  for (const cv::Point at : {cv::Point(100, 80), cv::Point(320, 240), cv::Point(560, 400), cv::Point(40, 240)}) {
    const double x = (at.x + 0.5 - 320.0) / 554.0;
    const double y = (at.y + 0.5 - 240.0) / 550.0;
    const double r2 = x * x + y * y;
    const double radial = 1 + k1 * r2 + k2 * r2 * r2 + k3 * r2 * r2 * r2;
    const double u = 554.0 * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + 320.0;
    const double v = 550.0 * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + 240.0;
    cv::Mat image(480, 640, CV_8UC3, cv::Scalar::all(0));
    cv::circle(image, {static_cast<int>(std::lround((u - 0.5) * 16)), static_cast<int>(std::lround((v - 0.5) * 16))}, 4 * 16,
               cv::Scalar::all(255), -1, cv::LINE_AA, 4);
    cv::Mat grey;
    cv::cvtColor(undistorter.apply(image, lens), grey, cv::COLOR_BGR2GRAY);
    const cv::Moments moments = cv::moments(grey);
    CHECK(moments.m10 / moments.m00 == doctest::Approx(at.x).epsilon(0.003));
    CHECK(moments.m01 / moments.m00 == doctest::Approx(at.y).epsilon(0.003));
  }
}

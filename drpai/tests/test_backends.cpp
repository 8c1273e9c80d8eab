// Both backends give the same thing to the same decoder; what is no network of ours is told in words.
#include <cmath>
#include <fstream>
#include <iterator>

#include <doctest/doctest.h>
#include <opencv2/imgproc.hpp>

#include "common/error.hpp"
#include "detect/decoder.hpp"
#include "detect/drpai_backend.hpp"
#include "detect/half_float.hpp"
#include "detect/make_backend.hpp"
#include "detect/opencv_backend.hpp"
#include "support.hpp"

using namespace yolo_cam;

namespace {

constexpr std::uint64_t AREA = 0x240000000ULL;

cv::Mat with_square(cv::Rect square) {
  cv::Mat image(480, 640, CV_8UC3, cv::Scalar::all(90));
  cv::rectangle(image, square, {30, 30, 220}, -1);
  return image;
}

std::string file_with(const support::Folder& folder, const std::string& content) {
  const std::string path = (folder.path / "model.onnx").string();
  std::ofstream(path, std::ios::binary) << content;
  return path;
}

std::string whole_model() {
  std::ifstream file(support::model_path(), std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// The fake runtime plays a network with half-precision heads, coarsest first.
std::vector<std::vector<float>> fake_heads(float logit) {
  std::vector<std::vector<float>> heads;
  for (const int stride : {32, 8, 16}) {
    const std::size_t plane = static_cast<std::size_t>(INPUT_HEIGHT / stride) * (INPUT_WIDTH / stride);
    std::vector<float> values(HEAD_PLANES * plane, 1.5F);
    std::fill(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(plane), -9.0F);
    if (stride == 8) {
      values[15 * 40 + 20] = logit;
    }
    heads.push_back(values);
  }
  return heads;
}

}  // namespace

TEST_CASE("OpenCV runs the network: a red square is found where it is") {
  OpencvBackend backend(support::model_path());
  Letterbox letterbox;
  const cv::Mat image = with_square({300, 200, 32, 32});
  const auto& heads = backend.run(letterbox.prepare(image));
  REQUIRE(heads.size() == 3);
  CHECK(heads[0].stride == 8);
  CHECK(heads[2].rows == 8);
  const auto boxes = decode(heads, letterbox.placement(), 640, 480, {});
  REQUIRE(boxes.size() >= 1);
  CHECK(std::abs(boxes[0].u_px - 316.0) <= 16.0);
  CHECK(std::abs(boxes[0].v_px - 216.0) <= 16.0);
  const auto& nothing = backend.run(letterbox.prepare(with_square({0, 0, 0, 0})));
  CHECK(decode(nothing, letterbox.placement(), 640, 480, {}).empty());
}

TEST_CASE("a model that is not there, empty, cut off or something else is told, not crashed on") {
  const support::Folder folder;
  CHECK_THROWS_WITH_AS(OpencvBackend("/nowhere/m.onnx"), doctest::Contains("is not there"), DeviceError);
  CHECK_THROWS_AS(OpencvBackend(file_with(folder, "")), DeviceError);
  CHECK_THROWS_AS(OpencvBackend(file_with(folder, "this is no network")), DeviceError);
  const std::string whole = whole_model();
  for (const double share : {0.1, 0.5, 0.9, 0.99}) {
    CAPTURE(share);
    const auto size = static_cast<std::size_t>(share * static_cast<double>(whole.size()));
    CHECK_THROWS_AS(OpencvBackend(file_with(folder, whole.substr(0, size))), DeviceError);
  }
}

TEST_CASE("weights that are no numbers are found at the start") {
  const support::Folder folder;
  std::string model = whole_model();
  const float gain = 40.0F;
  const std::string weight(reinterpret_cast<const char*>(&gain), sizeof gain);
  const std::size_t at = model.find(weight);
  REQUIRE(at != std::string::npos);
  model.replace(at, 4, std::string("\x00\x00\xC0\x7F", 4));
  CHECK_THROWS_WITH_AS(OpencvBackend(file_with(folder, model)), doctest::Contains("nonsense"), DeviceError);
}

TEST_CASE("a network that is no detector is refused by name") {
  const support::Folder folder;
  std::ifstream file(std::string(TEST_DATA) + "/four_planes.onnx", std::ios::binary);
  REQUIRE(file.good());
  const std::string content{std::istreambuf_iterator<char>(file), {}};
  CHECK_THROWS_WITH_AS(OpencvBackend(file_with(folder, content)), doctest::Contains("no head"), DeviceError);
}

TEST_CASE("the backend is chosen by name") {
  CHECK(make_backend("cpu", support::model_path(), 2)->description().find("OpenCV") == 0);
  CHECK_THROWS_WITH_AS(make_backend("gpu", support::model_path(), 2), doctest::Contains("cpu or drpai"), DeviceError);
}

TEST_CASE("half precision: zeros, subnormals, one, the largest, infinity, NaN") {
  CHECK(float_of_half(0x0000) == 0.0F);
  CHECK(std::signbit(float_of_half(0x8000)));
  CHECK(float_of_half(0x0001) == doctest::Approx(5.960464477539063e-8));
  CHECK(float_of_half(0x03FF) == doctest::Approx(6.097555160522461e-5));
  CHECK(float_of_half(0x0400) == doctest::Approx(6.103515625e-5));
  CHECK(float_of_half(0x3C00) == 1.0F);
  CHECK(float_of_half(0xC000) == -2.0F);
  CHECK(float_of_half(0x3555) == doctest::Approx(0.333252));
  CHECK(float_of_half(0x7BFF) == 65504.0F);
  CHECK(std::isinf(float_of_half(0x7C00)));
  CHECK(std::isnan(float_of_half(0x7E00)));
}

TEST_CASE("the accelerator's heads, in half or single precision and any order, come out as OpenCV's do") {
  const support::Folder folder;
  for (const auto type : {InOutDataType::FLOAT16, InOutDataType::FLOAT32}) {
    fake_mera::reset();
    fake_mera::heads = fake_heads(4.0F);
    fake_mera::output_type = type;
    DrpaiBackend backend(folder.path.string(), 2, AREA);
    const std::vector<float> input(INPUT_VALUES, 0.25F);
    const auto& heads = backend.run(input.data());
    REQUIRE(heads.size() == 3);
    CHECK(heads[0].stride == 8);
    CHECK(heads[1].stride == 16);
    CHECK(heads[2].stride == 32);
    CHECK(fake_mera::last_input == 0.25F);
    CHECK(fake_mera::frequency_index == 2);
    CHECK(fake_mera::address == AREA);
    const auto boxes = decode(heads, placement_of(640, 480), 640, 480, {});
    REQUIRE(boxes.size() == 1);
    CHECK(boxes[0].u_px == doctest::Approx(2 * 164.0));
    CHECK(boxes[0].width_px == doctest::Approx(2 * 2 * 12.0));
  }
}

TEST_CASE("an accelerator that is not there or fails is told") {
  const support::Folder folder;
  const std::string model = folder.path.string();
  fake_mera::reset();
  fake_mera::heads = fake_heads(4.0F);
  CHECK_THROWS_WITH_AS(drpai_area_address("/dev/no_drpai"), doctest::Contains("/dev/no_drpai"), DeviceError);
  CHECK_THROWS_WITH_AS(drpai_area_address("/dev/null"), doctest::Contains("does not tell its memory"), DeviceError);
  CHECK_THROWS_WITH_AS(DrpaiBackend(model + "/none", 2, AREA), doctest::Contains("is not there"), DeviceError);
  fake_mera::loads = false;
  CHECK_THROWS_WITH_AS(DrpaiBackend(model, 2, AREA), doctest::Contains("cannot be loaded"), DeviceError);
  fake_mera::loads = true;
  fake_mera::output_type = InOutDataType::OTHER;
  CHECK_THROWS_AS(DrpaiBackend(model, 2, AREA), DeviceError);
  fake_mera::output_type = InOutDataType::FLOAT32;
  fake_mera::heads = {std::vector<float>(84 * 8400, 0.0F)};
  CHECK_THROWS_WITH_AS(DrpaiBackend(model, 2, AREA), doctest::Contains("is it the network"), DeviceError);
}

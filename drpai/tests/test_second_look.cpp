// The second look: what is looked at again, where, and what becomes of it. tests/unit/detectors/test_second_look.py says
// the same of Python's.
#include <array>
#include <cmath>
#include <functional>

#include <doctest/doctest.h>
#include <opencv2/imgproc.hpp>

#include "detect/letterbox.hpp"
#include "detect/opencv_backend.hpp"
#include "detect/second_look.hpp"
#include "support.hpp"

using namespace yolo_cam;

namespace {

constexpr int WIDTH = 640;
constexpr int HEIGHT = 480;

struct Seen {
  std::vector<Part> parts;
  std::vector<std::vector<Detection>> answers;

  std::vector<Detection> operator()(const Part& part) {
    parts.push_back(part);
    return parts.size() <= answers.size() ? answers[parts.size() - 1] : std::vector<Detection>{};
  }
};

std::vector<Detection> after(Seen& seen, const std::vector<Detection>& glanced, double score_min = 0.5) {
  DecoderLimits limits;
  limits.score_min = score_min;
  return look_again(glanced, std::ref(seen), WIDTH, HEIGHT, limits);
}

}  // namespace

TEST_CASE("a large box needs no second look") {
  Seen seen;
  const auto boxes = after(seen, {{0.9, 300, 200, 40, 96}, {0.3, 500, 200, 96, 40}});
  CHECK(seen.parts.empty());
  REQUIRE(boxes.size() == 1);
  CHECK(boxes[0].height_px == 96);
}

TEST_CASE("what the look sees takes the glance's place, also below its threshold") {
  Seen seen;
  seen.answers = {{{0.8, 301, 201, 15, 50}}};
  const auto boxes = after(seen, {{0.2, 300, 200, 20, 48}});
  REQUIRE(seen.parts.size() == 1);
  CHECK(seen.parts[0].left == 250);
  CHECK(seen.parts[0].top == 160);
  CHECK(seen.parts[0].width == 100);
  CHECK(seen.parts[0].height == 80);
  REQUIRE(boxes.size() == 1);
  CHECK(boxes[0].score == doctest::Approx(std::cbrt(0.2 * 0.8 * 0.8)));
  CHECK(boxes[0].v_px == 201);
  CHECK(boxes[0].height_px == 50 - 2 * EDGE_BIAS_PX);
}

TEST_CASE("what the look does not see is no object, and what it sees elsewhere is none either") {
  Seen seen;
  seen.answers = {{{0.9, 260, 180, 15, 40}}};
  CHECK(after(seen, {{0.7, 300, 200, 20, 48}}).empty());
}

TEST_CASE("the part stays in the picture") {
  for (const auto& [u, v, left, top] : {std::array<double, 4>{5, 5, 0, 0}, {635, 475, 480, 352}, {80, 64, 0, 0}, {81, 65, 1, 1}}) {
    const Part part = part_around({0.5, u, v, 10, 80}, WIDTH, HEIGHT);
    CHECK(part.left == left);
    CHECK(part.top == top);
  }
}

TEST_CASE("a part is the smallest that leaves room round the box") {
  for (const auto& [height, width] : {std::array<double, 2>{40, 80}, {41, 100}, {50, 100}, {51, 120}, {60, 120}, {61, 160}, {95, 160}}) {
    CHECK(part_around({0.5, 300, 200, 10, height}, WIDTH, HEIGHT).width == width);
  }
  CHECK(part_around({0.5, 300, 200, 51, 20}, WIDTH, HEIGHT).width == 100);
}

TEST_CASE("both the glance and the look must see something") {
  Seen seen;
  seen.answers = {{{0.6, 300, 200, 20, 48}}};
  CHECK(after(seen, {{0.2, 300, 200, 20, 48}}).empty());
}

TEST_CASE("one look settles all that it holds; the third group keeps the glance's word") {
  Seen seen;
  const auto boxes = after(seen, {{0.9, 100, 100, 15, 40}, {0.8, 120, 100, 15, 40}, {0.7, 400, 100, 15, 40}, {0.6, 100, 400, 15, 40},
                                  {0.4, 600, 400, 15, 40}});
  CHECK(seen.parts.size() == 2);
  REQUIRE(boxes.size() == 1);
  CHECK(boxes[0].score == 0.6);
}

TEST_CASE("a box that the part's border may cut is left out, one at the picture's border is not") {
  Seen seen;
  seen.answers = {{{0.9, 252, 200, 20, 48}}, {{0.9, 8, 450, 16, 60}}};
  const auto boxes = after(seen, {{0.9, 300, 200, 20, 48}, {0.8, 8, 450, 16, 60}});
  REQUIRE(boxes.size() == 1);
  CHECK(boxes[0].u_px == 8);
  // Its foot is at the picture's border and stays there.
  CHECK(boxes[0].v_px + 0.5 * boxes[0].height_px == 480);
}

TEST_CASE("a small picture, or a score too low, is not looked at again") {
  Seen seen;
  CHECK(look_again({{0.9, 50, 50, 15, 40}}, std::ref(seen), 159, 480, {}).size() == 1);
  CHECK(after(seen, {{0.1, 50, 50, 15, 40}}).empty());
  CHECK(seen.parts.empty());
}

TEST_CASE("parts of a picture go through the network of their size, and through that of the whole") {
  cv::Mat image(HEIGHT, WIDTH, CV_8UC3, cv::Scalar::all(90));
  cv::rectangle(image, cv::Rect(400, 200, 24, 24), {30, 30, 220}, -1);
  OpencvBackend small(support::model_path(), LOOK_INPUT);
  OpencvBackend whole(support::model_path());
  for (InferenceBackend* backend : {static_cast<InferenceBackend*>(&small), static_cast<InferenceBackend*>(&whole)}) {
    PartLooker looker(*backend);
    const auto boxes = looker.look(image, {340, 140, 160, 128}, {});
    REQUIRE(boxes.size() >= 1);
    CHECK(std::abs(boxes[0].u_px - 412.0) <= 8.0);
    CHECK(std::abs(boxes[0].v_px - 212.0) <= 8.0);
    CHECK(looker.look(image, {0, 0, 80, 64}, {}).empty());
  }
}

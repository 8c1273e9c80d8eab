// Heads to boxes, held against laws and against a decoder written down naively.
#include <cmath>
#include <limits>
#include <random>

#include <doctest/doctest.h>

#include "common/error.hpp"
#include "detect/decoder.hpp"

using namespace yolo_cam;

namespace {

constexpr int WIDTH = 640;
constexpr int HEIGHT = 480;

// One head with every logit far below any threshold.
struct Head {
  explicit Head(int stride_) : stride(stride_), rows(INPUT_HEIGHT / stride_), columns(INPUT_WIDTH / stride_), values(HEAD_PLANES * rows * columns, -50.0F) {}
  void put(int row, int column, float logit, float left, float top, float right, float bottom) {
    const float all[HEAD_PLANES] = {logit, left, top, right, bottom};
    for (int plane = 0; plane < HEAD_PLANES; ++plane) {
      values[(plane * rows + row) * columns + column] = all[plane];
    }
  }
  HeadTensor tensor() const { return {stride, rows, columns, values.data()}; }
  int stride;
  int rows;
  int columns;
  std::vector<float> values;
};

std::vector<Detection> decoded(const std::vector<HeadTensor>& heads, const DecoderLimits& limits = {}) {
  return decode(heads, placement_of(WIDTH, HEIGHT), WIDTH, HEIGHT, limits);
}

}  // namespace

TEST_CASE("a cell's box lies where its distances say, in the full picture") {
  Head head(8);
  head.put(15, 20, 2.0F, 1.0F, 3.0F, 2.0F, 4.0F);
  const auto boxes = decoded({head.tensor()});
  REQUIRE(boxes.size() == 1);
  // Centre (164, 124) of the input, 8 rows of bar above the picture, which is scaled by one half.
  CHECK(boxes[0].u_px - boxes[0].width_px / 2 == doctest::Approx((164.0 - 8.0) * 2));
  CHECK(boxes[0].u_px + boxes[0].width_px / 2 == doctest::Approx((164.0 + 16.0) * 2));
  CHECK(boxes[0].v_px - boxes[0].height_px / 2 == doctest::Approx((124.0 - 8.0 - 24.0) * 2));
  CHECK(boxes[0].v_px + boxes[0].height_px / 2 == doctest::Approx((124.0 - 8.0 + 32.0) * 2));
  CHECK(boxes[0].score == doctest::Approx(1.0 / (1.0 + std::exp(-2.0))));
}

TEST_CASE("boxes end at the picture's borders") {
  Head head(32);
  head.put(0, 0, 5.0F, 9.0F, 9.0F, 30.0F, 30.0F);
  const auto boxes = decoded({head.tensor()});
  REQUIRE(boxes.size() == 1);
  CHECK(boxes[0].u_px == doctest::Approx(WIDTH / 2));
  CHECK(boxes[0].width_px == doctest::Approx(WIDTH));
  CHECK(boxes[0].height_px == doctest::Approx(HEIGHT));
}

TEST_CASE("a box wholly in the bars, or without extent, is none") {
  Head head(8);
  head.put(0, 5, 5.0F, 1.0F, 0.4F, 1.0F, 0.2F);
  head.put(10, 10, 5.0F, 0.0F, 0.0F, 0.0F, 0.0F);
  CHECK(decoded({head.tensor()}).empty());
}

TEST_CASE("the score's limit belongs to what passes") {
  Head head(16);
  head.put(5, 5, 0.0F, 1.0F, 1.0F, 1.0F, 1.0F);
  DecoderLimits limits;
  limits.score_min = 0.5;
  CHECK(decoded({head.tensor()}, limits).size() == 1);
  limits.score_min = 0.5001;
  CHECK(decoded({head.tensor()}, limits).empty());
  limits.score_min = 1.0;
  CHECK(decoded({head.tensor()}, limits).empty());
}

TEST_CASE("numbers that are none are left out") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  Head head(8);
  head.put(1, 1, nan, 1, 1, 1, 1);
  head.put(2, 2, inf, 1, 1, 1, 1);
  head.put(12, 12, 3, nan, 1, 1, 1);
  head.put(14, 14, 3, 1, inf, 1, 1);
  head.put(20, 20, 3, 1, 1, 1, 1);
  DecoderLimits limits;
  limits.score_min = 0.0;
  limits.candidates_max = 5;
  const auto boxes = decoded({head.tensor()}, limits);
  REQUIRE(!boxes.empty());
  for (const auto& box : boxes) {
    CHECK(std::isfinite(box.score + box.u_px + box.v_px + box.width_px + box.height_px));
  }
}

TEST_CASE("of two heads that see one object one box stays, of two objects both") {
  Head fine(8);
  Head coarse(16);
  fine.put(15, 20, 2.0F, 2, 4, 2, 4);
  coarse.put(7, 10, 3.0F, 1, 2, 1, 2);
  coarse.put(7, 2, 1.0F, 1, 2, 1, 2);
  const auto boxes = decoded({fine.tensor(), coarse.tensor()});
  REQUIRE(boxes.size() == 2);
  CHECK(boxes[0].score == doctest::Approx(1.0 / (1.0 + std::exp(-3.0))));
  CHECK(boxes[1].score == doctest::Approx(1.0 / (1.0 + std::exp(-1.0))));
}

TEST_CASE("overlap is symmetric, one of a box with itself, zero of boxes apart") {
  const Detection a{1, 10, 10, 10, 10};
  const Detection b{1, 15, 10, 10, 10};
  CHECK(overlap(a, a) == doctest::Approx(1.0));
  CHECK(overlap(a, b) == doctest::Approx(1.0 / 3.0));
  CHECK(overlap(a, b) == overlap(b, a));
  CHECK(overlap(a, {1, 21, 10, 10, 10}) == 0.0);
  CHECK(overlap({1, 0, 0, 0, 0}, {1, 0, 0, 0, 0}) == 0.0);
}

TEST_CASE("laws of random heads: in the picture, ordered, apart, as a naive decoder says") {
  std::mt19937 random(7);
  std::normal_distribution<float> logit(-4.0F, 3.0F);
  std::uniform_real_distribution<float> distance(0.0F, 4.0F);
  for (int round = 0; round < 20; ++round) {
    std::vector<Head> heads{Head(8), Head(16), Head(32)};
    std::vector<HeadTensor> tensors;
    for (auto& head : heads) {
      const std::size_t plane = head.values.size() / HEAD_PLANES;
      for (std::size_t i = 0; i < head.values.size(); ++i) {
        head.values[i] = i < plane ? logit(random) : distance(random);
      }
      tensors.push_back(head.tensor());
    }
    DecoderLimits limits;
    limits.candidates_max = 10000;
    limits.detections_max = 10000;
    const auto boxes = decoded(tensors, limits);
    std::size_t naive = 0;
    for (const auto& head : heads) {
      for (std::size_t i = 0; i < head.values.size() / HEAD_PLANES; ++i) {
        naive += 1.0 / (1.0 + std::exp(-static_cast<double>(head.values[i]))) >= limits.score_min;
      }
    }
    CHECK(boxes.size() <= naive);
    CHECK(boxes.size() > 10);
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      const auto& box = boxes[i];
      CHECK(box.score >= limits.score_min - 1e-9);
      CHECK(box.u_px - box.width_px / 2 >= -1e-9);
      CHECK(box.u_px + box.width_px / 2 <= WIDTH + 1e-9);
      CHECK(box.v_px - box.height_px / 2 >= -1e-9);
      CHECK(box.v_px + box.height_px / 2 <= HEIGHT + 1e-9);
      if (i > 0) {
        CHECK(box.score <= boxes[i - 1].score);
      }
      for (std::size_t k = 0; k < i; ++k) {
        CHECK(overlap(box, boxes[k]) <= limits.overlap_max);
      }
    }
    // Suppressing again takes nothing more away.
    CHECK(suppress(boxes, limits.overlap_max, 10000).size() == boxes.size());
  }
}

TEST_CASE("the limits on candidates and boxes hold") {
  Head head(8);
  for (int row = 0; row < head.rows; ++row) {
    for (int column = 0; column < head.columns; ++column) {
      head.put(row, column, 3.0F, 0.4F, 0.4F, 0.4F, 0.4F);
    }
  }
  CHECK(decoded({head.tensor()}).size() == 64);
  DecoderLimits limits;
  limits.candidates_max = 40;
  // The first row of cells lies in the bar.
  const auto boxes = decoded({head.tensor()}, limits);
  CHECK(boxes.size() <= 40);
}

TEST_CASE("a head's stride is read off its size") {
  CHECK(stride_of_values(5 * 32 * 40, "m") == 8);
  CHECK(stride_of_values(5 * 16 * 20, "m") == 16);
  CHECK(stride_of_values(5 * 8 * 10, "m") == 32);
  CHECK_THROWS_WITH_AS(stride_of_values(84 * 8400, "m.onnx"), doctest::Contains("m.onnx"), DeviceError);
}

// Kinematics: signs, the one the other's inverse, limits.
#include <cstdlib>

#include "check.h"
#include "mecanum.h"
#include "serial_cmd.h"

using namespace firmware;

static const Mecanum mecanum(REFERENCE);

// Of one report by itself.
static BodySpeed bodySpeed(const Mecanum& base, const Ticks& counts, Micros elapsed_us) {
  BodyRest rest;
  return base.bodySpeed(counts, elapsed_us, rest);
}

static bool signs(const Speeds& s, int fl, int fr, int rl, int rr) {
  const int wanted[WHEELS] = {fl, fr, rl, rr};
  for (uint8_t i = 0; i < WHEELS; ++i) {
    if ((s[i] > 0) - (s[i] < 0) != wanted[i]) return false;
  }
  return true;
}

TEST(wheels_turn_as_mecanum_wheels_have_to) {
  CHECK(signs(mecanum.wheelSpeeds({200, 0, 0}), 1, 1, 1, 1));
  CHECK(signs(mecanum.wheelSpeeds({0, 200, 0}), -1, 1, 1, -1));
  CHECK(signs(mecanum.wheelSpeeds({0, 0, 500}), -1, 1, -1, 1));
  CHECK(signs(mecanum.wheelSpeeds({100, 100, 0}), 0, 1, 1, 0));
}

TEST(speeds_are_micrometres_a_second) {
  const Speeds s = mecanum.wheelSpeeds({200, 0, 300});
  CHECK_EQ(s[FL], 200000 - 67200);  // 0.224 m * 0.3 rad/s
  CHECK_EQ(s[FR], 200000 + 67200);
}

TEST(a_differential_base_does_not_strafe) {
  Params params = REFERENCE;
  params.strafes = 0;
  const Speeds s = Mecanum(params).wheelSpeeds({100, 200, 0});
  for (uint8_t i = 0; i < WHEELS; ++i) CHECK_EQ(s[i], 100000);
  CHECK_EQ(bodySpeed(Mecanum(params), {{-100, 100, 100, -100}}, 50000).vy_mmps, 0);
}

TEST(wheels_that_cannot_keep_up_are_slowed_alike) {
  const Speeds s = mecanum.wheelSpeeds({600, 300, 0});
  CHECK_EQ(s[FR], REFERENCE.top_speed_umps);
  CHECK_EQ(s[FL], REFERENCE.top_speed_umps / 3);
}

TEST(nothing_in_the_protocols_range_overflows) {
  Params big = REFERENCE;
  big.lever_um = 10000000;
  big.top_speed_umps = 50000000;
  for (const Params& params : {REFERENCE, big}) {
    for (const int32_t vx : {-MAX_LINEAR_MMPS, 0, MAX_LINEAR_MMPS}) {
      for (const int32_t vy : {-MAX_LINEAR_MMPS, 0, MAX_LINEAR_MMPS}) {
        for (const int32_t wz : {-MAX_ANGULAR_MRADPS, 0, MAX_ANGULAR_MRADPS}) {
          const Speeds s = Mecanum(params).wheelSpeeds({vx, vy, wz});
          for (uint8_t i = 0; i < WHEELS; ++i) CHECK(std::abs(s[i]) <= params.top_speed_umps);
        }
      }
    }
  }
}

TEST(forward_kinematics_is_the_inverse_of_the_inverse) {
  for (int32_t vx = -300; vx <= 300; vx += 75) {
    for (int32_t vy = -200; vy <= 200; vy += 50) {
      for (int32_t wz = -400; wz <= 400; wz += 100) {
        const Speeds s = mecanum.wheelSpeeds({vx, vy, wz});
        Ticks counts;  // of ten seconds
        for (uint8_t i = 0; i < WHEELS; ++i) counts[i] = static_cast<int32_t>(scaled(s[i], 10000, REFERENCE.tick_nm));
        const BodySpeed body = bodySpeed(mecanum, counts, 10000000);
        const bool reachable = std::abs(vx) + std::abs(vy) + std::abs(wz) * 224 / 1000 <= 600;
        if (!reachable) continue;
        CHECK(std::abs(body.vx_mmps - vx) <= 1);
        CHECK(std::abs(body.vy_mmps - vy) <= 1);
        CHECK(std::abs(body.wz_mradps - wz) <= 1);
      }
    }
  }
}

TEST(absurd_counts_give_the_limit) {
  const BodySpeed body = bodySpeed(mecanum, {{INT32_MAX, INT32_MAX, INT32_MAX, INT32_MAX}}, 1);
  CHECK_EQ(body.vx_mmps, MAX_LINEAR_MMPS);
  const BodySpeed turn = bodySpeed(mecanum, {{INT32_MAX, INT32_MIN, INT32_MAX, INT32_MIN}}, 50000);
  CHECK_EQ(turn.wz_mradps, -MAX_ANGULAR_MRADPS);
}

TEST(reports_add_up_to_the_way) {
  // 150 mm/s and 300 mrad/s: not one of the reports can tell them exactly.
  BodyRest rest;
  Ticks before = {{0, 0, 0, 0}};
  int64_t x_um = 0, y_um = 0, turn_urad = 0;
  constexpr int REPORTS = 2000;
  constexpr Micros elapsed_us = 50000;
  for (int report = 1; report <= REPORTS; ++report) {
    Ticks now, counts;
    const Speeds speeds = mecanum.wheelSpeeds({150, 50, 300});
    for (uint8_t i = 0; i < WHEELS; ++i) {
      now[i] = static_cast<int32_t>(static_cast<int64_t>(speeds[i]) * report * 50 / REFERENCE.tick_nm);
      counts[i] = now[i] - before[i];
    }
    before = now;
    const BodySpeed body = mecanum.bodySpeed(counts, elapsed_us, rest);
    x_um += body.vx_mmps * 50;
    y_um += body.vy_mmps * 50;
    turn_urad += body.wz_mradps * 50;
  }
  // Of 15 m, 5 m and 30 rad: a count, and half of the last digit.
  CHECK(std::llabs(x_um - 15000000) < 400);
  CHECK(std::llabs(y_um - 5000000) < 400);
  CHECK(std::llabs(turn_urad - 30000000) < 1500);
}

TEST(what_stands_says_so_whatever_was_left) {
  for (int32_t first = 1; first < 400; ++first) {
    BodyRest rest;
    mecanum.bodySpeed({{first, 0, 0, 0}}, 50000, rest);
    for (int report = 0; report < 3; ++report) {
      const BodySpeed body = mecanum.bodySpeed({{0, 0, 0, 0}}, 50000, rest);
      CHECK(body.vx_mmps == 0 && body.vy_mmps == 0 && body.wz_mradps == 0);
    }
  }
}

TEST(what_is_beyond_the_limits_is_not_carried_on) {
  BodyRest rest;
  mecanum.bodySpeed({{INT32_MAX, INT32_MAX, INT32_MAX, INT32_MAX}}, 50000, rest);
  const BodySpeed body = mecanum.bodySpeed({{0, 0, 0, 0}}, 50000, rest);
  CHECK_EQ(body.vx_mmps, 0);
  CHECK_EQ(body.wz_mradps, 0);
}

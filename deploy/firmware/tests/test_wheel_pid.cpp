// The control of one wheel, and the four together: what is driven, what is stalled.
#include "check.h"
#include "motion.h"
#include "wheel_pid.h"

using namespace firmware;

constexpr int32_t TOP = 600000;

TEST(feed_forward_alone_when_the_speed_is_right) {
  WheelPid pid(TOP);
  CHECK_EQ(pid.update(300000, 300000, 1), 128);
  CHECK_EQ(pid.update(-300000, -300000, 1), -128);
  CHECK_EQ(pid.update(TOP, TOP, 1), 255);
}

TEST(proportional_and_integral_parts) {
  WheelPid pid(TOP);
  // 300 + 0.5 * 100 + 4 /s * 0.02 s * 100 = 358 mm/s
  CHECK_EQ(pid.update(300000, 200000, 1), 152);
  CHECK_EQ(pid.update(300000, 300000, 1), 131);  // what the integral holds: 308 mm/s
}

TEST(missed_periods_count_in_the_integral) {
  WheelPid once(TOP), thrice(TOP);
  once.update(300000, 200000, 3);
  for (int i = 0; i < 3; ++i) thrice.update(300000, 200000, 1);
  CHECK_EQ(once.update(300000, 300000, 1), thrice.update(300000, 300000, 1));
}

TEST(the_integral_does_not_wind_up) {
  WheelPid pid(TOP);
  for (int i = 0; i < 10000; ++i) pid.update(100000, 0, 1);
  // 100 mm/s and at most 30 % of the top speed: 280 mm/s
  CHECK_EQ(pid.update(100000, 100000, 1), 119);
  pid.reset();
  CHECK_EQ(pid.update(100000, 100000, 1), 43);
}

TEST(pwm_never_leaves_its_range) {
  WheelPid pid(TOP);
  CHECK_EQ(pid.update(TOP, -100000000, 255), 255);
  CHECK_EQ(pid.update(-TOP, 100000000, 255), -255);
  WheelPid slow(1000), fast(50000000);
  CHECK_EQ(slow.update(1000, -100000000, 255), 255);
  CHECK_EQ(fast.update(-50000000, 100000000, 255), -255);
}

TEST(a_derivative_brakes_a_rising_speed) {
  WheelPid with(TOP, Gains{500, 0, 500}), without(TOP, Gains{500, 0, 0});
  CHECK_EQ(with.update(300000, 0, 1), without.update(300000, 0, 1));
  CHECK_EQ(without.update(300000, 100000, 1) - with.update(300000, 100000, 1), 21);  // 50 of 600 mm/s
  with.reset();
  without.reset();
  CHECK_EQ(with.update(300000, 0, 1), without.update(300000, 0, 1));
}

TEST(a_wheel_that_does_not_turn_is_found_after_five_seconds) {
  Motion motion(REFERENCE);
  motion.keepSpeeds({{100000, 100000, 100000, 100000}}, 0);
  Ticks ticks = Ticks();
  Micros now_us = 0;
  int8_t stalled = Motion::NO_WHEEL;
  for (int i = 1; i <= 300 && stalled == Motion::NO_WHEEL; ++i) {
    now_us += CONTROL_PERIOD_US;
    for (const uint8_t wheel : {FL, FR, RR}) ticks[wheel] += 10;
    ticks[RL] = i % 3;  // it trembles
    stalled = motion.update(now_us, ticks, 1);
  }
  CHECK_EQ(static_cast<int>(stalled), static_cast<int>(RL));
  CHECK_EQ(now_us, STALL_US);
}

TEST(a_wheel_that_shall_stand_or_hardly_turn_is_never_stalled) {
  Motion motion(REFERENCE);
  motion.keepSpeeds({{0, 19000, -19000, 0}}, 0);
  for (Micros now_us = 0; now_us < 3 * STALL_US; now_us += CONTROL_PERIOD_US) {
    CHECK_EQ(static_cast<int>(motion.update(now_us, Ticks(), 1)), static_cast<int>(Motion::NO_WHEEL));
    for (uint8_t i = 0; i < WHEELS; ++i) CHECK_EQ(motion.pwm()[i], 0);
  }
}

TEST(counters_may_wrap_round_while_driving) {
  Motion motion(REFERENCE);
  motion.keepSpeeds({{100000, -100000, 100000, -100000}}, 0);
  Ticks ticks = {{INT32_MAX - 5, INT32_MIN + 5, 0, 0}};
  motion.update(0, ticks, 1);
  motion.stop();
  motion.keepSpeeds({{95200, -95200, 95200, -95200}}, 0);
  for (Micros now_us = CONTROL_PERIOD_US; now_us < 1000000; now_us += CONTROL_PERIOD_US) {
    for (uint8_t i = 0; i < WHEELS; ++i) {
      ticks[i] = static_cast<int32_t>(static_cast<uint32_t>(ticks[i]) + (i % 2 == 0 ? 10u : ~9u));
    }
    motion.update(now_us, ticks, 1);
    // Ten counts in 20 ms are 95.2 mm/s: feed-forward alone.
    for (uint8_t i = 0; i < WHEELS; ++i) CHECK_EQ(motion.pwm()[i], i % 2 == 0 ? 40 : -40);
  }
}

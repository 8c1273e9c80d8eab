// Kinematics of the base (Lynch and Park, Modern Robotics, 2017, section 13.2): a wheel's rim speed is
// vx -+ vy -+ lever * wz. A differential base is the same without vy.
#pragma once

#include "config.h"
#include "types.h"

namespace firmware {

struct BodySpeed {
  int32_t vx_mmps, vy_mmps, wz_mradps;
};

// What the speeds of one report left out by being whole numbers, in counts times nanometres.
struct BodyRest {
  int64_t x = 0, y = 0, turn = 0;
};

class Mecanum {
 public:
  explicit Mecanum(const Params& params) : params_(params) {}

  // Inverse kinematics. All wheels are slowed by the same factor when one cannot keep up, so that the direction
  // of motion stays.
  Speeds wheelSpeeds(const BodySpeed& body) const;

  // Forward kinematics, least squares over the four wheels, from the counts of `elapsed_us`, which is 1 ms to
  // 10 s; within the protocol's limits. `rest` is carried from one report to the next, so that speeds times
  // their intervals add up to the way: at a steady speed the same rounding each time would be 0.3 % of it.
  BodySpeed bodySpeed(const Ticks& counts, Micros elapsed_us, BodyRest& rest) const;

 private:
  Params params_;
};

}  // namespace firmware

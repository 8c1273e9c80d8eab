// Kinematics of the base (Lynch and Park, Modern Robotics, 2017, section 13.2): a wheel's rim speed is
// vx -+ vy -+ lever * wz. A differential base is the same without vy.
#pragma once

#include "config.h"
#include "types.h"

namespace firmware {

struct BodySpeed {
  int32_t vx_mmps, vy_mmps, wz_mradps;
};

class Mecanum {
 public:
  explicit Mecanum(const Params& params) : params_(params) {}

  // Inverse kinematics. All wheels are slowed by the same factor when one cannot keep up, so that the direction
  // of motion stays.
  Speeds wheelSpeeds(const BodySpeed& body) const;

  // Forward kinematics, least squares over the four wheels, from the counts of `elapsed_us`, which is more than 0 and
  // less than 500 s; within the protocol's limits.
  BodySpeed bodySpeed(const Ticks& counts, Micros elapsed_us) const;

 private:
  Params params_;
};

}  // namespace firmware

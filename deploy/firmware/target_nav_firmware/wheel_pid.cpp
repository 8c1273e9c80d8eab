#include "wheel_pid.h"

namespace firmware {

void WheelPid::reset() {
  integral_umps_ = 0;
  has_before_ = false;
}

int16_t WheelPid::update(int32_t wanted_umps, int32_t measured_umps, uint8_t periods) {
  const int64_t error = static_cast<int64_t>(wanted_umps) - measured_umps;
  const int64_t change = has_before_ ? static_cast<int64_t>(measured_umps) - before_umps_ : 0;
  before_umps_ = measured_umps;
  has_before_ = true;

  const int64_t elapsed_us = static_cast<int64_t>(CONTROL_PERIOD_US) * periods;
  const int64_t limit = scaled(top_umps_, INTEGRAL_LIMIT_PERMILLE, 1000);
  const int64_t gained = scaled(error, gains_.ki_permille_per_s * elapsed_us, 1000000000LL);
  integral_umps_ = static_cast<int32_t>(clamped<int64_t>(integral_umps_ + gained, limit));

  int64_t drive_umps = wanted_umps + scaled(error, gains_.kp_permille, 1000) + integral_umps_;
  if (gains_.kd_permille != 0) drive_umps -= scaled(change, gains_.kd_permille, 1000);
  return static_cast<int16_t>(scaled(clamped<int64_t>(drive_umps, top_umps_), MAX_PWM, top_umps_));
}

}  // namespace firmware

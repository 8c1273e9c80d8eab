#include "wheel_pid.h"

namespace firmware {

WheelPid::WheelPid(int32_t top_speed_umps, const Gains& gains)
    : top_umps_(top_speed_umps),
      limit_umps_(within(scaled(top_speed_umps, INTEGRAL_LIMIT_PERMILLE, 1000), top_speed_umps)),
      gains_(gains) {}

void WheelPid::reset() {
  integral_umps_ = 0;
  has_before_ = false;
}

int16_t WheelPid::update(int32_t wanted_umps, int32_t measured_umps, uint8_t periods) {
  const int32_t error_umps = wanted_umps - measured_umps;
  const int32_t change_umps = has_before_ ? measured_umps - before_umps_ : 0;
  before_umps_ = measured_umps;
  has_before_ = true;

  const int64_t gained = scaled(error_umps, static_cast<int32_t>(gains_.ki_permille) * periods, 1000);
  integral_umps_ = within(integral_umps_ + gained, limit_umps_);

  int64_t drive_umps = wanted_umps + scaled(error_umps, gains_.kp_permille, 1000) + integral_umps_;
  if (gains_.kd_permille != 0) drive_umps -= scaled(change_umps, gains_.kd_permille, 1000);
  return static_cast<int16_t>(scaled(within(drive_umps, top_umps_), MAX_PWM, top_umps_));
}

}  // namespace firmware

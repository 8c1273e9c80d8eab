// One wheel's speed control: feed-forward and PID on the encoder's speed.
#pragma once

#include "types.h"

namespace firmware {

struct Gains {
  int16_t kp_permille;  // of the speed error
  int16_t ki_permille;  // of the speed error, added up every control period
  int16_t kd_permille;  // of the change of the measured speed from one update to the next
};

// P of 0.5 and I of 4 /s. With feed-forward and a motor lag of 80 ms: poles at -3 and -15 /s. No D: one count in 20 ms
// is 9.5 mm/s, and a derivative of such steps is noise.
constexpr Gains DEFAULT_GAINS = {500, 80, 0};

// Of the top speed; keeps a blocked wheel from winding up.
constexpr int32_t INTEGRAL_LIMIT_PERMILLE = 300;

class WheelPid {
 public:
  explicit WheelPid(int32_t top_speed_umps = 1, const Gains& gains = DEFAULT_GAINS);

  void reset();
  // The PWM from now on, after so many control periods; `wanted` is within the top speed, `measured` within 100 m/s.
  int16_t update(int32_t wanted_umps, int32_t measured_umps, uint8_t periods);

 private:
  int32_t top_umps_;
  int32_t limit_umps_;
  Gains gains_;
  int32_t integral_umps_ = 0;
  int32_t before_umps_ = 0;
  bool has_before_ = false;
};

}  // namespace firmware

// Four motors behind H-bridges with two inputs each: PWM on one of them, the other low; both low is off.
#pragma once

#include "config.h"
#include "pca9685.h"
#include "types.h"

namespace firmware {

class Motors {
 public:
  static constexpr Micros RETRY_US = 250000;
  static constexpr Micros CHECK_US = 1000000;

  explicit Motors(Pca9685& chip) : chip_(chip), written_() {}

  // Brings the motors to this PWM, all four at once; talks to the chip when something changed, once a second to
  // see that it is still there, and every quarter of a second to find it again. False while it does not answer:
  // then nothing is known of the motors, and OE has to hold them.
  bool setAll(const Pwm& pwm, Micros now_us);

  // 0 ... 255 to 0 ... 4095.
  static uint16_t duty(uint16_t pwm);

 private:
  bool find(Micros now_us);
  bool write(const Pwm& pwm);

  Pca9685& chip_;
  bool ready_ = false;
  bool tried_ = false;
  Micros tried_us_ = 0;
  Micros checked_us_ = 0;
  Pwm written_;
};

}  // namespace firmware

// The four wheels together: speeds held by PID, or PWM as it is; either way a wheel that should turn and does not
// is found.
#pragma once

#include "config.h"
#include "types.h"
#include "wheel_pid.h"

namespace firmware {

constexpr Micros STALL_US = 5000000;
constexpr uint32_t STALL_TICKS = 3;  // fewer counts are a wheel that trembles

class Motion {
 public:
  static constexpr int8_t NO_WHEEL = -1;

  explicit Motion(const Params& params);

  void stop();
  // Keep these rim speeds, within the top speed. Integrals and stall clocks go on if speeds were kept already.
  void keepSpeeds(const Speeds& speeds, Micros now_us);
  // Give the motors this PWM, uncontrolled.
  void givePwm(const Pwm& pwm, Micros now_us);

  // The control step, once for so many control periods (one, unless some were missed) with the counts at their
  // end. Returns the wheel that is stalled, or NO_WHEEL.
  int8_t update(Micros now_us, const Ticks& ticks, uint8_t periods);

  const Pwm& pwm() const { return pwm_; }

 private:
  enum class Kind : uint8_t { OFF, SPEED, PWM };

  void begin(Kind kind, Micros now_us);
  bool isDriven(uint8_t wheel) const;
  bool isStalled(uint8_t wheel, Micros now_us);

  Params params_;
  Kind kind_ = Kind::OFF;
  Speeds wanted_;
  Pwm pwm_;
  WheelPid pid_[WHEELS];
  Ticks ticks_;
  Ticks progress_ticks_;
  PerWheel<Micros> progress_us_;
};

}  // namespace firmware

#include "motor.h"

namespace firmware {
namespace {

bool same(const Pwm& a, const Pwm& b) {
  for (uint8_t i = 0; i < WHEELS; ++i) {
    if (a[i] != b[i]) return false;
  }
  return true;
}

}  // namespace

bool Motors::setAll(const Pwm& pwm, Micros now_us) {
  if (!ready_ && !find(now_us)) return false;
  if (now_us - checked_us_ >= CHECK_US) {
    checked_us_ = now_us;
    ready_ = chip_.isAwake();
  }
  if (ready_ && !same(pwm, written_)) ready_ = write(pwm);
  return ready_;
}

bool Motors::find(Micros now_us) {
  if (tried_ && now_us - tried_us_ < RETRY_US) return false;
  tried_ = true;
  tried_us_ = now_us;
  ready_ = chip_.begin();
  checked_us_ = now_us;
  written_ = Pwm();
  return ready_;
}

bool Motors::write(const Pwm& pwm) {
  uint16_t duties[Pca9685::CHANNELS] = {0};
  for (uint8_t i = 0; i < WHEELS; ++i) {
    const bool forward = (pwm[i] > 0) != wiring::REVERSED[i];
    const uint8_t channel = forward ? wiring::FORWARD_CHANNEL[i] : wiring::BACKWARD_CHANNEL[i];
    duties[channel] = duty(static_cast<uint16_t>(magnitude(pwm[i])));
  }
  if (!chip_.write(duties)) return false;
  written_ = pwm;
  return true;
}

uint16_t Motors::duty(uint16_t pwm) {
  return static_cast<uint16_t>(scaled(pwm < MAX_PWM ? pwm : MAX_PWM, Pca9685::FULL, MAX_PWM));
}

}  // namespace firmware

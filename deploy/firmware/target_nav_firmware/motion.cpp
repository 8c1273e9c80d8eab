#include "motion.h"

namespace firmware {
namespace {

// No wheel goes this fast: counts beyond are a fault.
constexpr int32_t MOST_UMPS = 100000000;

}  // namespace

Motion::Motion(const Params& params)
    : params_(params), wanted_(), pwm_(), ticks_(), progress_ticks_(), progress_us_() {
  for (uint8_t i = 0; i < WHEELS; ++i) pid_[i] = WheelPid(params.top_speed_umps);
}

void Motion::stop() {
  kind_ = Kind::OFF;
  wanted_ = Speeds();
  pwm_ = Pwm();
}

void Motion::keepSpeeds(const Speeds& speeds, Micros now_us) {
  begin(Kind::SPEED, now_us);
  wanted_ = speeds;
}

void Motion::givePwm(const Pwm& pwm, Micros now_us) {
  stop();
  begin(Kind::PWM, now_us);
  pwm_ = pwm;
}

void Motion::begin(Kind kind, Micros now_us) {
  if (kind_ == kind) return;
  kind_ = kind;
  for (uint8_t i = 0; i < WHEELS; ++i) {
    pid_[i].reset();
    progress_us_[i] = now_us;
  }
  progress_ticks_ = ticks_;
}

int8_t Motion::update(Micros now_us, const Ticks& ticks, uint8_t periods) {
  const Ticks before = ticks_;
  ticks_ = ticks;
  if (kind_ == Kind::OFF) return NO_WHEEL;
  const int32_t elapsed_ms = static_cast<int32_t>(CONTROL_PERIOD_US / 1000) * periods;
  for (uint8_t i = 0; i < WHEELS; ++i) {
    if (!isDriven(i)) {
      // Under its dead-band a motor only hums, and the integral would push it off with a jerk later.
      if (kind_ == Kind::SPEED) pwm_[i] = 0;
      pid_[i].reset();
      progress_us_[i] = now_us;
      continue;
    }
    if (isStalled(i, now_us)) return static_cast<int8_t>(i);
    if (kind_ != Kind::SPEED) continue;
    // nm / ms is um/s.
    const int64_t measured = scaled(difference(ticks[i], before[i]), params_.tick_nm, elapsed_ms);
    pwm_[i] = pid_[i].update(wanted_[i], within(measured, MOST_UMPS), periods);
  }
  return NO_WHEEL;
}

bool Motion::isDriven(uint8_t wheel) const {
  if (kind_ == Kind::SPEED) {
    return wanted_[wheel] != 0 && magnitude(wanted_[wheel]) >= magnitude(params_.deadband_umps);
  }
  return pwm_[wheel] != 0 &&
         static_cast<int64_t>(magnitude(pwm_[wheel])) * params_.top_speed_umps >=
             static_cast<int64_t>(params_.deadband_umps) * MAX_PWM;
}

bool Motion::isStalled(uint8_t wheel, Micros now_us) {
  if (magnitude(difference(ticks_[wheel], progress_ticks_[wheel])) >= STALL_TICKS) {
    progress_ticks_[wheel] = ticks_[wheel];
    progress_us_[wheel] = now_us;
    return false;
  }
  return now_us - progress_us_[wheel] >= STALL_US;
}

}  // namespace firmware

#include "c_api.h"

#include <new>

#include "robot.h"

using firmware::CONTROL_PERIOD_US;
using firmware::Micros;
using firmware::Robot;
using firmware::Ticks;
using firmware::WHEELS;

namespace {

// The simulator's limits are well within; beyond, products of firmware/ could leave 64 bit or PWM be rounded to 0.
bool within(int32_t value, int32_t low, int32_t high) { return low <= value && value <= high; }

bool isSound(const tnf_params& p) {
  return within(p.tick_nm, 1000, 2000000) && within(p.lever_um, 1000, 10000000) &&
         within(p.top_speed_umps, 1000, 50000000) && within(p.deadband_umps, 0, 50000000) &&
         within(p.watchdog_us, 1000, 60000000) && within(p.strafes, 0, 1);
}

constexpr uint64_t MOST_PERIODS = 255;

}  // namespace

// The board of the simulator: in place of the timer, control steps when they are due.
struct tnf {
  tnf(const firmware::Params& params, uint64_t now_us)
      : robot(params, static_cast<Micros>(now_us)), next_control_us(now_us + CONTROL_PERIOD_US) {}

  int32_t tell(int16_t* pwm) {
    for (uint8_t i = 0; i < WHEELS; ++i) pwm[i] = robot.pwm()[i];
    return robot.output().used();
  }

  Robot robot;
  uint64_t next_control_us;
};

extern "C" {

int32_t tnf_abi(void) { return TNF_ABI; }

void tnf_reference(tnf_params* params) {
  const firmware::Params& r = firmware::REFERENCE;
  *params = tnf_params{r.tick_nm, r.lever_um, r.top_speed_umps, r.deadband_umps, r.watchdog_us, r.strafes};
}

const char* tnf_version(void) { return firmware::FIRMWARE_VERSION; }

tnf* tnf_create(const tnf_params* params, uint64_t now_us) {
  if (!isSound(*params)) return nullptr;
  const firmware::Params own = {params->tick_nm,       params->lever_um,    params->top_speed_umps,
                                params->deadband_umps, params->watchdog_us, params->strafes};
  return new (std::nothrow) tnf(own, now_us);
}

void tnf_destroy(tnf* firmware) { delete firmware; }

int32_t tnf_feed(tnf* firmware, const uint8_t* bytes, size_t count, uint64_t now_us, int16_t* pwm) {
  for (size_t i = 0; i < count; ++i) firmware->robot.receive(bytes[i], static_cast<Micros>(now_us));
  return firmware->tell(pwm);
}

int32_t tnf_step(tnf* firmware, uint64_t now_us, const int32_t* ticks, int16_t* pwm) {
  Ticks counts;
  for (uint8_t i = 0; i < WHEELS; ++i) counts[i] = ticks[i];
  if (now_us >= firmware->next_control_us) {
    const uint64_t periods = 1 + (now_us - firmware->next_control_us) / CONTROL_PERIOD_US;
    firmware->next_control_us += periods * CONTROL_PERIOD_US;
    const uint64_t told = periods < MOST_PERIODS ? periods : MOST_PERIODS;
    firmware->robot.control(static_cast<Micros>(now_us), counts, static_cast<uint8_t>(told));
  }
  firmware->robot.poll(static_cast<Micros>(now_us), counts);
  return firmware->tell(pwm);
}

int32_t tnf_take(tnf* firmware, uint8_t* bytes, int32_t capacity) {
  int32_t count = 0;
  while (count < capacity && !firmware->robot.output().empty()) bytes[count++] = firmware->robot.output().pop();
  return count;
}

int32_t tnf_mode(const tnf* firmware) { return static_cast<int32_t>(firmware->robot.mode()); }

void tnf_set_driver(tnf* firmware, int32_t answers) { firmware->robot.setDriver(answers != 0); }

}  // extern "C"

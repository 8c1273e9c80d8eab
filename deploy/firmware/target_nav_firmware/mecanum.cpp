#include "mecanum.h"

#include "serial_cmd.h"

namespace firmware {
namespace {

// More counts than any wheel makes in a telemetry period; their sum stays in 32 bit, products with it in 64.
constexpr int32_t MOST_COUNTS = 1L << 24;

// A way in whole units of `unit`, and what that leaves of it to the next report. What stands says so, whatever is left:
// half a unit would be told to and fro for ever.
int32_t speed(int64_t way, int64_t unit, int32_t limit, int64_t& rest) {
  if (way == 0) return 0;
  const int64_t exact = rounded(way + rest, unit);
  const int32_t told = within(exact, limit);
  // What is beyond the protocol's limits is lost.
  rest = told == exact ? way + rest - told * unit : 0;
  return told;
}

}  // namespace

Speeds Mecanum::wheelSpeeds(const BodySpeed& body) const {
  const int32_t vx = body.vx_mmps * 1000;
  const int32_t vy = params_.strafes ? body.vy_mmps * 1000 : 0;
  const int32_t turn = within(scaled(params_.lever_um, body.wz_mradps, 1000), INT32_MAX);
  Speeds wheels = {{vx - vy - turn, vx + vy + turn, vx + vy - turn, vx - vy + turn}};
  uint32_t fastest = 0;
  for (uint8_t i = 0; i < WHEELS; ++i) {
    if (magnitude(wheels[i]) > fastest) fastest = magnitude(wheels[i]);
  }
  if (fastest > static_cast<uint32_t>(params_.top_speed_umps)) {
    for (uint8_t i = 0; i < WHEELS; ++i) {
      const int64_t slowed = scaled(wheels[i], params_.top_speed_umps, static_cast<int32_t>(fastest));
      wheels[i] = within(slowed, params_.top_speed_umps);
    }
  }
  return wheels;
}

BodySpeed Mecanum::bodySpeed(const Ticks& counts, Micros elapsed_us, BodyRest& rest) const {
  int32_t c[WHEELS];
  for (uint8_t i = 0; i < WHEELS; ++i) c[i] = clamped<int32_t>(counts[i], MOST_COUNTS);
  // nm / us is mm/s; the mean of four wheels.
  const int64_t divisor = 4 * static_cast<int64_t>(elapsed_us);
  const int64_t tick_nm = params_.tick_nm;
  const int32_t x = c[FL] + c[FR] + c[RL] + c[RR];
  const int32_t y = params_.strafes ? -c[FL] + c[FR] + c[RL] - c[RR] : 0;
  const int32_t turn = -c[FL] + c[FR] - c[RL] + c[RR];
  return BodySpeed{speed(x * tick_nm, divisor, MAX_LINEAR_MMPS, rest.x),
                   speed(y * tick_nm, divisor, MAX_LINEAR_MMPS, rest.y),
                   // um * mrad is nm: one mrad/s of a lever in um.
                   speed(turn * tick_nm, rounded(divisor * params_.lever_um, 1000000), MAX_ANGULAR_MRADPS, rest.turn)};
}

}  // namespace firmware

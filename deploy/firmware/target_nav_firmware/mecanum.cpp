#include "mecanum.h"

#include "serial_cmd.h"

namespace firmware {
namespace {

// More counts than any wheel makes in a telemetry period; keeps the products below in 64 bit.
constexpr int32_t MOST_COUNTS = 1L << 24;

int32_t limited(int64_t value, int32_t limit) {
  return static_cast<int32_t>(clamped<int64_t>(value, limit));
}

}  // namespace

Speeds Mecanum::wheelSpeeds(const BodySpeed& body) const {
  const int32_t vx = body.vx_mmps * 1000;
  const int32_t vy = params_.strafes ? body.vy_mmps * 1000 : 0;
  const int32_t turn = static_cast<int32_t>(scaled(params_.lever_um, body.wz_mradps, 1000));
  Speeds wheels = {{vx - vy - turn, vx + vy + turn, vx + vy - turn, vx - vy + turn}};
  uint32_t fastest = 0;
  for (uint8_t i = 0; i < WHEELS; ++i) {
    if (magnitude(wheels[i]) > fastest) fastest = magnitude(wheels[i]);
  }
  if (fastest > static_cast<uint32_t>(params_.top_speed_umps)) {
    for (uint8_t i = 0; i < WHEELS; ++i) {
      wheels[i] = static_cast<int32_t>(scaled(wheels[i], params_.top_speed_umps, fastest));
    }
  }
  return wheels;
}

BodySpeed Mecanum::bodySpeed(const Ticks& counts, Micros elapsed_us) const {
  int32_t c[WHEELS];
  for (uint8_t i = 0; i < WHEELS; ++i) c[i] = clamped<int32_t>(counts[i], MOST_COUNTS);
  // nm / us is mm/s.
  const int64_t divisor = 4LL * static_cast<int64_t>(elapsed_us);
  const int64_t vx = scaled(c[FL] + c[FR] + c[RL] + c[RR], params_.tick_nm, divisor);
  const int64_t vy = params_.strafes ? scaled(-c[FL] + c[FR] + c[RL] - c[RR], params_.tick_nm, divisor) : 0;
  const int64_t turn_umps = scaled(-c[FL] + c[FR] - c[RL] + c[RR], params_.tick_nm * 1000LL, divisor);
  const int64_t wz = scaled(turn_umps, 1000, params_.lever_um);
  return BodySpeed{limited(vx, MAX_LINEAR_MMPS), limited(vy, MAX_LINEAR_MMPS), limited(wz, MAX_ANGULAR_MRADPS)};
}

}  // namespace firmware

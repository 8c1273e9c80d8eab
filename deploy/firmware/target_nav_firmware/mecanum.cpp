#include "mecanum.h"

#include "serial_cmd.h"

namespace firmware {
namespace {

// More counts than any wheel makes in a telemetry period; their sum stays in 32 bit, products with it in 64.
constexpr int32_t MOST_COUNTS = 1L << 24;

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

BodySpeed Mecanum::bodySpeed(const Ticks& counts, Micros elapsed_us) const {
  int32_t c[WHEELS];
  for (uint8_t i = 0; i < WHEELS; ++i) c[i] = clamped<int32_t>(counts[i], MOST_COUNTS);
  // nm / us is mm/s.
  const int32_t divisor = 4 * static_cast<int32_t>(elapsed_us);
  const int64_t vx = scaled(c[FL] + c[FR] + c[RL] + c[RR], params_.tick_nm, divisor);
  const int64_t vy = params_.strafes ? scaled(-c[FL] + c[FR] + c[RL] - c[RR], params_.tick_nm, divisor) : 0;
  const int64_t turn_umps = scaled(-c[FL] + c[FR] - c[RL] + c[RR], params_.tick_nm * 1000, divisor);
  const int64_t wz = scaled(within(turn_umps, INT32_MAX), 1000, params_.lever_um);
  return BodySpeed{within(vx, MAX_LINEAR_MMPS), within(vy, MAX_LINEAR_MMPS), within(wz, MAX_ANGULAR_MRADPS)};
}

}  // namespace firmware

// What all parts share: wheels, units and time.
//
// Units are in the names: _um, _nm micro- and nanometres, _umps micrometres a second, _us microseconds. Products
// of two quantities are 64 bit: int has 16 bit on the ATmega2560.
#pragma once

#include <stdint.h>

namespace firmware {

constexpr uint8_t WHEELS = 4;
enum Wheel : uint8_t { FL, FR, RL, RR };
constexpr const char* WHEEL_NAMES[WHEELS] = {"FL", "FR", "RL", "RR"};

template <typename T>
struct PerWheel {
  T of[WHEELS];
  T& operator[](uint8_t wheel) { return of[wheel]; }
  const T& operator[](uint8_t wheel) const { return of[wheel]; }
};

using Ticks = PerWheel<int32_t>;   // encoder counts, they wrap round
using Speeds = PerWheel<int32_t>;  // rim speeds, um/s
using Pwm = PerWheel<int16_t>;     // -255 ... 255

constexpr int16_t MAX_PWM = 255;

// Wraps round after 71 minutes: only differences mean something.
using Micros = uint32_t;

constexpr Micros CONTROL_PERIOD_US = 20000;
constexpr Micros TELEMETRY_PERIOD_US = 50000;

// How far a wrapping counter has come, the short way round.
inline int32_t difference(int32_t later, int32_t earlier) {
  return static_cast<int32_t>(static_cast<uint32_t>(later) - static_cast<uint32_t>(earlier));
}

inline uint32_t magnitude(int32_t value) {
  return value < 0 ? 0u - static_cast<uint32_t>(value) : static_cast<uint32_t>(value);
}

inline bool isDue(Micros now_us, Micros due_us) { return static_cast<int32_t>(now_us - due_us) >= 0; }

template <typename T>
inline T clamped(T value, T limit) {
  return value > limit ? limit : (value < -limit ? -limit : value);
}

// A 64-bit value limited to what 32 bit hold, and to the limit.
inline int32_t within(int64_t value, int32_t limit) { return static_cast<int32_t>(clamped<int64_t>(value, limit)); }

// value / divisor, rounded to the nearest; the divisor is positive.
inline int64_t rounded(int64_t value, int64_t divisor) {
  const int64_t half = divisor / 2;
  return (value + (value < 0 ? -half : half)) / divisor;
}

// value * numerator / denominator, rounded to the nearest; the denominator is positive.
inline int64_t scaled(int32_t value, int32_t numerator, int32_t denominator) {
  return rounded(static_cast<int64_t>(value) * numerator, denominator);
}

}  // namespace firmware

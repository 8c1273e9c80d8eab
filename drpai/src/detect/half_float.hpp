// IEEE 754 binary16 to float: the accelerator answers in half precision.
#pragma once

#include <cstdint>
#include <cstring>

namespace yolo_cam {

inline float float_of_half(std::uint16_t half) {
  constexpr std::uint32_t EXPONENT_ALL = 0x1FU;
  const std::uint32_t sign = static_cast<std::uint32_t>(half & 0x8000U) << 16U;
  const std::uint32_t exponent = half >> 10U & EXPONENT_ALL;
  std::uint32_t mantissa = half & 0x3FFU;
  std::uint32_t bits = 0;
  if (exponent == EXPONENT_ALL) {
    bits = sign | 0x7F800000U | mantissa << 13U;
  } else if (exponent != 0) {
    bits = sign | (exponent + 112U) << 23U | mantissa << 13U;
  } else if (mantissa != 0) {
    // Subnormal: shift up until the leading one is where a normal number implies it.
    std::uint32_t shifted_exponent = 113U;
    while ((mantissa & 0x400U) == 0) {
      mantissa <<= 1U;
      --shifted_exponent;
    }
    bits = sign | shifted_exponent << 23U | (mantissa & 0x3FFU) << 13U;
  } else {
    bits = sign;
  }
  float value = 0.0F;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

}  // namespace yolo_cam

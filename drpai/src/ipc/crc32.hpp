// CRC-32 as zlib and IEEE 802.3 have it, byte by byte through a table: what it guards here is a few kilobytes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace yolo_cam {

namespace detail {

constexpr std::array<std::uint32_t, 256> crc_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t crc = i;
    for (int bit = 0; bit < 8; ++bit) {
      crc = crc >> 1 ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
    }
    table[i] = crc;
  }
  return table;
}

inline constexpr std::array<std::uint32_t, 256> CRC_TABLE = crc_table();

}  // namespace detail

// `so_far` is the CRC of what came before, 0 at the beginning.
inline std::uint32_t crc32(const void* data, std::size_t size, std::uint32_t so_far = 0) {
  const auto* byte = static_cast<const unsigned char*>(data);
  std::uint32_t crc = ~so_far;
  for (std::size_t i = 0; i < size; ++i) {
    // The analyzer loses track of how large a struct is that is looked at byte by byte.
    crc = crc >> 8 ^ detail::CRC_TABLE[(crc ^ byte[i]) & 0xFFU];  // NOLINT(clang-analyzer-core.UndefinedBinaryOperatorResult)
  }
  return ~crc;
}

}  // namespace yolo_cam

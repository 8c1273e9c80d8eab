// Stands for Renesas' MERA2 runtime where its SDK is not: the shape of the calls that src/detect/drpai_backend.cpp
// makes, written from the public description of the interface, and a runtime that plays what a test puts into it.
#pragma once

#include <cstdint>
#include <string>
#include <tuple>
#include <vector>

enum class InOutDataType { FLOAT32, FLOAT16, OTHER };

namespace fake_mera {

inline std::vector<std::vector<float>> heads;
inline InOutDataType output_type = InOutDataType::FLOAT16;
inline bool loads = true;
inline float last_input = 0.0F;
inline int frequency_index = 0;
inline std::uint64_t address = 0;

inline void reset() {
  heads.clear();
  output_type = InOutDataType::FLOAT16;
  loads = true;
}

// Enough for numbers that half precision holds exactly.
inline std::uint16_t half_of(float value) {
  std::uint32_t bits = 0;
  static_assert(sizeof bits == sizeof value);
  __builtin_memcpy(&bits, &value, sizeof bits);
  if ((bits & 0x7FFFFFFFU) == 0) {
    return static_cast<std::uint16_t>(bits >> 16U);
  }
  const std::uint32_t exponent = (bits >> 23U & 0xFFU) - 112U;
  return static_cast<std::uint16_t>((bits >> 16U & 0x8000U) | exponent << 10U | (bits >> 13U & 0x3FFU));
}

}  // namespace fake_mera

class MeraDrpRuntimeWrapper {
 public:
  bool LoadModel(const std::string&, std::uint64_t start_address) {
    fake_mera::address = start_address;
    return fake_mera::loads;
  }
  template <typename T>
  void SetInput(int, const T* data) {
    fake_mera::last_input = static_cast<float>(data[0]);
  }
  void Run(int frequency_index) { fake_mera::frequency_index = frequency_index; }
  InOutDataType GetInputDataType(int) { return InOutDataType::FLOAT32; }
  int GetNumOutput() { return static_cast<int>(fake_mera::heads.size()); }
  std::tuple<InOutDataType, void*, std::int64_t> GetOutput(int index) {
    auto& values = fake_mera::heads.at(static_cast<std::size_t>(index));
    const auto count = static_cast<std::int64_t>(values.size());
    if (fake_mera::output_type != InOutDataType::FLOAT16) {
      return {fake_mera::output_type, values.data(), count};
    }
    halves_.resize(fake_mera::heads.size());
    auto& halves = halves_[static_cast<std::size_t>(index)];
    halves.clear();
    for (const float value : values) {
      halves.push_back(fake_mera::half_of(value));
    }
    return {InOutDataType::FLOAT16, halves.data(), count};
  }

 private:
  std::vector<std::vector<std::uint16_t>> halves_;
};

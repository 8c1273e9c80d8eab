// Counting a quadrature encoder with one interrupt a wheel, at every change of channel A.
//
// A count is a whole period of the signal, 990 a turn of the wheel, though two edges are seen. With rising edges
// alone a wheel that trembles on one would count up without turning; here it goes to and fro by half a count.
#pragma once

#include "types.h"

namespace firmware {

class Encoder {
 public:
  // Channel A has just changed; the levels of both now. A leads B when the wheel turns forward.
  void edge(bool a, bool b) {
    const bool forward = a != b;
    // The count is the half counts' number, rounded down.
    if (forward == half_) count_ = step(count_, forward);
    half_ = !half_;
  }

  int32_t count() const { return count_; }

 private:
  static int32_t step(int32_t count, bool up) {
    const uint32_t bits = static_cast<uint32_t>(count);
    return static_cast<int32_t>(up ? bits + 1u : bits - 1u);
  }

  int32_t count_ = 0;
  bool half_ = false;
};

}  // namespace firmware

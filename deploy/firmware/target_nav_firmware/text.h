// Lines to send: put together in a fixed buffer, queued whole or not at all.
#pragma once

#include "types.h"

namespace firmware {

constexpr uint8_t MAX_LINE_BYTES = 96;  // of either side, newline left out

// One line. What does not fit is cut off.
class LineBuilder {
 public:
  LineBuilder& add(const char* text);
  LineBuilder& add(int32_t number);
  LineBuilder& addUnsigned(uint32_t number);
  // Bytes from outside: what is not printable becomes a question mark.
  LineBuilder& addForeign(const uint8_t* bytes, uint8_t count);

  const char* text() const { return text_; }
  uint8_t length() const { return length_; }

 private:
  void put(char character);

  char text_[MAX_LINE_BYTES];
  uint8_t length_ = 0;
};

// What waits for the serial port. A line that does not fit is dropped and counted, so nothing ever waits for a
// host that does not read, and what comes out are whole lines.
class TxQueue {
 public:
  static constexpr uint16_t CAPACITY = 256;

  // Appends the line and a newline, if `reserve` bytes stay free after it.
  bool put(const LineBuilder& line, uint16_t reserve = 0);
  uint8_t pop();
  bool empty() const { return used_ == 0; }
  uint16_t used() const { return used_; }
  uint16_t dropped() const { return dropped_; }

 private:
  void push(uint8_t byte);

  uint8_t bytes_[CAPACITY];
  uint16_t first_ = 0;
  uint16_t used_ = 0;
  uint16_t dropped_ = 0;
};

}  // namespace firmware

#include "text.h"

namespace firmware {

void LineBuilder::put(char character) {
  if (length_ < MAX_LINE_BYTES) text_[length_++] = character;
}

LineBuilder& LineBuilder::add(const char* text) {
  while (*text != '\0') put(*text++);
  return *this;
}

LineBuilder& LineBuilder::add(int32_t number) {
  if (number < 0) put('-');
  return addUnsigned(magnitude(number));
}

LineBuilder& LineBuilder::addUnsigned(uint32_t number) {
  char digits[10];
  uint8_t count = 0;
  do {
    digits[count++] = static_cast<char>('0' + number % 10);
    number /= 10;
  } while (number != 0);
  while (count > 0) put(digits[--count]);
  return *this;
}

LineBuilder& LineBuilder::addForeign(const uint8_t* bytes, uint8_t count) {
  for (uint8_t i = 0; i < count; ++i) {
    const uint8_t byte = bytes[i];
    put(byte >= 0x20 && byte <= 0x7E ? static_cast<char>(byte) : '?');
  }
  return *this;
}

bool TxQueue::put(const LineBuilder& line, uint16_t reserve) {
  if (used_ + line.length() + 1u + reserve > CAPACITY) {
    if (dropped_ < UINT16_MAX) ++dropped_;
    return false;
  }
  for (uint8_t i = 0; i < line.length(); ++i) push(static_cast<uint8_t>(line.text()[i]));
  push('\n');
  return true;
}

uint8_t TxQueue::pop() {
  if (used_ == 0) return 0;
  const uint8_t byte = bytes_[first_];
  first_ = static_cast<uint16_t>((first_ + 1u) % CAPACITY);
  --used_;
  return byte;
}

void TxQueue::push(uint8_t byte) {
  bytes_[(first_ + used_) % CAPACITY] = byte;
  ++used_;
}

}  // namespace firmware

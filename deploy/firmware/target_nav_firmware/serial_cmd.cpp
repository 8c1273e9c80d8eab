#include "serial_cmd.h"

#include <string.h>

namespace firmware {
namespace {

constexpr uint8_t MAX_FIELDS = 4;
constexpr uint8_t MAX_DIGITS = 10;

struct Field {
  const uint8_t* begin;
  uint8_t length;

  bool is(const char* word) const { return strlen(word) == length && memcmp(begin, word, length) == 0; }
};

// The fields' number, 0 if there are too many or a byte is not printable.
uint8_t split(const uint8_t* line, uint8_t length, Field (&fields)[MAX_FIELDS]) {
  uint8_t count = 0;
  uint8_t begin = 0;
  for (uint8_t i = 0; i <= length; ++i) {
    if (i < length && (line[i] < 0x20 || line[i] > 0x7E)) return 0;
    if (i < length && line[i] != ',') continue;
    if (count == MAX_FIELDS) return 0;
    fields[count++] = Field{line + begin, static_cast<uint8_t>(i - begin)};
    begin = static_cast<uint8_t>(i + 1);
  }
  return count;
}

// One optional sign and up to ten digits, of a magnitude within the limit.
bool parseInteger(const Field& field, int32_t limit, int32_t& value) {
  uint8_t at = 0;
  const bool negative = field.length > 0 && field.begin[0] == '-';
  if (negative || (field.length > 0 && field.begin[0] == '+')) ++at;
  const uint8_t digits = static_cast<uint8_t>(field.length - at);
  if (digits == 0 || digits > MAX_DIGITS) return false;
  uint32_t total = 0;
  for (; at < field.length; ++at) {
    const uint8_t byte = field.begin[at];
    if (byte < '0' || byte > '9') return false;
    const uint32_t digit = static_cast<uint32_t>(byte - '0');
    if (total > (UINT32_MAX - digit) / 10u) return false;
    total = total * 10u + digit;
  }
  if (total > static_cast<uint32_t>(limit)) return false;
  value = negative ? -static_cast<int32_t>(total) : static_cast<int32_t>(total);
  return true;
}

bool parseVelocity(const Field* fields, Command& command) {
  command.kind = Command::Kind::VEL;
  return parseInteger(fields[0], MAX_LINEAR_MMPS, command.vx_mmps) &&
         parseInteger(fields[1], MAX_LINEAR_MMPS, command.vy_mmps) &&
         parseInteger(fields[2], MAX_ANGULAR_MRADPS, command.wz_mradps);
}

bool parseMove(uint8_t move, const Field* fields, Command& command) {
  command.kind = Command::Kind::MOVE;
  command.move = static_cast<Move>(move);
  return parseInteger(fields[0], MAX_LINEAR_MMPS, command.speed_mmps) &&
         parseInteger(fields[1], MAX_TICKS, command.ticks) && command.speed_mmps >= 0 && command.ticks >= 0;
}

bool parseMotor(const Field* fields, Command& command) {
  command.kind = Command::Kind::TMOTOR;
  int32_t pwm = 0;
  if (!parseInteger(fields[1], MAX_PWM, pwm)) return false;
  command.pwm = static_cast<int16_t>(pwm);
  for (command.wheel = 0; command.wheel < WHEELS; ++command.wheel) {
    if (fields[0].is(WHEEL_NAMES[command.wheel])) return true;
  }
  return false;
}

}  // namespace

bool parseCommand(const uint8_t* line, uint8_t length, Command& command) {
  Field fields[MAX_FIELDS];
  const uint8_t count = length <= MAX_LINE_BYTES ? split(line, length, fields) : 0;
  if (count == 0) return false;
  const Field& word = fields[0];
  if (word.is("VEL")) return count == 4 && parseVelocity(fields + 1, command);
  if (word.is("TMOTOR")) return count == 3 && parseMotor(fields + 1, command);
  for (uint8_t move = 0; move < MOVES; ++move) {
    if (word.is(MOVE_NAMES[move])) return count == 3 && parseMove(move, fields + 1, command);
  }
  if (word.is("STOP")) {
    command.kind = Command::Kind::STOP;
  } else if (word.is("CALIB")) {
    command.kind = Command::Kind::CALIB;
  } else if (word.is("VERSION")) {
    command.kind = Command::Kind::VERSION;
  } else {
    return false;
  }
  return count == 1;
}

LineReader::Event LineReader::take(uint8_t byte) {
  if (ended_) {
    ended_ = false;
    length_ = 0;
  }
  if (byte == '\n') {
    ended_ = true;
    if (discarding_) {
      discarding_ = false;
      return Event::NOTHING;
    }
    while (length_ > 0 && line_[length_ - 1] == '\r') --length_;
    return length_ > 0 ? Event::LINE : Event::NOTHING;
  }
  if (discarding_) return Event::NOTHING;
  if (length_ == sizeof line_) {
    length_ = 0;
    discarding_ = true;
    return Event::OVERLONG;
  }
  line_[length_++] = byte;
  return Event::NOTHING;
}

}  // namespace firmware

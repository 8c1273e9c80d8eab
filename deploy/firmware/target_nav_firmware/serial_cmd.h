// Bytes from the host to commands. The wire format is that of target_nav/hardware/protocol.py: exact forms in
// range, nothing else; a line has no checksum.
#pragma once

#include "text.h"
#include "types.h"

namespace firmware {

constexpr int32_t MAX_LINEAR_MMPS = 5000;
constexpr int32_t MAX_ANGULAR_MRADPS = 20000;
constexpr int32_t MAX_TICKS = INT32_MAX;

enum class Move : uint8_t { FWD, BWD, LEFT, RIGHT, CCW, CW };
constexpr uint8_t MOVES = 6;
constexpr const char* MOVE_NAMES[MOVES] = {"FWD", "BWD", "LEFT", "RIGHT", "CCW", "CW"};

struct Command {
  enum class Kind : uint8_t { VEL, STOP, MOVE, TMOTOR, CALIB, VERSION };

  Kind kind;
  int32_t vx_mmps, vy_mmps, wz_mradps;  // VEL
  Move move;                            // MOVE
  int32_t speed_mmps, ticks;
  uint8_t wheel;  // TMOTOR
  int16_t pwm;
};

// Whether the line (without its end) is a command; `command` is meaningful only then.
bool parseCommand(const uint8_t* line, uint8_t length, Command& command);

// Cuts the byte stream into lines and never holds more than one. A longer one is thrown away up to its end.
class LineReader {
 public:
  enum class Event : uint8_t { NOTHING, LINE, OVERLONG };

  // After LINE, `line` and `length` are valid up to the next call. OVERLONG comes once for each line.
  Event take(uint8_t byte);
  const uint8_t* line() const { return line_; }
  uint8_t length() const { return length_; }

 private:
  // One byte more: a carriage return before the newline belongs to the end of the line.
  uint8_t line_[MAX_LINE_BYTES + 1];
  uint8_t length_ = 0;
  bool ended_ = false;
  bool discarding_ = false;
};

}  // namespace firmware

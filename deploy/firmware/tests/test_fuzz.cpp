// A million bytes of garbage: nothing moves, nothing crashes, and what comes out are whole lines.
#include <string>

#include "check.h"
#include "robot.h"

using namespace firmware;

namespace {

// Marsaglia, Xorshift RNGs, 2003: the same bytes everywhere.
struct Random {
  uint32_t state = 2463534242u;
  uint32_t next() {
    state ^= state << 13;
    state ^= state >> 17;
    state ^= state << 5;
    return state;
  }
  uint32_t below(uint32_t limit) { return next() % limit; }
};

constexpr int BYTES = 1000000;
constexpr int BYTES_PER_STEP = 23;  // of 2 ms at 115200 baud

// Feeds bytes and looks at everything that comes out and at the motors.
struct Victim {
  Robot robot{REFERENCE};
  Micros now_us = 0;
  Ticks ticks = Ticks();
  int fed = 0;
  int moved = 0;
  int bad_lines = 0;
  int lines = 0;
  std::string partial;

  void feed(uint8_t byte) {
    robot.receive(byte, now_us);
    if (++fed % BYTES_PER_STEP == 0) step();
  }

  void step() {
    now_us += 2000;
    if (now_us % CONTROL_PERIOD_US == 0) robot.control(now_us, ticks, 1);
    robot.poll(now_us, ticks);
    for (uint8_t i = 0; i < WHEELS; ++i) {
      if (robot.pwm()[i] != 0) ++moved;
      CHECK(robot.pwm()[i] >= -MAX_PWM && robot.pwm()[i] <= MAX_PWM);
    }
    while (!robot.output().empty()) {
      const char out = static_cast<char>(robot.output().pop());
      if (out == '\n') {
        ++lines;
        const std::string word = partial.substr(0, partial.find(','));
        if (word != "ODOM" && word != "ENC" && word != "ERROR" && word != "ACK" && word != "VERSION") ++bad_lines;
        partial.clear();
      } else {
        if (out < 0x20 || out > 0x7E || partial.size() >= MAX_LINE_BYTES) ++bad_lines;
        partial += out;
      }
    }
  }
};

}  // namespace

TEST(a_million_random_bytes_move_nothing) {
  Random random;
  Victim victim;
  for (int i = 0; i < BYTES; ++i) victim.feed(static_cast<uint8_t>(random.below(256)));
  CHECK_EQ(victim.moved, 0);
  CHECK_EQ(victim.bad_lines, 0);
  CHECK(victim.lines > 1000);
}

TEST(a_million_bytes_of_the_protocols_alphabet_move_nothing) {
  const std::string alphabet = "ABCDEFILMOPRSTUVW,,,-+0123456789\r\n\n";
  Random random;
  Victim victim;
  for (int i = 0; i < BYTES; ++i) {
    victim.feed(static_cast<uint8_t>(alphabet[random.below(static_cast<uint32_t>(alphabet.size()))]));
  }
  CHECK_EQ(victim.moved, 0);
  CHECK_EQ(victim.bad_lines, 0);
}

TEST(a_million_bytes_of_damaged_commands_crash_nothing) {
  const std::string commands[] = {"VEL,200,0,300\n", "FWD,100,1719\n", "TMOTOR,FL,100\n", "STOP\n", "CALIB\r\n",
                                  "VEL,-5000,5000,-20000\n", "CW,5000,2147483647\n", "VERSION\n"};
  Random random;
  Victim victim;
  while (victim.fed < BYTES) {
    std::string line = commands[random.below(8)];
    for (uint32_t damage = random.below(4); damage > 0 && !line.empty(); --damage) {
      const uint32_t at = random.below(static_cast<uint32_t>(line.size()));
      switch (random.below(3)) {
        case 0:
          line[at] = static_cast<char>(static_cast<uint8_t>(line[at]) ^ (1u << random.below(8)));
          break;
        case 1:
          line.erase(at, 1);
          break;
        default:
          line.insert(at, 1, static_cast<char>(random.below(256)));
      }
    }
    for (const char byte : line) victim.feed(static_cast<uint8_t>(byte));
    // Encoders that jump about, as after a fault.
    if (random.below(50) == 0) {
      for (uint8_t i = 0; i < WHEELS; ++i) victim.ticks[i] = static_cast<int32_t>(random.next());
    }
  }
  CHECK(victim.moved > 0);  // some lines stay whole
  CHECK_EQ(victim.bad_lines, 0);
}

// Exact forms in range, nothing else; the stream is cut into lines of bounded length.
#include <string>
#include <vector>

#include "check.h"
#include "serial_cmd.h"

using namespace firmware;

static bool parse(const std::string& line, Command& command) {
  return parseCommand(reinterpret_cast<const uint8_t*>(line.data()), static_cast<uint8_t>(line.size()), command);
}

TEST(a_velocity_has_three_numbers_in_range) {
  Command c;
  CHECK(parse("VEL,200,-30,+300", c));
  CHECK(c.kind == Command::Kind::VEL);
  CHECK_EQ(c.vx_mmps, 200);
  CHECK_EQ(c.vy_mmps, -30);
  CHECK_EQ(c.wz_mradps, 300);
  CHECK(parse("VEL,5000,-5000,20000", c));
  CHECK(parse("VEL,0000000005,0,0", c));
  CHECK_EQ(c.vx_mmps, 5);
}

TEST(position_moves_motors_and_words) {
  Command c;
  for (uint8_t move = 0; move < MOVES; ++move) {
    CHECK(parse(std::string(MOVE_NAMES[move]) + ",100,1719", c));
    CHECK(c.kind == Command::Kind::MOVE && c.move == static_cast<Move>(move));
    CHECK_EQ(c.speed_mmps, 100);
    CHECK_EQ(c.ticks, 1719);
  }
  CHECK(parse("FWD,0,2147483647", c));
  CHECK_EQ(c.ticks, INT32_MAX);
  CHECK(parse("TMOTOR,RL,-255", c));
  CHECK(c.kind == Command::Kind::TMOTOR);
  CHECK_EQ(static_cast<int>(c.wheel), static_cast<int>(RL));
  CHECK_EQ(c.pwm, -255);
  CHECK(parse("STOP", c) && c.kind == Command::Kind::STOP);
  CHECK(parse("CALIB", c) && c.kind == Command::Kind::CALIB);
  CHECK(parse("VERSION", c) && c.kind == Command::Kind::VERSION);
}

TEST(what_is_no_command_is_refused) {
  const std::vector<std::string> bad = {
      "", ",", "VEL", "VEL,1,2", "VEL,1,2,3,4", "VEL,1,2,3,", "VEL,,2,3", "VEL,1.0,2,3", "VEL, 1,2,3", "VEL,1e3,0,0",
      "VEL,nan,0,0", "VEL,0x1,0,0", "VEL,--1,0,0", "VEL,+-1,0,0", "VEL,-,0,0", "VEL,5001,0,0", "VEL,0,-5001,0",
      "VEL,0,0,20001", "VEL,99999999999,0,0", "VEL,9999999999,0,0", "VEL,4294967296,0,0", "VEL,4294967297,0,0",
      "VEL,00000000001,0,0", "vel,1,2,3", "VELO,1,2,3", "STOP,", "STOP,1", "STO", "STOPP", " STOP", "STOP ",
      "FWD,-1,10", "FWD,1,-1", "FWD,100", "FWD,1,2147483648", "FWD,1,2,3", "UP,1,1", "TMOTOR,FL", "TMOTOR,XX,1",
      "TMOTOR,FL,256", "TMOTOR,FL,-256", "TMOTOR,,1", "TMOTOR,F,1", "CALIB,1", "VERSION,1", "ST\x01OP", "STOP\x7f",
      "VEL,200,0,300VEL,200,0,300", std::string(97, 'A'), std::string("STOP\0", 5)};
  for (const std::string& line : bad) {
    Command c;
    if (parse(line, c)) check::fail(__FILE__, __LINE__, "taken: " + line);
  }
}

struct Lines {
  std::vector<std::string> lines;
  int overlong = 0;
  LineReader reader;

  void feed(const std::string& bytes) {
    for (const char byte : bytes) {
      switch (reader.take(static_cast<uint8_t>(byte))) {
        case LineReader::Event::LINE:
          lines.emplace_back(reinterpret_cast<const char*>(reader.line()), reader.length());
          break;
        case LineReader::Event::OVERLONG:
          ++overlong;
          break;
        case LineReader::Event::NOTHING:
          break;
      }
    }
  }
};

TEST(lines_end_with_newlines_and_empty_ones_are_left_out) {
  Lines in;
  in.feed("\n\r\nSTOP\nVEL,1,");
  in.feed("2,3\r\r\nA\rB\n");
  CHECK_EQ(in.lines.size(), 3u);
  CHECK_EQ(in.lines[0], std::string("STOP"));
  CHECK_EQ(in.lines[1], std::string("VEL,1,2,3"));
  CHECK_EQ(in.lines[2], std::string("A\rB"));
}

TEST(the_longest_line_passes_and_a_longer_one_is_thrown_away_whole) {
  Lines in;
  in.feed(std::string(MAX_LINE_BYTES, 'A') + "\r\n");
  CHECK_EQ(in.lines.size(), 1u);
  CHECK_EQ(in.lines[0].size(), static_cast<size_t>(MAX_LINE_BYTES));
  in.feed(std::string(1000, 'B') + "STOP");
  CHECK_EQ(in.overlong, 1);
  in.feed("\nSTOP\n");
  CHECK_EQ(in.lines.size(), 2u);
  CHECK_EQ(in.lines[1], std::string("STOP"));
  CHECK_EQ(in.overlong, 1);
}

// The drivetrain as a whole, in lines and PWM: what a command does, when the wheels stop by themselves.
#include <cmath>
#include <cstdlib>
#include <string>

#include "bench.h"
#include "check.h"

using namespace firmware;

static double numberOf(const std::string& line, int field) {
  size_t at = 0;
  for (int i = 0; i < field; ++i) at = line.find(',', at) + 1;
  return std::atof(line.c_str() + at);
}

static std::vector<std::pair<double, std::string>> withoutStamps(std::vector<std::pair<double, std::string>> lines) {
  for (auto& line : lines) {
    if (line.second.compare(0, 4, "ODOM") == 0) line.second.erase(line.second.rfind(','));
  }
  return lines;
}

TEST(odom_ends_with_the_time_of_its_counts) {
  Bench bench(REFERENCE, 0xFFFFFFFFu - 500000u);
  bench.run(1000, "VEL,100,0,0\n");
  const auto odom = bench.of("ODOM");
  for (size_t i = 1; i < odom.size(); ++i) {
    const auto later = static_cast<uint32_t>(numberOf(odom[i], 4));
    const auto earlier = static_cast<uint32_t>(numberOf(odom[i - 1], 4));
    CHECK_EQ(static_cast<uint32_t>(later - earlier), TELEMETRY_PERIOD_US);
  }
}

TEST(vel_turns_the_wheels_and_odom_says_how_fast) {
  Bench bench;
  bench.run(2000, "VEL,200,0,300\n");
  const auto odom = bench.of("ODOM");
  double vx = 0, vy = 0, wz = 0;
  for (size_t i = 20; i < odom.size(); ++i) {
    vx += numberOf(odom[i], 1);
    vy += numberOf(odom[i], 2);
    wz += numberOf(odom[i], 3);
  }
  const double n = static_cast<double>(odom.size() - 20);
  CHECK(std::fabs(vx / n - 200) < 3);
  CHECK(std::fabs(vy / n) < 3);
  CHECK(std::fabs(wz / n - 300) < 10);
}

TEST(odom_comes_every_50_ms_in_velocity_mode_and_enc_otherwise) {
  Bench bench;
  bench.run(1000);
  CHECK_EQ(bench.lines.size(), 20u);
  CHECK_EQ(bench.of("ENC,0,0,0,0").size(), 20u);
  bench.run(1000, "VEL,100,0,0\n");
  CHECK_EQ(bench.of("ODOM").size(), 20u);
  for (size_t i = 1; i < bench.lines.size(); ++i) {
    CHECK(std::fabs(bench.lines[i].first - bench.lines[i - 1].first - 50) < 1e-6);
  }
}

TEST(without_vel_the_wheels_stop_after_200_ms) {
  Bench bench;
  bench.run(500, "VEL,200,0,0\n", 500);
  CHECK(bench.stands());
  CHECK(bench.robot.mode() == Mode::IDLE);
  CHECK_EQ(bench.of("ERROR").size(), 1u);
  CHECK_EQ(bench.of("ERROR")[0], std::string("ERROR,WATCHDOG,no VEL for 200 ms, stopped"));
  CHECK(std::fabs(bench.timeOf("ERROR") - 200) < 2.001);
}

TEST(vel_in_time_keeps_them_turning_and_the_next_one_starts_them_again) {
  Bench bench;
  bench.run(2000, "VEL,200,0,0\n", 190);
  CHECK(bench.of("ERROR").empty());
  bench.run(500);
  CHECK(bench.stands());
  bench.run(100, "VEL,200,0,0\n");
  for (uint8_t i = 0; i < WHEELS; ++i) CHECK(bench.robot.pwm()[i] > 0);
}

TEST(a_clock_that_wraps_round_changes_nothing) {
  Bench before(REFERENCE, 0), across(REFERENCE, 0xFFFFFFFFu - 1500000u);
  for (Bench* bench : {&before, &across}) {
    bench->run(2500, "VEL,150,50,200\n");
    bench->run(500);
    bench->send("FWD,100,500\n");
    bench->run(3000);
  }
  CHECK_EQ(before.lines.size(), across.lines.size());
  // The stamps of ODOM are of that clock: for the host to unwrap.
  CHECK(withoutStamps(before.lines) == withoutStamps(across.lines));
}

TEST(stop_stops_at_once) {
  Bench bench;
  bench.run(500, "VEL,200,0,0\n");
  CHECK(!bench.stands());
  bench.send("STOP\n");
  CHECK(bench.stands());
  bench.run(100);
  CHECK_EQ(bench.of("ACK,STOP").size(), 1u);
  CHECK(bench.of("ERROR").empty());
}

TEST(a_stalled_wheel_stops_all_and_velocities_wait_for_a_stop) {
  Bench bench;
  bench.held[FR] = true;
  bench.run(5200, "VEL,200,0,0\n");
  CHECK_EQ(bench.of("ERROR")[0], std::string("ERROR,STALL,FR does not turn for 5 s, stopped"));
  CHECK(std::fabs(bench.timeOf("ERROR,STALL") - 5000) < 25);
  CHECK(bench.stands());
  bench.held[FR] = false;
  bench.run(3000, "VEL,200,0,0\n");
  CHECK(bench.stands());
  CHECK_EQ(bench.of("ERROR,HELD").size(), 4u);  // once a second
  bench.send("VEL,0,0,0\n");
  bench.run(500, "VEL,200,0,0\n");
  CHECK(!bench.stands());
}

TEST(stop_ends_the_hold_of_a_stall_too) {
  Bench bench;
  bench.held[FL] = true;
  bench.run(5200, "VEL,200,0,0\n");
  bench.held[FL] = false;
  bench.send("STOP\n");
  bench.run(100, "VEL,200,0,0\n");
  CHECK(!bench.stands());
}

TEST(standing_on_purpose_is_no_stall) {
  Bench bench;
  bench.run(8000, "VEL,0,0,0\n");
  CHECK(bench.of("ERROR").empty());
}

TEST(a_motor_that_is_tried_and_held_is_stalled_too) {
  Bench bench;
  bench.held[RR] = true;
  bench.send("TMOTOR,RR,100\n");
  bench.run(5200);
  CHECK_EQ(bench.of("ERROR,STALL,RR").size(), 1u);
  CHECK(bench.stands());
}

TEST(a_speed_under_the_dead_band_does_not_turn_the_motors) {
  Bench bench;
  bench.run(1000, "VEL,15,0,0\n");
  CHECK(bench.stands());
  CHECK_EQ(bench.ticks()[FL], 0);
}

TEST(a_position_move_ends_at_its_counts) {
  for (const char* move : {"FWD", "BWD", "LEFT", "RIGHT", "CCW", "CW"}) {
    Bench bench;
    bench.send(std::string(move) + ",100,1719\n");
    bench.run(8000);
    CHECK_EQ(bench.of(std::string("ACK,") + move).size(), 1u);
    CHECK(bench.robot.mode() == Mode::IDLE);
    CHECK(bench.stands());
    CHECK(bench.of("ODOM").empty());
    double total = 0;
    for (uint8_t i = 0; i < WHEELS; ++i) total += std::abs(bench.ticks()[i]);
    CHECK(std::fabs(total / WHEELS - 1719) < 15);  // 3 mm
  }
}

TEST(moves_turn_the_wheels_the_right_way) {
  const char* moves[] = {"FWD", "BWD", "LEFT", "RIGHT", "CCW", "CW"};
  const char* same[] = {"VEL,100,0,0\n", "VEL,-100,0,0\n", "VEL,0,100,0\n",
                        "VEL,0,-100,0\n", "VEL,0,0,400\n", "VEL,0,0,-400\n"};
  for (int i = 0; i < 6; ++i) {
    Bench move, velocity;
    move.send(std::string(moves[i]) + ",100,1000\n");
    move.run(300);
    velocity.run(300, same[i]);
    for (uint8_t w = 0; w < WHEELS; ++w) CHECK((move.robot.pwm()[w] > 0) == (velocity.robot.pwm()[w] > 0));
  }
}

TEST(a_move_over_30_seconds_is_stopped) {
  Bench bench;
  bench.send("FWD,50,100000\n");
  bench.run(31000);
  CHECK_EQ(bench.of("ERROR").size(), 1u);
  CHECK_EQ(bench.of("ERROR")[0], std::string("ERROR,TIMEOUT,move took over 30 s, stopped"));
  CHECK(std::fabs(bench.timeOf("ERROR") - 30000) < 2.001);
  CHECK(bench.stands());
}

TEST(a_move_that_cannot_be_is_refused) {
  Params params = REFERENCE;
  params.strafes = 0;
  Bench bench(params);
  for (const char* move : {"LEFT,100,500\n", "FWD,19,500\n", "FWD,0,500\n"}) {
    bench.send(move);
    bench.run(10);
  }
  CHECK(bench.robot.mode() == Mode::IDLE);
  CHECK_EQ(bench.of("ERROR,BADCMD,LEFT: this base cannot strafe").size(), 1u);
  CHECK_EQ(bench.of("ERROR,BADCMD,FWD: motors do not turn below 20 mm/s").size(), 2u);
}

TEST(a_velocity_takes_over_from_a_move_and_a_move_from_a_velocity) {
  Bench bench;
  bench.send("FWD,100,5000\n");
  bench.run(500);
  bench.run(500, "VEL,-100,0,0\n");
  CHECK(bench.robot.mode() == Mode::VELOCITY);
  CHECK(bench.robot.pwm()[FL] < 0);
  bench.send("FWD,100,300\n");
  bench.run(100);
  CHECK(bench.robot.mode() == Mode::MOVE);
  bench.run(5000);
  CHECK(bench.of("ERROR").empty());
}

TEST(one_motor_can_be_tried_and_counters_be_zeroed) {
  Bench bench;
  bench.send("TMOTOR,RL,-100\n");
  bench.run(1000);
  CHECK_EQ(bench.robot.pwm()[RL], -100);
  CHECK_EQ(bench.robot.pwm()[FL], 0);
  bench.send("CALIB\n");
  CHECK(bench.stands());
  bench.run(1000);
  const std::string first = bench.of("ENC")[20];
  CHECK_EQ(numberOf(first, 1), 0);
  CHECK(std::fabs(numberOf(first, 3)) < 150);  // it coasts on from where it was zeroed
  CHECK_EQ(bench.of("ACK,TMOTOR").size(), 1u);
  CHECK_EQ(bench.of("ACK,CALIB").size(), 1u);
}

TEST(counts_at_the_end_of_32_bit_are_reported_and_driven_over) {
  Bench bench;
  bench.first_ticks[FL] = INT32_MAX - 100LL;
  bench.first_ticks[FR] = INT32_MIN;
  bench.run(100);
  CHECK_EQ(bench.of("ENC,2147483547,-2147483647,0,0").size(), 2u);
  bench.run(1500, "VEL,200,0,0\n");
  CHECK(std::fabs(numberOf(bench.of("ODOM").back(), 1) - 200) < 5);
}

TEST(version_is_told) {
  Bench bench;
  bench.send("VERSION\n");
  bench.run(10);
  CHECK_EQ(bench.lines.size(), 1u);
  CHECK_EQ(bench.lines[0].second, std::string("VERSION,1,") + FIRMWARE_VERSION);
}

TEST(a_motor_driver_that_is_lost_stops_all_until_it_is_back) {
  Bench bench;
  bench.run(500, "VEL,200,0,0\n");
  bench.robot.setDriver(false);
  CHECK(bench.stands());
  bench.run(2000, "VEL,200,0,0\n");
  CHECK(bench.stands());
  CHECK_EQ(bench.of("ERROR,DRIVER,motor driver does not answer, stopped").size(), 1u);
  CHECK_EQ(bench.of("ERROR,HELD,motor driver does not answer").size(), 2u);
  bench.send("FWD,100,100\nTMOTOR,FL,100\n");
  CHECK(bench.stands());
  bench.robot.setDriver(true);
  bench.run(100, "VEL,200,0,0\n");
  CHECK(!bench.stands());
  CHECK_EQ(bench.of("ERROR,DRIVER").size(), 1u);
}

TEST(garbage_is_answered_and_moves_nothing) {
  for (const char* garbage : {"VEL\n", "VEL,1,2\n", "VEL,nan,0,0\n", "VEL,99999,0,0\n", "\x01\xff\xfe\n", "GO!\n"}) {
    Bench bench;
    bench.send(garbage);
    bench.run(100);
    CHECK(bench.stands());
    CHECK_EQ(bench.of("ERROR,BADCMD").size(), 1u);
  }
}

TEST(an_overlong_line_is_told_once_and_the_next_one_understood) {
  Bench bench;
  bench.send(std::string(5000, 'x') + "\nVEL,200,0,0\n");
  bench.run(100);
  CHECK(!bench.stands());
  CHECK_EQ(bench.of("ERROR,OVERFLOW,a line is at most 96 bytes").size(), 1u);
}

TEST(answers_to_a_flood_of_bad_lines_leave_room_for_telemetry) {
  Bench bench;
  for (int loop = 0; loop < 100; ++loop) {
    bench.send("VEL,100,0,0\n");
    bench.run(48);
    // Just before the report is due.
    for (int i = 0; i < 200; ++i) bench.send("?\n");
    bench.run(2);
  }
  CHECK_EQ(bench.of("ODOM").size(), 100u);
}

TEST(telemetry_begins_anew_after_a_pause) {
  Robot robot(REFERENCE, 0);
  Ticks ticks = Ticks();
  for (const char byte : std::string("VEL,100,0,0\n")) robot.receive(static_cast<uint8_t>(byte), 0);
  robot.poll(149000, ticks);
  while (!robot.output().empty()) robot.output().pop();
  ticks = {{1, 1, 1, 1}};
  robot.poll(150000, ticks);
  CHECK(robot.output().empty());  // one count in a millisecond would be 190 mm/s
  robot.poll(199000, ticks);
  CHECK(!robot.output().empty());
}

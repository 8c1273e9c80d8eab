// The drivetrain's state machine: what a command does, when the wheels stop by themselves, what is reported when.
//
//   IDLE      wheels off, ENC
//   VELOCITY  VEL holds a velocity of the base, ODOM; ends with STOP or `watchdog_us` after the last VEL
//   MOVE      FWD and its like, ENC; ends at its counts or after 30 s
//   MOTOR     TMOTOR, one motor at a PWM, ENC; ends with STOP or after 30 s
//
// A wheel that should turn and does not for 5 s stops all. A velocity is then taken only after STOP or VEL,0,0,0:
// who streams velocities would set the wheels going again 50 ms later.
//
// Knows no hardware: bytes, times and encoder counts in, PWM and bytes out.
#pragma once

#include "config.h"
#include "mecanum.h"
#include "motion.h"
#include "serial_cmd.h"
#include "text.h"
#include "types.h"

namespace firmware {

constexpr Micros ACTION_LIMIT_US = 30000000;  // of a position move and of a motor's trial
constexpr Micros HELD_REMINDER_US = 1000000;

enum class Mode : uint8_t { IDLE, VELOCITY, MOVE, MOTOR };

class Robot {
 public:
  explicit Robot(const Params& params, Micros now_us = 0);

  // A byte from the host.
  void receive(uint8_t byte, Micros now_us);

  // The control step, at 50 Hz: `ticks` are the counts at the end of the last of `periods` control periods.
  void control(Micros now_us, const Ticks& ticks, uint8_t periods);

  // Watchdogs, ends of moves and telemetry; as often as possible, at least every 10 ms.
  void poll(Micros now_us, const Ticks& ticks);

  // Whether the motor driver answers. While it does not, the wheels are off and nothing drives them.
  void setDriver(bool answers);

  // Says VERSION unasked, after a reset.
  void announce();

  const Pwm& pwm() const { return motion_.pwm(); }
  Mode mode() const { return mode_; }
  TxQueue& output() { return output_; }

 private:
  void obey(const Command& command, Micros now_us);
  void beginVelocity(const Command& command, Micros now_us);
  void beginMove(const Command& command, Micros now_us);
  void beginMotor(const Command& command, Micros now_us);
  bool refusesVelocity(const Command& command, Micros now_us);
  void stop();
  void steerMove(Micros now_us);
  uint32_t moved() const;
  void supervise(Micros now_us);
  void report(Micros now_us);

  void say(const LineBuilder& line) { output_.put(line); }
  void sayAck(const char* word);
  void sayVersion();
  // Answers to what should not have been sent leave room for telemetry.
  void complain(const LineBuilder& line);

  Params params_;
  Mecanum mecanum_;
  Motion motion_;
  LineReader reader_;
  TxQueue output_;

  Mode mode_ = Mode::IDLE;
  Micros entered_us_;
  Micros last_vel_us_;
  bool stalled_ = false;
  bool driver_answers_ = true;
  Micros reminded_us_;

  Move move_ = Move::FWD;
  int32_t move_speed_umps_ = 0;
  uint32_t move_ticks_ = 0;
  Ticks move_from_;

  Ticks ticks_;
  Ticks zero_;
  Ticks reported_ticks_;
  BodyRest report_rest_;
  Micros reported_us_;
  Micros report_due_us_;
};

}  // namespace firmware

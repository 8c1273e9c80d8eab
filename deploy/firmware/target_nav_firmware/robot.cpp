#include "robot.h"

namespace firmware {
namespace {

constexpr uint16_t TELEMETRY_ROOM = 128;  // two of its longest lines
constexpr Micros TELEMETRY_SLACK_US = TELEMETRY_PERIOD_US / 4;
constexpr uint8_t ECHO_BYTES = 40;        // of a line that is no command

// A move slows down over its last part, speed = rate * rest of the way, to a creep just over the dead-band.
constexpr int32_t SLOWDOWN_PER_S = 4;
constexpr int32_t CREEP_PERCENT_OF_DEADBAND = 150;

struct Direction {
  int8_t x, y, turn;
};
constexpr Direction DIRECTIONS[MOVES] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};

Speeds alongMove(Move move, int32_t speed_umps) {
  const Direction d = DIRECTIONS[static_cast<uint8_t>(move)];
  return Speeds{{(d.x - d.y - d.turn) * speed_umps, (d.x + d.y + d.turn) * speed_umps,
                 (d.x + d.y - d.turn) * speed_umps, (d.x - d.y + d.turn) * speed_umps}};
}

LineBuilder error(const char* code) { return LineBuilder().add("ERROR,").add(code).add(","); }

}  // namespace

Robot::Robot(const Params& params, Micros now_us)
    : params_(params),
      mecanum_(params),
      motion_(params),
      entered_us_(now_us),
      last_vel_us_(now_us),
      reminded_us_(now_us - HELD_REMINDER_US),
      move_from_(),
      ticks_(),
      zero_(),
      reported_ticks_(),
      reported_us_(now_us),
      report_due_us_(now_us + TELEMETRY_PERIOD_US) {}

void Robot::receive(uint8_t byte, Micros now_us) {
  switch (reader_.take(byte)) {
    case LineReader::Event::NOTHING:
      break;
    case LineReader::Event::OVERLONG:
      complain(error("OVERFLOW").add("a line is at most ").add(MAX_LINE_BYTES).add(" bytes"));
      break;
    case LineReader::Event::LINE: {
      Command command;
      if (parseCommand(reader_.line(), reader_.length(), command)) {
        obey(command, now_us);
      } else {
        const uint8_t shown = reader_.length() < ECHO_BYTES ? reader_.length() : ECHO_BYTES;
        complain(error("BADCMD").addForeign(reader_.line(), shown));
      }
      break;
    }
  }
}

void Robot::obey(const Command& command, Micros now_us) {
  switch (command.kind) {
    case Command::Kind::VEL:
      beginVelocity(command, now_us);
      break;
    case Command::Kind::STOP:
      stop();
      stalled_ = false;
      sayAck("STOP");
      break;
    case Command::Kind::MOVE:
      beginMove(command, now_us);
      break;
    case Command::Kind::TMOTOR:
      beginMotor(command, now_us);
      break;
    case Command::Kind::CALIB:
      stop();
      zero_ = ticks_;
      sayAck("CALIB");
      break;
    case Command::Kind::VERSION:
      sayVersion();
      break;
  }
}

void Robot::beginVelocity(const Command& command, Micros now_us) {
  if (refusesVelocity(command, now_us)) return;
  stalled_ = false;
  if (mode_ != Mode::VELOCITY) {
    stop();
    mode_ = Mode::VELOCITY;
  }
  motion_.keepSpeeds(mecanum_.wheelSpeeds(BodySpeed{command.vx_mmps, command.vy_mmps, command.wz_mradps}), now_us);
  last_vel_us_ = now_us;
}

bool Robot::refusesVelocity(const Command& command, Micros now_us) {
  const bool stands = command.vx_mmps == 0 && command.vy_mmps == 0 && command.wz_mradps == 0;
  if (driver_answers_ && (!stalled_ || stands)) return false;
  if (now_us - reminded_us_ >= HELD_REMINDER_US) {
    reminded_us_ = now_us;
    complain(driver_answers_ ? error("HELD").add("a wheel was stalled; STOP or VEL,0,0,0 first")
                             : error("HELD").add("motor driver does not answer"));
  }
  return true;
}

void Robot::beginMove(const Command& command, Micros now_us) {
  const char* name = MOVE_NAMES[static_cast<uint8_t>(command.move)];
  const bool sideways = command.move == Move::LEFT || command.move == Move::RIGHT;
  if (sideways && !params_.strafes) {
    complain(error("BADCMD").add(name).add(": this base cannot strafe"));
    return;
  }
  if (!driver_answers_) {
    complain(error("HELD").add("motor driver does not answer"));
    return;
  }
  const int32_t speed_umps = command.speed_mmps * 1000;
  if (speed_umps < params_.deadband_umps || speed_umps == 0) {
    const int32_t slowest_mmps = params_.deadband_umps / 1000;
    complain(error("BADCMD").add(name).add(": motors do not turn below ").add(slowest_mmps).add(" mm/s"));
    return;
  }
  stop();
  stalled_ = false;
  mode_ = Mode::MOVE;
  entered_us_ = now_us;
  move_ = command.move;
  move_speed_umps_ = speed_umps < params_.top_speed_umps ? speed_umps : params_.top_speed_umps;
  move_ticks_ = static_cast<uint32_t>(command.ticks);
  move_from_ = ticks_;
  steerMove(now_us);
  sayAck(name);
}

void Robot::beginMotor(const Command& command, Micros now_us) {
  stop();
  if (!driver_answers_) {
    complain(error("HELD").add("motor driver does not answer"));
    return;
  }
  stalled_ = false;
  mode_ = Mode::MOTOR;
  entered_us_ = now_us;
  Pwm pwm = Pwm();
  pwm[command.wheel] = command.pwm;
  motion_.givePwm(pwm, now_us);
  sayAck("TMOTOR");
}

void Robot::stop() {
  mode_ = Mode::IDLE;
  motion_.stop();
}

void Robot::control(Micros now_us, const Ticks& ticks, uint8_t periods) {
  ticks_ = ticks;
  if (mode_ == Mode::MOVE) steerMove(now_us);
  const int8_t wheel = motion_.update(now_us, ticks, periods);
  if (wheel == Motion::NO_WHEEL) return;
  stop();
  stalled_ = true;
  say(error("STALL").add(WHEEL_NAMES[wheel]).add(" does not turn for 5 s, stopped"));
}

void Robot::steerMove(Micros now_us) {
  const uint32_t done = moved();
  const int64_t rest_ticks = move_ticks_ > done ? move_ticks_ - done : 0;
  const int64_t slowing_umps = rest_ticks * params_.tick_nm * SLOWDOWN_PER_S / 1000;
  const int64_t creep_umps = static_cast<int64_t>(params_.deadband_umps) * CREEP_PERCENT_OF_DEADBAND / 100;
  int64_t speed_umps = slowing_umps > creep_umps ? slowing_umps : creep_umps;
  if (speed_umps > move_speed_umps_) speed_umps = move_speed_umps_;
  motion_.keepSpeeds(alongMove(move_, static_cast<int32_t>(speed_umps)), now_us);
}

uint32_t Robot::moved() const {
  uint64_t total = 0;
  for (uint8_t i = 0; i < WHEELS; ++i) total += magnitude(difference(ticks_[i], move_from_[i]));
  return static_cast<uint32_t>(total / WHEELS);
}

void Robot::poll(Micros now_us, const Ticks& ticks) {
  ticks_ = ticks;
  supervise(now_us);
  if (!isDue(now_us, report_due_us_)) return;
  report(now_us);
  // Periods are added up, so that 20 Hz stays 20 Hz whatever the loop's own rhythm. After a pause they begin anew:
  // two reports too close together would tell a speed from a count or two.
  const Micros late_us = now_us - report_due_us_;
  report_due_us_ = (late_us > TELEMETRY_SLACK_US ? now_us : report_due_us_) + TELEMETRY_PERIOD_US;
}

void Robot::supervise(Micros now_us) {
  switch (mode_) {
    case Mode::IDLE:
      break;
    case Mode::VELOCITY:
      if (now_us - last_vel_us_ >= static_cast<Micros>(params_.watchdog_us)) {
        stop();
        say(error("WATCHDOG").add("no VEL for ").add(params_.watchdog_us / 1000).add(" ms, stopped"));
      }
      break;
    case Mode::MOVE:
      if (moved() >= move_ticks_) {
        stop();
        break;
      }
      // fall through
    case Mode::MOTOR:
      if (now_us - entered_us_ >= ACTION_LIMIT_US) {
        stop();
        say(error("TIMEOUT").add("move took over 30 s, stopped"));
      }
      break;
  }
}

void Robot::report(Micros now_us) {
  // No report was due for so long only where the time jumped.
  const Micros most_us = 100 * TELEMETRY_PERIOD_US;
  const Micros elapsed_us = now_us - reported_us_ < most_us ? now_us - reported_us_ : most_us;
  Ticks counts;
  for (uint8_t i = 0; i < WHEELS; ++i) counts[i] = difference(ticks_[i], reported_ticks_[i]);
  reported_us_ = now_us;
  reported_ticks_ = ticks_;
  LineBuilder line;
  if (mode_ == Mode::VELOCITY) {
    const BodySpeed body = mecanum_.bodySpeed(counts, elapsed_us, report_rest_);
    line.add("ODOM,").add(body.vx_mmps).add(",").add(body.vy_mmps).add(",").add(body.wz_mradps);
    // When the counts were read: on its way to the host a line waits for other things.
    line.add(",").addUnsigned(now_us);
  } else {
    report_rest_ = BodyRest();
    line.add("ENC");
    for (uint8_t i = 0; i < WHEELS; ++i) {
      const int32_t count = difference(ticks_[i], zero_[i]);
      // The protocol's range is symmetric.
      line.add(",").add(count < -MAX_TICKS ? -MAX_TICKS : count);
    }
  }
  say(line);
}

void Robot::setDriver(bool answers) {
  if (answers == driver_answers_) return;
  driver_answers_ = answers;
  if (answers) return;
  stop();
  say(error("DRIVER").add("motor driver does not answer, stopped"));
}

void Robot::announce() { sayVersion(); }

void Robot::sayVersion() {
  say(LineBuilder().add("VERSION,").add(PROTOCOL_VERSION).add(",").add(FIRMWARE_VERSION));
}

void Robot::sayAck(const char* word) { say(LineBuilder().add("ACK,").add(word)); }

void Robot::complain(const LineBuilder& line) { output_.put(line, TELEMETRY_ROOM); }

}  // namespace firmware

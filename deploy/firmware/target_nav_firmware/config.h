// The robot in numbers, and how it is wired.
//
// A test holds REFERENCE to the defaults of target_nav/config.py and target_nav/sim/wheels.py.
#pragma once

#include "types.h"

namespace firmware {

constexpr char FIRMWARE_VERSION[] = "0.1.0";
constexpr uint8_t PROTOCOL_VERSION = 1;  // PROTOCOL_VERSION of target_nav/hardware/protocol.py
constexpr uint32_t SERIAL_BAUD = 115200;

struct Params {
  int32_t tick_nm;         // rim travel of one encoder count: 990 of them a turn of a 60 mm wheel
  int32_t lever_um;        // mecanum: half the wheelbase plus half the track; differential: half the track
  int32_t top_speed_umps;  // rim speed at full PWM
  int32_t deadband_umps;   // a motor that is asked for less only hums
  int32_t watchdog_us;     // velocity mode ends so long after the last VEL
  int32_t strafes;         // 1: mecanum, 0: differential
};

constexpr Params REFERENCE = {190400, 224000, 600000, 20000, 200000, 1};

namespace wiring {

constexpr uint8_t PCA9685_ADDRESS = 0x60;
constexpr uint32_t I2C_HZ = 400000;

// Channels of the PCA9685 at the two inputs of each wheel's H-bridge, 0 to 7.
constexpr uint8_t FORWARD_CHANNEL[WHEELS] = {0, 2, 4, 6};
constexpr uint8_t BACKWARD_CHANNEL[WHEELS] = {1, 3, 5, 7};

// The right side's motors are mounted the other way round, and their encoders with them.
constexpr bool REVERSED[WHEELS] = {false, true, false, true};

// Encoders: channel A of FL, FR, RL, RR at pins 2, 3, 18, 19 (INT4, INT5, INT3, INT2), channel B at 22 to 25 (PORTA).
// Pin 6 drives the PCA9685's OE, high is off; a pull-up holds it high while the Arduino resets.
constexpr uint8_t OUTPUTS_OFF_PIN = 6;

}  // namespace wiring
}  // namespace firmware

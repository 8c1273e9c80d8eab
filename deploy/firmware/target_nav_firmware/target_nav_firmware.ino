// target_nav's drivetrain: the main loop. See docs/firmware.md.
#include <Arduino.h>

#include "board.h"
#include "config.h"
#include "motor.h"
#include "pca9685.h"
#include "robot.h"

static firmware::WireBus bus;
static firmware::Pca9685 chip(bus, firmware::wiring::PCA9685_ADDRESS);
static firmware::Motors motors(chip);
static firmware::Robot robot(firmware::REFERENCE);

void setup() {
  firmware::board::begin();
  Serial.begin(firmware::SERIAL_BAUD);
  bus.begin();
  robot.announce();
}

void loop() {
  using namespace firmware;
  const Micros now_us = micros();
  // As many as the port's buffer holds, then the wheels: a flood must not keep the loop here.
  for (uint8_t i = 0; i < SERIAL_RX_BUFFER_SIZE && Serial.available() > 0; ++i) {
    robot.receive(static_cast<uint8_t>(Serial.read()), now_us);
  }

  Ticks ticks;
  uint8_t periods;
  if (board::takeControlTick(ticks, periods)) robot.control(now_us, ticks, periods);
  // The time at which the counts are read: control has taken 2 ms, which is 4 % of what ODOM averages over.
  const Micros sampled_us = micros();
  robot.poll(sampled_us, board::encoders());

  const bool answers = motors.setAll(robot.pwm(), sampled_us);
  robot.setDriver(answers);
  board::enableOutputs(answers);

  // Never waits: a full port keeps the rest in the queue.
  while (!robot.output().empty() && Serial.availableForWrite() > 0) Serial.write(robot.output().pop());
}

// The PCA9685, 16 channels of 12-bit PWM over I2C (NXP data sheet, rev. 4, 2015), of which eight are used.
#pragma once

#include "types.h"

namespace firmware {

class I2cBus {
 public:
  // False when nobody acknowledged, or the bus was stuck for a few milliseconds.
  virtual bool write(uint8_t address, const uint8_t* bytes, uint8_t count) = 0;
  virtual bool readRegister(uint8_t address, uint8_t reg, uint8_t& value) = 0;

 protected:
  ~I2cBus() = default;
};

class Pca9685 {
 public:
  static constexpr uint8_t CHANNELS = 8;
  static constexpr uint16_t FULL = 4095;
  // round(25 MHz / (4096 * 1600 Hz)) - 1, which is the chip's smallest: 1526 Hz.
  static constexpr uint8_t PRESCALE = 3;

  Pca9685(I2cBus& bus, uint8_t address) : bus_(bus), address_(address) {}

  // Sets it up with all outputs off. False when it does not answer.
  bool begin();
  // The duty of channels 0 to 7, 0 to FULL, all changed at once.
  bool write(const uint16_t (&duty)[CHANNELS]);
  // False when it does not answer or has forgotten what `begin` set, as after a brown-out.
  bool isAwake();

 private:
  bool set(uint8_t reg, uint8_t value);

  I2cBus& bus_;
  uint8_t address_;
};

}  // namespace firmware

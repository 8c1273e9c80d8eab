// The Arduino Mega 2560: timer, encoder inputs, I2C. All that the rest must not know.
#pragma once

#include "pca9685.h"
#include "types.h"

namespace firmware {

class WireBus final : public I2cBus {
 public:
  void begin();
  bool write(uint8_t address, const uint8_t* bytes, uint8_t count) override;
  bool readRegister(uint8_t address, uint8_t reg, uint8_t& value) override;
};

namespace board {

// Starts the encoders and the 50 Hz timer, with the outputs held off.
void begin();

// Whether control periods have ended since the last call: how many, and the counts at the end of the last.
bool takeControlTick(Ticks& ticks, uint8_t& periods);

// The counts now.
Ticks encoders();

// Let the PCA9685's outputs through, or hold them off. Without a call of `takeControlTick` for 200 ms, which is a main
// loop that hangs, the timer's interrupt holds them off.
void enableOutputs(bool enabled);

}  // namespace board
}  // namespace firmware

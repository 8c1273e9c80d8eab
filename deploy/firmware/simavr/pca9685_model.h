// A PCA9685 on the simulated I2C bus, by its data sheet (NXP, rev. 4, 2015).
#pragma once

#include <cstdint>

#include <sim_avr.h>

class Pca9685Model {
 public:
  Pca9685Model(avr_t* avr, uint8_t address);

  // Counts of 4096 that a channel is on; 0 while the oscillator sleeps.
  int duty(int channel) const;
  // False: it does not acknowledge, as with a broken wire. Its outputs stay as they are.
  bool connected = true;

 private:
  static void onMessage(avr_irq_t* irq, uint32_t value, void* self);
  void take(uint32_t value);
  void store(uint8_t value);
  void reply(uint8_t message, uint8_t data);

  avr_irq_t* irq_;
  uint8_t address_;
  uint8_t registers_[256] = {};
  bool selected_ = false;
  bool has_pointer_ = false;
  uint8_t pointer_ = 0;
};

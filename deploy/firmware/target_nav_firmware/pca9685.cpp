#include "pca9685.h"

namespace firmware {
namespace {

constexpr uint8_t MODE1 = 0x00;
constexpr uint8_t MODE1_RESTART = 0x80;
constexpr uint8_t MODE1_SLEEP = 0x10;
constexpr uint8_t MODE1_AUTO_INCREMENT = 0x20;
constexpr uint8_t MODE2 = 0x01;
constexpr uint8_t MODE2_TOTEM_POLE = 0x04;  // and outputs change with the I2C stop, all of them together
constexpr uint8_t LED0_OFF_L = 0x08;
constexpr uint8_t ALL_LED_ON_L = 0xFA;
constexpr uint8_t PRE_SCALE = 0xFE;
constexpr uint8_t FULL_OFF = 0x10;  // in the high byte of the off count

}  // namespace

bool Pca9685::begin() {
  // The prescaler can only be written while the oscillator sleeps. Auto-increment first, for the second line.
  if (!set(MODE1, MODE1_SLEEP | MODE1_AUTO_INCREMENT)) return false;
  const uint8_t all_off[] = {ALL_LED_ON_L, 0, 0, 0, FULL_OFF};
  return bus_.write(address_, all_off, sizeof all_off) && set(PRE_SCALE, PRESCALE) &&
         set(MODE2, MODE2_TOTEM_POLE) && set(MODE1, MODE1_AUTO_INCREMENT);
}

bool Pca9685::write(const uint16_t (&duty)[CHANNELS]) {
  // Each channel has the counts at which it goes on and off. All go on at 0, so channel 0's, which never changes,
  // is left out: the rest is 31 bytes, and Wire takes 32 in one transaction.
  uint8_t bytes[1 + 4 * CHANNELS - 2];
  uint8_t* at = bytes;
  *at++ = LED0_OFF_L;
  for (uint8_t channel = 0; channel < CHANNELS; ++channel) {
    if (channel > 0) {
      *at++ = 0;
      *at++ = 0;
    }
    const uint16_t off = duty[channel] < FULL ? duty[channel] : FULL;
    *at++ = static_cast<uint8_t>(off & 0xFF);
    *at++ = off == 0 ? FULL_OFF : static_cast<uint8_t>(off >> 8);
  }
  return bus_.write(address_, bytes, sizeof bytes);
}

bool Pca9685::isAwake() {
  uint8_t mode = 0;
  // Put to sleep while its outputs ran, the chip shows RESTART until they are written: it is awake all the same.
  return bus_.readRegister(address_, MODE1, mode) && (mode & ~MODE1_RESTART) == MODE1_AUTO_INCREMENT;
}

bool Pca9685::set(uint8_t reg, uint8_t value) {
  const uint8_t bytes[] = {reg, value};
  return bus_.write(address_, bytes, sizeof bytes);
}

}  // namespace firmware

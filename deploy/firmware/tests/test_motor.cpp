// PWM to the registers of a PCA9685 on a scripted bus: what is written, and what happens when nobody answers.
#include <vector>

#include "check.h"
#include "motor.h"

using namespace firmware;

// The chip's registers (NXP data sheet, section 7.3), with auto-increment only where MODE1 says so.
class FakeChip : public I2cBus {
 public:
  bool answers = true;
  std::vector<uint8_t> registers = std::vector<uint8_t>(256, 0);
  int writes = 0;
  int reads = 0;
  int others = 0;

  FakeChip() { powerUp(); }

  void powerUp() {
    registers.assign(256, 0);
    registers[0x00] = 0x11;  // asleep, no auto-increment
    registers[0xFE] = 30;
    for (int channel = 0; channel < 16; ++channel) registers[static_cast<size_t>(9 + 4 * channel)] = 0x10;
  }

  bool write(uint8_t address, const uint8_t* bytes, uint8_t count) override {
    ++writes;
    if (address != 0x60) ++others;
    if (!answers || address != 0x60 || count == 0) return false;
    uint8_t at = bytes[0];
    for (uint8_t i = 1; i < count; ++i) {
      put(at, bytes[i]);
      if ((registers[0x00] & 0x20) != 0) ++at;
    }
    return true;
  }

  bool readRegister(uint8_t address, uint8_t reg, uint8_t& value) override {
    ++reads;
    if (!answers || address != 0x60) return false;
    value = registers[reg];
    return true;
  }

  // Counts of 4096 a channel is on; -1 if its on count is not 0.
  int duty(int channel) const {
    const size_t base = static_cast<size_t>(6 + 4 * channel);
    if (registers[base] != 0 || registers[base + 1] != 0) return -1;
    if ((registers[base + 3] & 0x10) != 0) return 0;
    return registers[base + 2] | registers[base + 3] << 8;
  }

 private:
  void put(uint8_t reg, uint8_t value) {
    if (reg == 0xFE && (registers[0x00] & 0x10) == 0) return;  // only while asleep
    if (reg >= 0xFA && reg <= 0xFD) {
      for (int channel = 0; channel < 16; ++channel) registers[static_cast<size_t>(6 + 4 * channel + reg - 0xFA)] = value;
    } else {
      registers[reg] = value;
    }
  }
};

struct Rig {
  FakeChip fake;
  Pca9685 chip{fake, wiring::PCA9685_ADDRESS};
  Motors motors{chip};
};

TEST(it_is_woken_with_all_outputs_off) {
  Rig rig;
  CHECK(rig.motors.setAll(Pwm(), 0));
  CHECK_EQ(static_cast<int>(rig.fake.registers[0x00]), 0x20);
  CHECK_EQ(static_cast<int>(rig.fake.registers[0x01]), 0x04);
  CHECK_EQ(static_cast<int>(rig.fake.registers[0xFE]), 3);
  for (int channel = 0; channel < 16; ++channel) CHECK_EQ(rig.fake.duty(channel), 0);
}

TEST(each_wheel_has_two_channels_and_the_right_side_turns_the_other_way) {
  Rig rig;
  CHECK(rig.motors.setAll({{255, 255, -100, -1}}, 0));
  const int wanted[8] = {4095, 0, 0, 4095, 0, 1606, 16, 0};
  for (int channel = 0; channel < 8; ++channel) CHECK_EQ(rig.fake.duty(channel), wanted[channel]);
  CHECK_EQ(rig.fake.registers[9 + 4 * 1] & 0x10, 0x10);  // off is the bit for it, not equal counts
  CHECK(rig.motors.setAll({{-255, 0, 0, 0}}, 0));
  for (int channel = 0; channel < 8; ++channel) CHECK_EQ(rig.fake.duty(channel), channel == 1 ? 4095 : 0);
}

TEST(eight_bits_become_twelve) {
  CHECK_EQ(Motors::duty(0), 0);
  CHECK_EQ(Motors::duty(1), 16);
  CHECK_EQ(Motors::duty(128), 2056);
  CHECK_EQ(Motors::duty(255), 4095);
  CHECK_EQ(Motors::duty(60000), 4095);
}

TEST(all_four_motors_change_in_one_transaction_and_only_when_something_changed) {
  Rig rig;
  rig.motors.setAll(Pwm(), 0);
  const int before = rig.fake.writes;
  rig.motors.setAll({{1, 2, 3, 4}}, 0);
  CHECK_EQ(rig.fake.writes, before + 1);
  for (Micros now_us = 0; now_us < 5000000; now_us += 1000) rig.motors.setAll({{1, 2, 3, 4}}, now_us);
  CHECK_EQ(rig.fake.writes, before + 1);
  CHECK_EQ(rig.fake.reads, 4);  // is it still there? once a second
}

TEST(a_chip_that_is_not_there_is_asked_again_four_times_a_second) {
  Rig rig;
  rig.fake.answers = false;
  for (Micros now_us = 0; now_us < 1000000; now_us += 1000) CHECK(!rig.motors.setAll({{9, 9, 9, 9}}, now_us));
  CHECK_EQ(rig.fake.writes, 4);
  rig.fake.answers = true;
  CHECK(rig.motors.setAll({{255, 0, 0, 0}}, 1000000));
  CHECK_EQ(rig.fake.duty(0), 4095);
}

TEST(a_chip_that_is_lost_is_reported_at_the_next_write) {
  Rig rig;
  rig.motors.setAll({{50, 50, 50, 50}}, 0);
  rig.fake.answers = false;
  CHECK(!rig.motors.setAll({{60, 50, 50, 50}}, 20000));
}

TEST(a_chip_that_forgot_everything_is_found_within_a_second_and_set_up_again) {
  Rig rig;
  rig.motors.setAll({{50, 50, 50, 50}}, 0);
  rig.fake.powerUp();
  Micros now_us = 0;
  while (now_us < 2000000 && rig.motors.setAll({{50, 50, 50, 50}}, now_us)) now_us += 1000;
  CHECK_EQ(now_us, 1000000u);
  // Off in between: the robot stops when it learns of it.
  CHECK(rig.motors.setAll(Pwm(), now_us + 1000));
  for (int channel = 0; channel < 8; ++channel) CHECK_EQ(rig.fake.duty(channel), 0);
  CHECK_EQ(static_cast<int>(rig.fake.registers[0xFE]), 3);
}

TEST(no_other_address_is_ever_written_to) {
  Rig rig;
  rig.motors.setAll({{1, 2, 3, 4}}, 0);
  CHECK_EQ(rig.fake.others, 0);
}

TEST(a_chip_that_was_put_to_sleep_while_it_ran_is_awake_all_the_same) {
  // The Arduino was reset and the chip was not: RESTART stays set until outputs are written.
  Rig rig;
  rig.motors.setAll({{50, 50, 50, 50}}, 0);
  rig.fake.registers[0x00] = 0xA0;
  for (Micros now_us = 0; now_us < 3000000; now_us += 1000) CHECK(rig.motors.setAll({{50, 50, 50, 50}}, now_us));
}

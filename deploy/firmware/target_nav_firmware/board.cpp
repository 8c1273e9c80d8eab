#include "board.h"

#include <Arduino.h>
#include <Wire.h>
#include <util/atomic.h>

#include "config.h"
#include "encoder.h"

#ifndef __AVR_ATmega2560__
#error "the wiring is that of an Arduino Mega 2560"
#endif

namespace firmware {
namespace {

constexpr uint32_t I2C_TIMEOUT_US = 3000;
constexpr uint8_t HANG_PERIODS = 10;
constexpr uint16_t TIMER_TOP = F_CPU / 64 / (1000000UL / CONTROL_PERIOD_US) - 1;
static_assert(TIMER_TOP == 4999, "50 Hz from 16 MHz");

Encoder counters[WHEELS];
Ticks tick_counts;
volatile uint8_t ended_periods = 0;

constexpr uint8_t ENCODER_PINS[2 * WHEELS] = {2, 3, 18, 19, 22, 23, 24, 25};

// Port, bit and interrupt of pins 2, 3, 18, 19 and 22 to 25; the registers' names are the data sheet's.
inline void encoderEdge(uint8_t wheel, bool a, bool b) { counters[wheel].edge(a, b != wiring::REVERSED[wheel]); }

Ticks readCounters() {
  Ticks ticks;
  for (uint8_t i = 0; i < WHEELS; ++i) ticks[i] = counters[i].count();
  return ticks;
}

inline void holdOutputsOff() { digitalWrite(wiring::OUTPUTS_OFF_PIN, HIGH); }

}  // namespace

ISR(INT4_vect) { encoderEdge(FL, PINE & _BV(PE4), PINA & _BV(PA0)); }
ISR(INT5_vect) { encoderEdge(FR, PINE & _BV(PE5), PINA & _BV(PA1)); }
ISR(INT3_vect) { encoderEdge(RL, PIND & _BV(PD3), PINA & _BV(PA2)); }
ISR(INT2_vect) { encoderEdge(RR, PIND & _BV(PD2), PINA & _BV(PA3)); }

// The counts are taken here, where a period is a period; what follows from them, and the I2C, is the main loop's.
ISR(TIMER1_COMPA_vect) {
  tick_counts = readCounters();
  if (ended_periods < UINT8_MAX) ended_periods = static_cast<uint8_t>(ended_periods + 1);
  if (ended_periods > HANG_PERIODS) holdOutputsOff();
}

void WireBus::begin() {
  Wire.begin();
  Wire.setClock(wiring::I2C_HZ);
  // Arduino AVR Boards 1.8.3 and newer; before, Wire waited for ever on a stuck bus.
  Wire.setWireTimeout(I2C_TIMEOUT_US, true);
}

bool WireBus::write(uint8_t address, const uint8_t* bytes, uint8_t count) {
  Wire.beginTransmission(address);
  const bool fits = Wire.write(bytes, count) == count;
  return Wire.endTransmission() == 0 && fits;
}

bool WireBus::readRegister(uint8_t address, uint8_t reg, uint8_t& value) {
  if (!write(address, &reg, 1)) return false;
  if (Wire.requestFrom(address, static_cast<uint8_t>(1)) != 1) return false;
  value = static_cast<uint8_t>(Wire.read());
  return true;
}

namespace board {

void begin() {
  holdOutputsOff();
  pinMode(wiring::OUTPUTS_OFF_PIN, OUTPUT);
  for (uint8_t i = 0; i < 2 * WHEELS; ++i) pinMode(ENCODER_PINS[i], INPUT_PULLUP);
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    // Either edge of INT2 to INT5.
    EICRA = _BV(ISC20) | _BV(ISC30);
    EICRB = _BV(ISC40) | _BV(ISC50);
    EIFR = _BV(INTF2) | _BV(INTF3) | _BV(INTF4) | _BV(INTF5);
    EIMSK = _BV(INT2) | _BV(INT3) | _BV(INT4) | _BV(INT5);
    // Timer 1 counts to OCR1A at F_CPU / 64 and begins again.
    TCCR1A = 0;
    TCCR1B = _BV(WGM12) | _BV(CS11) | _BV(CS10);
    TCNT1 = 0;
    OCR1A = TIMER_TOP;
    TIMSK1 = _BV(OCIE1A);
  }
}

bool takeControlTick(Ticks& ticks, uint8_t& periods) {
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    periods = ended_periods;
    ended_periods = 0;
    if (periods > 0) ticks = tick_counts;
  }
  return periods > 0;
}

Ticks encoders() {
  Ticks ticks = Ticks();
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { ticks = readCounters(); }
  return ticks;
}

void enableOutputs(bool enabled) {
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    // Not while the timer holds them off: they come back with the next turn of the main loop.
    if (enabled && ended_periods <= HANG_PERIODS) {
      digitalWrite(wiring::OUTPUTS_OFF_PIN, LOW);
    } else {
      holdOutputsOff();
    }
  }
}

}  // namespace board
}  // namespace firmware

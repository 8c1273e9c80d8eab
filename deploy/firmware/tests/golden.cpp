// One script of commands against four modelled wheels, in whole numbers only: what the firmware says and gives its motors,
// line by line. Compiled for this machine and for the ATmega2560, where int has 16 bit and all else is emulated, the
// output has to be the same to the byte (`make golden`).
#include "robot.h"

using namespace firmware;

namespace {

constexpr Micros LOOP_US = 10000;

struct Entry {
  uint16_t at_ms;
  const char* text;
};

// VEL is repeated every 100 ms until the next entry.
constexpr Entry SCRIPT[] = {
    {100, "VERSION\n"},
    {200, "VEL,200,0,300\n"},
    {1200, "VEL,-150,100,-900\n"},
    {2000, "VEL,5000,-5000,20000\n"},
    {2600, "VEL,5000,5000,-20000\r\n"},
    {3200, "VEL,25,0,0\n"},
    {4000, "STOP\n"},
    {4200, "FWD,100,400\n"},
    {6200, "CW,300,1719\n"},
    {8500, "LEFT,2147,2147483647\n"},
    {9000, "VEL,2147483648,0,0\nVEL,-0,+0,0000000000\nXX,\x01\nTMOTOR,RR,-255\n"},
    {9300, "CALIB\n"},
    {9400, "VEL,300,0,0\n"},
    {15400, "STOP\n"},
};
constexpr uint16_t JAMMED_FROM_MS = 9900;
constexpr uint16_t END_MS = 15700;

// Rim speed follows PWM with a lag of 80 ms; rough, but the same everywhere.
struct Wheels {
  Speeds speed_umps = Speeds();
  PerWheel<int64_t> travel_nm = {{INT32_MAX * 190400LL, 0, -190400LL * INT32_MAX, 0}};

  void turn(const Pwm& pwm, bool jammed) {
    for (uint8_t i = 0; i < WHEELS; ++i) {
      const int32_t target = static_cast<int32_t>(pwm[i]) * (2353 - 100 * i);
      speed_umps[i] += (target - speed_umps[i]) / 8;
      if (jammed && i == RL) speed_umps[i] = 0;
      travel_nm[i] += static_cast<int64_t>(speed_umps[i]) * (LOOP_US / 1000);
    }
  }

  Ticks ticks() const {
    Ticks counts = Ticks();
    for (uint8_t i = 0; i < WHEELS; ++i) {
      counts[i] = static_cast<int32_t>(static_cast<uint32_t>(static_cast<uint64_t>(travel_nm[i] / REFERENCE.tick_nm)));
    }
    return counts;
  }
};

void print(const LineBuilder& line, void (*put)(char)) {
  for (uint8_t i = 0; i < line.length(); ++i) put(line.text()[i]);
  put('\n');
}

void send(Robot& robot, const char* text, Micros now_us) {
  for (; *text != '\0'; ++text) robot.receive(static_cast<uint8_t>(*text), now_us);
}

void play(void (*put)(char)) {
  // The clock wraps round in the middle.
  const Micros start_us = 0xFFFFFFFFu - 5000000u;
  Robot robot(REFERENCE, start_us);
  Wheels wheels;
  const char* repeated = nullptr;
  uint8_t next = 0;
  for (uint16_t ms = 10; ms <= END_MS; ms = static_cast<uint16_t>(ms + LOOP_US / 1000)) {
    const Micros now_us = start_us + ms * 1000UL;
    if (next < sizeof SCRIPT / sizeof SCRIPT[0] && ms >= SCRIPT[next].at_ms) {
      const char* text = SCRIPT[next++].text;
      repeated = text[0] == 'V' && text[2] == 'L' ? text : nullptr;
      send(robot, text, now_us);
    } else if (repeated != nullptr && ms % 100 == 0) {
      send(robot, repeated, now_us);
    }
    wheels.turn(robot.pwm(), ms >= JAMMED_FROM_MS);
    if (ms % (CONTROL_PERIOD_US / 1000) == 0) {
      robot.control(now_us, wheels.ticks(), 1);
      LineBuilder line;
      line.add(static_cast<int32_t>(ms)).add(" pwm");
      for (uint8_t i = 0; i < WHEELS; ++i) line.add(" ").add(static_cast<int32_t>(robot.pwm()[i]));
      print(line, put);
    }
    robot.poll(now_us, wheels.ticks());
    while (!robot.output().empty()) put(static_cast<char>(robot.output().pop()));
  }
}

}  // namespace

#ifdef __AVR__

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>

static void putSerial(char character) {
  while ((UCSR0A & _BV(UDRE0)) == 0) {
  }
  UDR0 = static_cast<uint8_t>(character);
}

int main() {
  UBRR0 = 0;  // as fast as it goes: 2 Mbit/s
  UCSR0A = _BV(U2X0);
  UCSR0C = _BV(UCSZ01) | _BV(UCSZ00);
  UCSR0B = _BV(TXEN0);
  play(putSerial);
  putSerial('\x04');
  // Sleeping without interrupts is for ever, which ends the simulation.
  cli();
  sleep_enable();
  for (;;) sleep_cpu();
}

#else

#include <cstdio>

int main() {
  play([](char character) { std::putchar(character); });
  return 0;
}

#endif

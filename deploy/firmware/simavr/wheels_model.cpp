#include "wheels_model.h"

#include <cmath>

#include <avr_ioport.h>

namespace {

using namespace firmware;

constexpr double LAG_S = 0.08;
constexpr double GAINS[WHEELS] = {1.0, 0.96, 1.03, 0.98};

struct Pin {
  char port;
  int bit;
};
// Arduino Mega: pins 2, 3, 18, 19 and 22 to 25; 6 for OE.
constexpr Pin CHANNEL_A[WHEELS] = {{'E', 4}, {'E', 5}, {'D', 3}, {'D', 2}};
constexpr Pin CHANNEL_B[WHEELS] = {{'A', 0}, {'A', 1}, {'A', 2}, {'A', 3}};
constexpr Pin OUTPUTS_OFF = {'H', 3};

avr_irq_t* pinOf(avr_t* avr, const Pin& pin) {
  return avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ(pin.port), pin.bit);
}

// Of a period of four phases, A leading: 00 10 11 01.
bool levelOfA(long phase) { return (phase & 3) == 1 || (phase & 3) == 2; }
bool levelOfB(long phase) { return (phase & 3) == 2 || (phase & 3) == 3; }

}  // namespace

WheelsModel::WheelsModel(avr_t* avr, const Pca9685Model& chip) : chip_(chip) {
  for (int i = 0; i < WHEELS; ++i) {
    shafts_[i] = Shaft{pinOf(avr, CHANNEL_A[i]), pinOf(avr, CHANNEL_B[i]), 0.0, 0.0, 0};
    avr_raise_irq(shafts_[i].a, 0);
    avr_raise_irq(shafts_[i].b, 0);
  }
  avr_irq_register_notify(pinOf(avr, OUTPUTS_OFF), onOutputsOff, this);
}

void WheelsModel::onOutputsOff(avr_irq_t*, uint32_t value, void* self) {
  static_cast<WheelsModel*>(self)->outputs_off_ = value != 0;
}

int WheelsModel::shaftDuty(int wheel) const {
  if (outputs_off_) return 0;
  return chip_.duty(wiring::FORWARD_CHANNEL[wheel]) - chip_.duty(wiring::BACKWARD_CHANNEL[wheel]);
}

void WheelsModel::drives(int (&duty)[WHEELS]) const {
  for (int i = 0; i < WHEELS; ++i) duty[i] = wiring::REVERSED[i] ? -shaftDuty(i) : shaftDuty(i);
}

void WheelsModel::step() {
  static const double follow = 1.0 - std::exp(-STEP_S / LAG_S);
  for (int i = 0; i < WHEELS; ++i) {
    Shaft& shaft = shafts_[i];
    double target = shaftDuty(i) * GAINS[i] * REFERENCE.top_speed_umps / 4095.0;
    if (std::fabs(target) < REFERENCE.deadband_umps) target = 0.0;
    shaft.speed_umps = jammed[i] ? 0.0 : shaft.speed_umps + (target - shaft.speed_umps) * follow;
    shaft.travel_um += shaft.speed_umps * STEP_S;
    const long wanted = std::lround(std::floor(shaft.travel_um * 4000.0 / REFERENCE.tick_nm));
    while (shaft.phase != wanted) {
      shaft.phase += wanted > shaft.phase ? 1 : -1;
      // Only one of the two changes; B first where both are told, so that A's interrupt sees it.
      avr_raise_irq(shaft.b, levelOfB(shaft.phase));
      avr_raise_irq(shaft.a, levelOfA(shaft.phase));
    }
  }
}

// Four motors behind the PCA9685's outputs, and the encoders on their shafts at the Arduino's pins.
#pragma once

#include <sim_avr.h>

#include "config.h"
#include "pca9685_model.h"

class WheelsModel {
 public:
  static constexpr double STEP_S = 50e-6;  // at full speed less than one edge of an encoder

  WheelsModel(avr_t* avr, const Pca9685Model& chip);

  // One step of STEP_S: wheels turn, encoders' pins follow.
  void step();
  // What each wheel is driven with, forward positive: -4095 ... 4095, 0 while OE is high.
  void drives(int (&duty)[firmware::WHEELS]) const;

  bool jammed[firmware::WHEELS] = {};

 private:
  static void onOutputsOff(avr_irq_t* irq, uint32_t value, void* self);
  int shaftDuty(int wheel) const;

  const Pca9685Model& chip_;
  bool outputs_off_ = true;  // by the pull-up, until the firmware says otherwise
  struct Shaft {
    avr_irq_t* a;
    avr_irq_t* b;
    double speed_umps;
    double travel_um;
    long phase;
  };
  Shaft shafts_[firmware::WHEELS];
};

#pragma once

#include <string>

#include "detect/decoder.hpp"
#include "source/frame_source.hpp"

namespace yolo_cam {

struct Options {
  SourceOptions source{"sim", "v2n", 640, 480, 10.0, false};
  std::string model;
  std::string backend = "cpu";
  std::string class_name = "bowling_pin";
  int drpai_frequency = 2;
  double report_every_s = 10.0;
  double watchdog_s = 5.0;
  DecoderLimits limits;
  bool help = false;
};

extern const char* const USAGE;

// Throws DeviceError: an unknown option, a missing value, a value outside its limits.
Options parse_options(int argc, const char* const* argv);

}  // namespace yolo_cam

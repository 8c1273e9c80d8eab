#include "app/options.hpp"

#include <cmath>
#include <cstdlib>
#include <functional>
#include <map>
#include <string_view>

#include "common/error.hpp"

namespace yolo_cam {

const char* const USAGE = R"(app_yolo_cam: finds the target in a camera's pictures.

  --model FILE          ONNX network (cpu), or the folder the DRP-AI translator made (drpai)
  --backend NAME        cpu (default) or drpai
  --source SOURCE       sim (default), a camera (0, /dev/video0), a video file, a folder of images
  --prefix NAME         of the channels in /dev/shm (default v2n)
  --width, --height PX  pictures (default 640 x 480)
  --rate HZ             pictures a second, at most, of a camera or file (default 10)
  --loop                begin a file or folder anew when it ends
  --class NAME          what the network finds (default bowling_pin)
  --score S             boxes below are left out until the camera process says otherwise (default 0.3)
  --overlap IOU         boxes that overlap by more are one object (default 0.5)
  --drpai-frequency N   frequency index of the DRP-AI runtime (default 2)
  --report S            seconds between lines with the stages' times (default 10)
  --watchdog S          ends the program when a picture takes longer (default 5)

Exit codes: 0 ended as asked, 1 failed and may be started again, 2 cannot be run as it was asked to.
)";

namespace {

double number_in(std::string_view name, const std::string& text, double low, double high) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (end != text.c_str() + text.size() || text.empty() || !(value >= low && value <= high)) {
    throw DeviceError(std::string(name) + " is '" + text + "'; it must be a number from " + std::to_string(low) + " to " +
                      std::to_string(high));
  }
  return value;
}

int whole_in(std::string_view name, const std::string& text, int low, int high) {
  const double value = number_in(name, text, low, high);
  if (value != std::floor(value)) {
    throw DeviceError(std::string(name) + " is '" + text + "'; it must be a whole number");
  }
  return static_cast<int>(value);
}

constexpr int SIDE_MIN_PX = 64;
constexpr int SIDE_MAX_PX = 4096;
constexpr double RATE_MIN_HZ = 0.1;
constexpr double RATE_MAX_HZ = 1000.0;
constexpr double TIME_MIN_S = 0.1;
constexpr double TIME_MAX_S = 3600.0;
constexpr int FREQUENCY_MAX = 127;

}  // namespace

Options parse_options(int argc, const char* const* argv) {
  Options options;
  using Setter = std::function<void(const std::string&)>;
  const std::map<std::string_view, Setter> with_value{
      {"--model", [&](const std::string& v) { options.model = v; }},
      {"--backend", [&](const std::string& v) { options.backend = v; }},
      {"--source", [&](const std::string& v) { options.source.source = v; }},
      {"--prefix", [&](const std::string& v) { options.source.prefix = v; }},
      {"--width", [&](const std::string& v) { options.source.width_px = whole_in("--width", v, SIDE_MIN_PX, SIDE_MAX_PX); }},
      {"--height", [&](const std::string& v) { options.source.height_px = whole_in("--height", v, SIDE_MIN_PX, SIDE_MAX_PX); }},
      {"--rate", [&](const std::string& v) { options.source.rate_hz = number_in("--rate", v, RATE_MIN_HZ, RATE_MAX_HZ); }},
      {"--class", [&](const std::string& v) { options.class_name = v; }},
      {"--score", [&](const std::string& v) { options.limits.score_min = number_in("--score", v, 0.0, 1.0); }},
      {"--overlap", [&](const std::string& v) { options.limits.overlap_max = number_in("--overlap", v, 0.0, 1.0); }},
      {"--drpai-frequency", [&](const std::string& v) { options.drpai_frequency = whole_in("--drpai-frequency", v, 1, FREQUENCY_MAX); }},
      {"--report", [&](const std::string& v) { options.report_every_s = number_in("--report", v, TIME_MIN_S, TIME_MAX_S); }},
      {"--watchdog", [&](const std::string& v) { options.watchdog_s = number_in("--watchdog", v, TIME_MIN_S, TIME_MAX_S); }},
  };
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (name == "-h" || name == "--help") {
      options.help = true;
    } else if (name == "--loop") {
      options.source.loop = true;
    } else if (const auto option = with_value.find(name); option == with_value.end()) {
      throw DeviceError("unknown option " + name + "; --help lists them");
    } else if (i + 1 == argc) {
      throw DeviceError(name + " needs a value");
    } else {
      option->second(argv[++i]);
    }
  }
  if (!options.help && options.model.empty()) {
    throw DeviceError("--model is missing: the network to run");
  }
  return options;
}

}  // namespace yolo_cam

// app_yolo_cam: pictures in, boxes out. Writes `camera` and `detections`, reads `calibration` and, for --source sim,
// `sim_camera`; docs/shared-memory.md describes them.

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>

#include <opencv2/core/utility.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <unistd.h>

#include "app/detector_loop.hpp"
#include "app/options.hpp"
#include "app/watchdog.hpp"
#include "common/clock.hpp"
#include "common/error.hpp"
#include "common/log.hpp"
#include "detect/make_backend.hpp"

namespace {

using namespace yolo_cam;

constexpr int EXIT_OK = 0;
constexpr int EXIT_FAILED = 1;
constexpr int EXIT_CANNOT_RUN = 2;

// Where the supervisor waits for a process to say that it is ready; unset without one.
constexpr const char* READY_FILE_VARIABLE = "TARGET_NAV_READY_FILE";

volatile std::sig_atomic_t stop_requested = 0;

void request_stop(int number) {
  // A second signal while the first is still being obeyed ends the process at once.
  if (stop_requested != 0) {
    std::signal(number, SIG_DFL);
    std::raise(number);
  }
  stop_requested = 1;
}

void report_ready() {
  if (const char* path = std::getenv(READY_FILE_VARIABLE); path != nullptr && *path != '\0') {
    std::ofstream(path, std::ios::app).flush();
  }
}

int run(const Options& options) {
  // One thread: the machine's cores are shared out among processes, not within them.
  cv::setNumThreads(1);
  // What fails is told in our own words; OpenCV quotes bytes out of broken files.
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  const double begin_s = monotonic_s();
  const auto backend = make_backend(options.backend, options.model, options.drpai_frequency);
  const auto source = open_source(options.source);
  Watchdog watchdog(options.watchdog_s, [&](const std::string& where) {
    log::error("stood still for " + std::to_string(options.watchdog_s) + " s while " + where + "; ended by its watchdog");
    ::_exit(EXIT_FAILED);
  });
  DetectorLoop loop(options, *source, *backend, watchdog);
  log::info(backend->description() + ", model " + options.model + ", source " + options.source.source + ", ready after " +
            std::to_string(static_cast<int>(1e3 * (monotonic_s() - begin_s))) + " ms");
  report_ready();
  while (stop_requested == 0 && !source->end()) {
    loop.step();
    if (const auto line = loop.report(monotonic_s())) {
      log::info(*line);
    }
  }
  if (const auto& end = source->end(); end && end->lost) {
    log::error(end->why);
    return EXIT_FAILED;
  }
  log::info(source->end() ? source->end()->why : "stopped");
  return EXIT_OK;
}

}  // namespace

int main(int argc, char** argv) {
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    std::signal(number, request_stop);
  }
  try {
    const Options options = parse_options(argc, argv);
    if (options.help) {
      std::fputs(USAGE, stdout);
      return EXIT_OK;
    }
    return run(options);
  } catch (const DeviceError& error) {
    log::error(error.what());
    return EXIT_CANNOT_RUN;
  } catch (const std::exception& error) {
    log::error(std::string("failed: ") + error.what());
    return EXIT_FAILED;
  }
}

#include "common/log.hpp"

#include <array>
#include <cstdio>
#include <ctime>
#include <string>

#include <unistd.h>

namespace yolo_cam::log {
namespace {

constexpr long NS_PER_MS = 1'000'000;

void line(const char* level, std::string_view text) {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  tm local{};
  localtime_r(&now.tv_sec, &local);
  std::array<char, 48> head{};
  const int size = std::snprintf(head.data(), head.size(), "%02d:%02d:%02d.%03ld %-7s detector: ", local.tm_hour,
                                 local.tm_min, local.tm_sec, now.tv_nsec / NS_PER_MS, level);
  std::string whole(head.data(), static_cast<std::size_t>(size));
  whole.append(text).push_back('\n');
  // One write, so that lines of two processes in one file do not mix. Nobody is left to be told of a failure.
  [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, whole.data(), whole.size());
}

}  // namespace

void info(std::string_view text) { line("INFO", text); }
void warning(std::string_view text) { line("WARNING", text); }
void error(std::string_view text) { line("ERROR", text); }

}  // namespace yolo_cam::log

// Ends the program when the loop has stood still: a hung driver does not answer, and whoever started us starts us anew.
#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

namespace yolo_cam {

class Watchdog {
 public:
  // `bite` is called once, from the watchdog's own thread, with where the loop stood. Armed by the first `beat`.
  Watchdog(double limit_s, std::function<void(const std::string&)> bite);
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;
  Watchdog(Watchdog&&) = delete;
  Watchdog& operator=(Watchdog&&) = delete;
  ~Watchdog();

  // The loop lives and begins with `where`, a literal.
  void beat(const char* where);

 private:
  void watch();

  double limit_s_;
  std::function<void(const std::string&)> bite_;
  std::atomic<double> last_s_{0.0};
  std::atomic<const char*> where_{""};
  std::mutex mutex_;
  std::condition_variable wake_;
  bool ended_ = false;
  std::thread thread_;
};

}  // namespace yolo_cam

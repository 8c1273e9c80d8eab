// What several tests need: a prefix of their own, channels that go with it, temporary folders.
#pragma once

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <unistd.h>

#include "common/clock.hpp"

namespace support {

inline std::string unique_name() {
  static std::atomic<int> count{0};
  return "t" + std::to_string(::getpid()) + "x" + std::to_string(yolo_cam::monotonic_ns() % 1'000'000'000) + "x" +
         std::to_string(count++);
}

// A prefix whose files go when it does.
class Prefix {
 public:
  Prefix() : name(unique_name()) {}
  Prefix(const Prefix&) = delete;
  Prefix& operator=(const Prefix&) = delete;
  ~Prefix() {
    for (const auto& entry : std::filesystem::directory_iterator("/dev/shm")) {
      if (entry.path().filename().string().rfind(name + "_", 0) == 0) {
        std::filesystem::remove(entry.path());
      }
    }
  }
  const std::string name;
};

class Folder {
 public:
  Folder() : path(std::filesystem::temp_directory_path() / unique_name()) { std::filesystem::create_directories(path); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() { std::filesystem::remove_all(path); }
  const std::filesystem::path path;
};

inline std::string model_path() { return std::string(TEST_DATA) + "/red_square.onnx"; }

}  // namespace support

// The system calls a camera takes, behind an interface: tests put a camera there that can be unplugged.
#pragma once

#include <cstddef>
#include <string>

namespace yolo_cam {

class V4l2Api {
 public:
  V4l2Api() = default;
  V4l2Api(const V4l2Api&) = delete;
  V4l2Api& operator=(const V4l2Api&) = delete;
  V4l2Api(V4l2Api&&) = delete;
  V4l2Api& operator=(V4l2Api&&) = delete;
  virtual ~V4l2Api() = default;

  // All as the system calls of the same name: -1 (map: null) and errno on failure.
  virtual int open(const std::string& path) = 0;
  virtual void close(int descriptor) = 0;
  virtual int control(int descriptor, unsigned long request, void* argument) = 0;
  virtual void* map(int descriptor, std::size_t size, std::size_t offset) = 0;
  virtual void unmap(void* at, std::size_t size) = 0;
  // 1 something to fetch, 0 nothing within the time, -1 failed.
  virtual int wait(int descriptor, double timeout_s) = 0;
};

// The kernel's own.
V4l2Api& system_v4l2();

}  // namespace yolo_cam

#include "source/v4l2_api.hpp"

#include <cerrno>

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

namespace yolo_cam {
namespace {

constexpr double MS = 1e3;

class SystemV4l2 final : public V4l2Api {
 public:
  int open(const std::string& path) override { return ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC); }
  void close(int descriptor) override { ::close(descriptor); }
  int control(int descriptor, unsigned long request, void* argument) override {
    int result = -1;
    do {
      result = ::ioctl(descriptor, request, argument);
    } while (result == -1 && errno == EINTR);
    return result;
  }
  void* map(int descriptor, std::size_t size, std::size_t offset) override {
    void* at = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, static_cast<off_t>(offset));
    return at == MAP_FAILED ? nullptr : at;
  }
  void unmap(void* at, std::size_t size) override { ::munmap(at, size); }
  int wait(int descriptor, double timeout_s) override {
    pollfd watched{descriptor, POLLIN, 0};
    const int result = ::poll(&watched, 1, static_cast<int>(timeout_s * MS));
    if (result < 0) {
      return errno == EINTR ? 0 : -1;
    }
    // An unplugged camera reports an error at once and forever: the next fetch tells which.
    return result;
  }
};

}  // namespace

V4l2Api& system_v4l2() {
  static SystemV4l2 api;
  return api;
}

}  // namespace yolo_cam

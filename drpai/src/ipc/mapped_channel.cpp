#include "ipc/mapped_channel.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <new>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include "common/clock.hpp"
#include "common/error.hpp"

namespace yolo_cam {
namespace {

using target_nav::ipc::FileHeader;
using target_nav::ipc::LAYOUT_VERSION;
using target_nav::ipc::MAGIC;

// Others hold the lock for microseconds to ask whether a writer lives.
constexpr double CLAIM_PATIENCE_S = 0.1;
constexpr useconds_t CLAIM_RETRY_US = 2000;
constexpr std::size_t PREFIX_MAX = 64;
constexpr mode_t FILE_MODE = 0660;
constexpr int READ_FLAGS = O_RDONLY | O_CLOEXEC | O_NOFOLLOW;
constexpr int WRITE_FLAGS = O_RDWR | O_CLOEXEC | O_NOFOLLOW;

class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&&) = delete;
  ~Descriptor() {
    if (number_ >= 0) {
      ::close(number_);
    }
  }
  int get() const { return number_; }
  int release() { return std::exchange(number_, -1); }

 private:
  int number_;
};

// The words of the header that tell what a file is, read without mapping it.
struct Identity {
  std::array<char, sizeof(FileHeader)> raw{};
  ssize_t size = 0;

  std::uint32_t word(std::size_t offset) const {
    std::uint32_t value = 0;
    std::memcpy(&value, raw.data() + offset, sizeof value);
    return value;
  }
  bool has_magic() const { return std::memcmp(raw.data(), MAGIC, sizeof FileHeader::magic) == 0; }
  bool blank() const {
    const bool zero = std::all_of(raw.begin(), raw.begin() + sizeof FileHeader::magic, [](char c) { return c == 0; });
    return word(offsetof(FileHeader, ready)) == 0 && (zero || has_magic());
  }
  bool foreign() const { return !has_magic() && !blank(); }
  bool fits(const Geometry& geometry) const {
    return has_magic() && word(offsetof(FileHeader, ready)) == 1 &&
           word(offsetof(FileHeader, layout_version)) == LAYOUT_VERSION &&
           word(offsetof(FileHeader, layout_hash)) == geometry.layout_hash;
  }
};

Identity identify(int descriptor) {
  Identity identity;
  identity.size = ::pread(descriptor, identity.raw.data(), identity.raw.size(), 0);
  return identity;
}

std::uint64_t size_of(int descriptor) {
  struct stat status {};
  return ::fstat(descriptor, &status) == 0 ? static_cast<std::uint64_t>(status.st_size) : 0;
}

std::optional<ino_t> inode_of_descriptor(int descriptor) {
  struct stat status {};
  return ::fstat(descriptor, &status) == 0 ? std::optional(status.st_ino) : std::nullopt;
}

DeviceError explained(const std::string& path, int error, std::uint64_t wanted_bytes) {
  std::string advice = "is shared memory mounted at /dev/shm?";
  if (error == EACCES || error == EPERM) {
    advice = "it belongs to another user; run all processes as the same one, or remove it";
  } else if (error == ENOSPC || error == ENOMEM) {
    advice = std::to_string(wanted_bytes / 1'000'000) +
             " MB wanted; make /dev/shm larger (Docker: --shm-size) or remove what is not needed there";
  }
  return DeviceError(path + ": " + std::generic_category().message(error) + "; " + advice);
}

DeviceError foreign_file(const std::string& path) {
  return DeviceError(path + " is not a channel of target_nav (no " + MAGIC +
                     " at its beginning); remove it or choose another prefix");
}

bool locked_by_other(int descriptor) {
  if (::flock(descriptor, LOCK_SH | LOCK_NB) != 0) {
    return true;
  }
  ::flock(descriptor, LOCK_UN);
  return false;
}

Descriptor open_or_create(const std::string& path, const Geometry& geometry) {
  // Not O_CREAT on a file that exists: in a sticky directory the kernel refuses that for another user's file.
  while (true) {
    int descriptor = ::open(path.c_str(), WRITE_FLAGS);
    if (descriptor < 0 && errno == ENOENT) {
      descriptor = ::open(path.c_str(), WRITE_FLAGS | O_CREAT | O_EXCL, FILE_MODE);
      if (descriptor < 0 && errno == EEXIST) {
        continue;
      }
    }
    if (descriptor < 0) {
      throw explained(path, errno, geometry.file_bytes);
    }
    return Descriptor(descriptor);
  }
}

void initialise(FileHeader& header, const Geometry& geometry) {
  std::memcpy(header.magic, MAGIC, sizeof header.magic);
  header.layout_version = LAYOUT_VERSION;
  header.layout_hash = geometry.layout_hash;
  header.writer_pid = static_cast<std::uint32_t>(::getpid());
  header.slot_count = geometry.slot_count;
  header.slot_bytes = geometry.slot_bytes;
  header.payload_bytes = geometry.payload_bytes;
  std::strncpy(header.layout_name, geometry.layout_name, sizeof header.layout_name - 1);
  header.ready.store(1, std::memory_order_release);
}

}  // namespace

std::string path_of(const std::string& prefix, const char* channel) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9'); };
  const bool sound = !prefix.empty() && prefix.size() <= PREFIX_MAX && letter(prefix.front()) &&
                     std::all_of(prefix.begin(), prefix.end(),
                                 [&](char c) { return letter(c) || c == '_' || c == '.' || c == '-'; });
  const std::string ending = "_sim";
  const bool meets_sim = prefix.size() >= ending.size() &&
                         prefix.compare(prefix.size() - ending.size(), ending.size(), ending) == 0;
  if (!sound || meets_sim) {
    throw DeviceError("--prefix is '" + prefix +
                      "'; it must be 1 to 64 letters, digits, '_', '-' or '.', begin with a letter or digit and not "
                      "end with '_sim'");
  }
  return "/dev/shm/" + prefix + "_" + channel;
}

std::optional<ino_t> inode_of(const std::string& path) {
  struct stat status {};
  return ::stat(path.c_str(), &status) == 0 ? std::optional(status.st_ino) : std::nullopt;
}

MappedChannel MappedChannel::claim(const std::string& path, const Geometry& geometry) {
  const double give_up_s = monotonic_s() + CLAIM_PATIENCE_S;
  while (true) {
    Descriptor file = open_or_create(path, geometry);
    if (::flock(file.get(), LOCK_EX | LOCK_NB) != 0) {
      if (errno != EWOULDBLOCK) {
        throw explained(path, errno, geometry.file_bytes);
      }
      if (monotonic_s() < give_up_s) {
        ::usleep(CLAIM_RETRY_US);
        continue;
      }
      const std::uint32_t pid = identify(file.get()).word(offsetof(FileHeader, writer_pid));
      throw DeviceError("another instance (pid " + (pid != 0 ? std::to_string(pid) : "unknown") + ") writes " + path +
                        "; stop it or choose another --prefix");
    }
    if (inode_of(path) != inode_of_descriptor(file.get())) {
      continue;  // The name meanwhile means another file.
    }
    const Identity identity = identify(file.get());
    const std::uint64_t size = size_of(file.get());
    if (identity.foreign()) {
      throw foreign_file(path);
    }
    if (identity.blank() && size <= geometry.file_bytes) {
      int failed = ::ftruncate(file.get(), static_cast<off_t>(geometry.file_bytes)) != 0 ? errno : 0;
      if (failed == 0) {
        failed = ::posix_fallocate(file.get(), 0, sizeof(FileHeader));
      }
      if (failed != 0) {
        throw explained(path, failed, geometry.file_bytes);
      }
      MappedChannel mapped(path, file.release(), geometry, true);
      initialise(mapped.header(), geometry);
      return mapped;
    }
    if (identity.fits(geometry) && size == geometry.file_bytes) {
      return {path, file.release(), geometry, true};
    }
    ::unlink(path.c_str());
  }
}

std::optional<MappedChannel> MappedChannel::open_for_reading(const std::string& path, const Geometry& geometry) {
  Descriptor file(::open(path.c_str(), READ_FLAGS));
  if (file.get() < 0) {
    if (errno == ENOENT) {
      return std::nullopt;
    }
    throw explained(path, errno, geometry.file_bytes);
  }
  const Identity identity = identify(file.get());
  if (identity.foreign()) {
    throw foreign_file(path);
  }
  if (identity.fits(geometry) && size_of(file.get()) == geometry.file_bytes) {
    return MappedChannel(path, file.release(), geometry, false);
  }
  if (!identity.blank() && locked_by_other(file.get())) {
    throw DeviceError(path + " has another layout than this program reads, and its writer (pid " +
                      std::to_string(identity.word(offsetof(FileHeader, writer_pid))) +
                      ") lives; build and start both from the same sources");
  }
  return std::nullopt;
}

MappedChannel::MappedChannel(std::string path, int descriptor, const Geometry& geometry, bool writable)
    : path_(std::move(path)), descriptor_(descriptor), geometry_(geometry) {
  void* at = ::mmap(nullptr, geometry.file_bytes, writable ? PROT_READ | PROT_WRITE : PROT_READ, MAP_SHARED, descriptor, 0);
  if (at == MAP_FAILED) {
    const int error = errno;
    ::close(descriptor);
    descriptor_ = -1;
    throw explained(path_, error, geometry.file_bytes);
  }
  base_ = static_cast<std::byte*>(at);
  inode_ = inode_of_descriptor(descriptor).value_or(0);
}

MappedChannel::MappedChannel(MappedChannel&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      geometry_(other.geometry_),
      base_(std::exchange(other.base_, nullptr)),
      inode_(other.inode_),
      reserved_bytes_(other.reserved_bytes_) {}

MappedChannel& MappedChannel::operator=(MappedChannel&& other) noexcept {
  if (this != &other) {
    release();
    path_ = std::move(other.path_);
    descriptor_ = std::exchange(other.descriptor_, -1);
    geometry_ = other.geometry_;
    base_ = std::exchange(other.base_, nullptr);
    inode_ = other.inode_;
    reserved_bytes_ = other.reserved_bytes_;
  }
  return *this;
}

MappedChannel::~MappedChannel() { release(); }

void MappedChannel::release() noexcept {
  if (base_ != nullptr) {
    ::munmap(base_, geometry_.file_bytes);
    base_ = nullptr;
  }
  if (descriptor_ >= 0) {
    ::close(descriptor_);
    descriptor_ = -1;
  }
}

bool MappedChannel::removed() const {
  struct stat status {};
  return ::fstat(descriptor_, &status) == 0 && status.st_nlink == 0;
}

void MappedChannel::reserve(std::size_t slot_bytes) {
  if (slot_bytes <= reserved_bytes_) {
    return;
  }
  for (std::uint32_t index = 0; index < geometry_.slot_count; ++index) {
    const int failed = ::posix_fallocate(descriptor_, slot_at(index) - base_, static_cast<off_t>(slot_bytes));
    if (failed != 0) {
      throw explained(path_, failed, slot_bytes * geometry_.slot_count);
    }
  }
  reserved_bytes_ = slot_bytes;
}

}  // namespace yolo_cam

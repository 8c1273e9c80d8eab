// A channel's file in /dev/shm: made, claimed by one writer, opened by readers, never shrunk.
//
// The same rules as target_nav/ipc/files.py. A writer holds `flock` on the file itself, which the kernel releases
// whenever it dies. A file of another layout is not rewritten but replaced.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include <sys/types.h>

#include "channels.hpp"

namespace yolo_cam {

struct Geometry {
  const char* channel;
  const char* layout_name;
  std::uint32_t layout_hash;
  std::uint32_t slot_count;
  std::uint32_t slot_bytes;
  std::uint32_t payload_bytes;
  std::uint64_t file_bytes;
};

template <class Channel>
constexpr Geometry geometry_of() {
  return {Channel::NAME,       Channel::LAYOUT_NAME, Channel::LAYOUT_HASH,
          Channel::SLOT_COUNT, Channel::SLOT_BYTES,  static_cast<std::uint32_t>(sizeof(typename Channel::Payload)),
          Channel::FILE_BYTES};
}

// /dev/shm/<prefix>_<channel>. Throws DeviceError for a prefix that is no file name.
std::string path_of(const std::string& prefix, const char* channel);

// The inode behind a name, if there is one.
std::optional<ino_t> inode_of(const std::string& path);

class MappedChannel {
 public:
  // The file, made or replaced if need be, locked for this writer; the header still has to be taken over.
  // Throws DeviceError: another live process holds it, it is no channel of ours, or the system refuses.
  static MappedChannel claim(const std::string& path, const Geometry& geometry);

  // The file if it is there and finished. A leftover of another layout counts as not there.
  // Throws DeviceError: a live writer uses another layout, it is no channel of ours, or the system refuses.
  static std::optional<MappedChannel> open_for_reading(const std::string& path, const Geometry& geometry);

  MappedChannel(MappedChannel&& other) noexcept;
  MappedChannel& operator=(MappedChannel&& other) noexcept;
  MappedChannel(const MappedChannel&) = delete;
  MappedChannel& operator=(const MappedChannel&) = delete;
  ~MappedChannel();

  target_nav::ipc::FileHeader& header() const { return *reinterpret_cast<target_nav::ipc::FileHeader*>(base_); }
  target_nav::ipc::SlotHeader& slot(std::uint32_t index) const {
    return *reinterpret_cast<target_nav::ipc::SlotHeader*>(slot_at(index));
  }
  // Where slot `index` begins: a SlotHeader, then the payload.
  std::byte* slot_at(std::uint32_t index) const {
    return base_ + sizeof(target_nav::ipc::FileHeader) + static_cast<std::size_t>(index) * geometry_.slot_bytes;
  }
  std::byte* payload_at(std::uint32_t index) const { return slot_at(index) + sizeof(target_nav::ipc::SlotHeader); }

  const Geometry& geometry() const { return geometry_; }
  ino_t inode() const { return inode_; }

  // The file has no name any more, so no reader will find it.
  bool removed() const;

  // Takes memory for so many bytes of each slot: storing into a full /dev/shm is a SIGBUS, this is a DeviceError.
  void reserve(std::size_t slot_bytes);

 private:
  MappedChannel(std::string path, int descriptor, const Geometry& geometry, bool writable);
  void release() noexcept;

  std::string path_;
  int descriptor_ = -1;
  Geometry geometry_{};
  std::byte* base_ = nullptr;
  ino_t inode_ = 0;
  std::size_t reserved_bytes_ = 0;
};

}  // namespace yolo_cam

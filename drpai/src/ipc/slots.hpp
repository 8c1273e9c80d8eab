// The protocol of one slot: store so that a reader can tell, load so that nothing torn gets through.
//
// The words and their memory orders are those in generated/channels.hpp; docs/shared-memory.md says why.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <variant>

#include "ipc/mapped_channel.hpp"

namespace yolo_cam {

struct Bytes {
  const void* data = nullptr;
  std::size_t size = 0;
};

// A store in its steps, so that a test can die between any two of them.
class SlotStore {
 public:
  SlotStore(MappedChannel& channel, std::uint64_t sequence);

  void mark_busy();
  // `head` lies under the CRC, `bulk` does not. Together they fit the slot.
  void copy(Bytes head, Bytes bulk);
  void mark_done();
  void publish();

 private:
  MappedChannel& channel_;
  std::uint64_t sequence_;
  std::uint32_t index_;
};

enum class Fault { Torn, Crc };

// What a slot held: its whole sequence and how many bytes of the payload were copied to `head`.
struct Loaded {
  std::uint64_t sequence;
  std::size_t head_bytes;
};

// (head, its bytes, bytes of bulk) -> where to copy the bulk, null if that cannot be right.
using BulkSink = std::function<void*(const std::byte*, std::size_t, std::size_t)>;

// A private, verified copy of the payload whose sequence ends in `sequence_low`, up to `head_capacity` bytes into
// `head`; what follows is bulk and goes to `sink` (none: it is left where it is).
std::variant<Loaded, Fault> load(const MappedChannel& channel, std::uint32_t sequence_low, std::byte* head,
                                 std::size_t head_capacity, const BulkSink& sink);

// One writer's time: the first sequence it may use, and the slots of a dead predecessor it had to clean.
struct Reign {
  std::uint64_t generation;
  unsigned repaired;
};

// Makes this process the file's writer in the header; the caller holds the lock. In a new file sequences begin at
// `fresh_sequence`, the monotonic clock in nanoseconds, so that they never go back.
Reign take_over(MappedChannel& channel, std::size_t head_bytes, std::uint64_t fresh_sequence);

}  // namespace yolo_cam

#include "ipc/slots.hpp"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <vector>

#include <unistd.h>

#include "ipc/crc32.hpp"

namespace yolo_cam {
namespace {

using target_nav::ipc::lock_busy;
using target_nav::ipc::lock_done;
using target_nav::ipc::SlotHeader;

// What the CRC covers before the payload, in the order in which it lies in the slot.
struct Sealed {
  std::uint64_t sequence;
  std::uint32_t length;
  std::uint32_t reserved;
};
static_assert(sizeof(Sealed) == sizeof(SlotHeader) - offsetof(SlotHeader, sequence));

std::uint32_t index_of(const MappedChannel& channel, std::uint64_t sequence) {
  return static_cast<std::uint32_t>(sequence & (channel.geometry().slot_count - 1));
}

}  // namespace

SlotStore::SlotStore(MappedChannel& channel, std::uint64_t sequence)
    : channel_(channel), sequence_(sequence), index_(index_of(channel, sequence)) {}

void SlotStore::mark_busy() {
  channel_.slot(index_).lock.store(lock_busy(sequence_), std::memory_order_relaxed);
  std::atomic_thread_fence(std::memory_order_release);
}

void SlotStore::copy(Bytes head, Bytes bulk) {
  const Sealed sealed{sequence_, static_cast<std::uint32_t>(head.size + bulk.size), 0};
  SlotHeader& slot = channel_.slot(index_);
  slot.crc = crc32(head.data, head.size, crc32(&sealed, sizeof sealed));
  slot.sequence = sealed.sequence;
  slot.length = sealed.length;
  slot.reserved = sealed.reserved;
  std::byte* payload = channel_.payload_at(index_);
  std::memcpy(payload, head.data, head.size);
  if (bulk.size != 0) {
    std::memcpy(payload + head.size, bulk.data, bulk.size);
  }
}

void SlotStore::mark_done() { channel_.slot(index_).lock.store(lock_done(sequence_), std::memory_order_release); }

void SlotStore::publish() {
  channel_.header().published.store(static_cast<std::uint32_t>(sequence_), std::memory_order_release);
}

std::variant<Loaded, Fault> load(const MappedChannel& channel, std::uint32_t sequence_low, std::byte* head,
                                 std::size_t head_capacity, const BulkSink& sink) {
  const std::uint32_t index = index_of(channel, sequence_low);
  const SlotHeader& slot = channel.slot(index);
  const std::uint32_t expected = lock_done(sequence_low);
  if (slot.lock.load(std::memory_order_acquire) != expected) {
    return Fault::Torn;
  }
  const std::uint32_t crc = slot.crc;
  const Sealed sealed{slot.sequence, slot.length, slot.reserved};
  if (sealed.length > channel.geometry().payload_bytes) {
    return Fault::Torn;
  }
  const std::byte* payload = channel.payload_at(index);
  const std::size_t head_bytes = std::min<std::size_t>(sealed.length, head_capacity);
  std::memcpy(head, payload, head_bytes);
  if (sink) {
    const std::size_t bulk_bytes = sealed.length - head_bytes;
    void* target = sink(head, head_bytes, bulk_bytes);
    if (target == nullptr) {
      return Fault::Torn;
    }
    std::memcpy(target, payload + head_bytes, bulk_bytes);
  }
  std::atomic_thread_fence(std::memory_order_acquire);
  if (slot.lock.load(std::memory_order_relaxed) != expected) {
    return Fault::Torn;
  }
  const bool right_sequence = static_cast<std::uint32_t>(sealed.sequence) == sequence_low;
  if (!right_sequence || crc != crc32(head, head_bytes, crc32(&sealed, sizeof sealed))) {
    return Fault::Crc;
  }
  return Loaded{sealed.sequence, head_bytes};
}

Reign take_over(MappedChannel& channel, std::size_t head_bytes, std::uint64_t fresh_sequence) {
  std::uint64_t highest = 0;
  unsigned repaired = 0;
  std::vector<std::byte> head(head_bytes);
  for (std::uint32_t index = 0; index < channel.geometry().slot_count; ++index) {
    SlotHeader& slot = channel.slot(index);
    if (slot.lock.load(std::memory_order_relaxed) == 0 && slot.sequence == 0) {
      continue;
    }
    const auto low = static_cast<std::uint32_t>(slot.sequence);
    const bool in_place = (low & (channel.geometry().slot_count - 1)) == index;
    const auto result = in_place ? load(channel, low, head.data(), head.size(), {}) : Fault::Crc;
    if (const auto* loaded = std::get_if<Loaded>(&result)) {
      highest = std::max(highest, loaded->sequence);
    } else {
      slot.lock.store(0, std::memory_order_relaxed);
      slot.sequence = 0;
      ++repaired;
    }
  }
  auto& header = channel.header();
  const std::uint64_t previous = static_cast<std::uint64_t>(header.generation_high) << 32 | header.generation_low;
  const std::uint64_t generation = std::max(highest + 1, previous != 0 ? previous : fresh_sequence);
  const std::uint32_t changing = header.claim.load(std::memory_order_relaxed) | 1U;
  header.claim.store(changing, std::memory_order_relaxed);
  std::atomic_thread_fence(std::memory_order_release);
  header.writer_pid = static_cast<std::uint32_t>(::getpid());
  header.generation_low = static_cast<std::uint32_t>(generation);
  header.generation_high = static_cast<std::uint32_t>(generation >> 32);
  header.published.store(static_cast<std::uint32_t>(generation - 1), std::memory_order_release);
  header.claim.store(changing + 1, std::memory_order_release);
  return {generation, repaired};
}

}  // namespace yolo_cam

#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

namespace prehend::graph {

/// Readers that can hold leases on a node's slabs at the same time; more get inline frames.
inline constexpr std::uint32_t kMaxSlabReaders = 60;

/// What stands at the front of a slab's file, in a page of its own. Shared between processes.
///
/// A lease word counts what one reader process has of the slab: generation (32 bits) | messages on
/// their way to it, granted (16) | messages it holds, taken (16). The publisher grants; the reader
/// turns a grant into a lease when the message arrives, and gives the lease back when the message
/// is dropped. What a killed reader held is written off by the publisher, and a word of an older
/// generation is never touched, so a late reader cannot harm a slab that was used again.
struct SlabHeader {
  static constexpr std::uint64_t kMagic = 0x31424c5348455250;  // "PREHSLB1"
  std::uint64_t magic = kMagic;
  std::uint64_t id = 0;
  std::uint64_t capacity = 0;                                   // bytes behind the header
  std::atomic<std::uint32_t> retired = 0;                       // the publisher has let go of it
  std::atomic<std::uint64_t> leases[kMaxSlabReaders + 1] = {};  // by reader, from 1
};
inline constexpr std::size_t kSlabHeaderBytes = 4096;
static_assert(sizeof(SlabHeader) <= kSlabHeaderBytes);
static_assert(std::atomic<std::uint64_t>::is_always_lock_free);

/// One piece of shared memory that a publisher writes and readers of other processes map: an
/// anonymous file (memfd_create), which readers open as /proc/PID/fd/FILE and which is gone with
/// the last process that has it, however that ends.
class Slab {
 public:
  /// Throws std::system_error when the memory cannot be had.
  explicit Slab(std::size_t capacity);
  ~Slab();
  Slab(const Slab&) = delete;
  Slab& operator=(const Slab&) = delete;

  std::uint8_t* data() const { return base_ + kSlabHeaderBytes; }
  std::size_t capacity() const { return capacity_; }
  int file() const { return file_; }
  std::uint64_t id() const { return header().id; }
  std::uint32_t generation() const { return generation_; }

  /// Announces one message to a reader, before it is sent.
  void grant(std::uint32_t reader) const;
  /// The message was not sent.
  void revoke(std::uint32_t reader) const;
  /// The connection to the reader broke: what was on its way is lost. `is_dead`: its process has
  /// ended, so what it held is free too.
  void lose_reader(std::uint32_t reader, bool is_dead) const;
  /// True when messages are on their way.
  bool has_grants() const;
  /// Messages on their way to a reader.
  std::uint32_t granted(std::uint32_t reader) const;
  /// True when no reader has anything of it.
  bool is_free() const;
  /// Begins a new use. Only when is_free().
  void begin_use();

 private:
  SlabHeader& header() const { return *reinterpret_cast<SlabHeader*>(base_); }

  const std::size_t capacity_;
  int file_ = -1;
  std::uint8_t* base_ = nullptr;
  std::uint32_t generation_ = 0;
};

/// A node's slabs. They are used again as soon as nobody has their content any more, and returned
/// to the system when they have rested for a while. Thread-safe.
class SlabPool : public std::enable_shared_from_this<SlabPool> {
 public:
  /// `max_bytes`: of all slabs together.
  explicit SlabPool(std::size_t max_bytes) : max_bytes_(max_bytes) {}

  /// A slab with room for `bytes`, in use until the last copy of the pointer goes and every reader
  /// has given its leases back; null when that would be more memory than allowed or there is.
  std::shared_ptr<Slab> acquire(std::size_t bytes);

  void lose_reader(std::uint32_t reader, bool is_dead);
  bool has_grants() const;
  /// Messages on their way to a reader.
  std::size_t granted(std::uint32_t reader) const;
  /// [bytes] of all slabs, in use or not.
  std::size_t bytes() const;
  /// Lets slabs go that have not been used for `age`.
  void trim(std::chrono::steady_clock::duration age);

 private:
  struct Entry {
    std::unique_ptr<Slab> slab;
    bool held = false;  // by this process
    std::chrono::steady_clock::time_point last_use;
  };

  void release(const Slab* slab);
  Slab* free_slab(std::size_t bytes);
  bool make_room(std::size_t bytes);

  const std::size_t max_bytes_;
  mutable std::mutex mutex_;
  std::vector<Entry> entries_;
  std::size_t bytes_ = 0;
};

}  // namespace prehend::graph

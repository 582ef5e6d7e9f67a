#include "prehend/graph/link/slab.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <new>
#include <random>
#include <system_error>

namespace prehend::graph {
namespace {

constexpr std::uint64_t kOneGranted = std::uint64_t{1} << 16;
constexpr std::uint64_t kGrantedMask = std::uint64_t{0xffff} << 16;
constexpr std::uint64_t kCountsMask = 0xffffffff;

constexpr std::size_t kSmallestSlab = std::size_t{64} << 10;

// The next of 1, 1.5, 2, 3, 4, 6, … times the smallest, so that similar sizes share slabs.
std::size_t size_class(std::size_t bytes) {
  std::size_t size = kSmallestSlab;
  while (size < bytes) {
    if (size + size / 2 >= bytes) return size + size / 2;
    size *= 2;
  }
  return size;
}

std::uint64_t random_id() {
  static thread_local std::mt19937_64 generator{std::random_device()()};
  return generator();
}

[[noreturn]] void fail(const char* what) {
  throw std::system_error(errno, std::generic_category(), what);
}

}  // namespace

Slab::Slab(std::size_t capacity) : capacity_(capacity) {
  file_ = ::memfd_create("prehend-slab", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (file_ < 0) fail("memfd_create");
  const std::size_t size = kSlabHeaderBytes + capacity;
  void* memory = MAP_FAILED;
  // Sealed against shrinking, so that no reader can be made to fault.
  if (::ftruncate(file_, static_cast<off_t>(size)) == 0 &&
      ::fcntl(file_, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) == 0) {
    memory = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, file_, 0);
  }
  if (memory == MAP_FAILED) {
    const int error = errno;
    ::close(file_);
    errno = error;
    fail("shared memory");
  }
  base_ = static_cast<std::uint8_t*>(memory);
  auto* header = new (base_) SlabHeader;
  header->id = random_id();
  header->capacity = capacity;
}

Slab::~Slab() {
  header().retired.store(1, std::memory_order_release);
  ::munmap(base_, kSlabHeaderBytes + capacity_);
  ::close(file_);
}

void Slab::grant(std::uint32_t reader) const {
  header().leases[reader].fetch_add(kOneGranted, std::memory_order_acq_rel);
}

void Slab::revoke(std::uint32_t reader) const {
  header().leases[reader].fetch_sub(kOneGranted, std::memory_order_acq_rel);
}

void Slab::lose_reader(std::uint32_t reader, bool is_dead) const {
  auto& word = header().leases[reader];
  const std::uint64_t lost = is_dead ? kCountsMask : kGrantedMask;
  word.fetch_and(~lost, std::memory_order_acq_rel);
}

bool Slab::has_grants() const {
  return std::any_of(std::begin(header().leases), std::end(header().leases), [](const auto& word) {
    return (word.load(std::memory_order_acquire) & kGrantedMask) != 0;
  });
}

std::uint32_t Slab::granted(std::uint32_t reader) const {
  const std::uint64_t word = header().leases[reader].load(std::memory_order_acquire);
  return static_cast<std::uint32_t>((word & kGrantedMask) >> 16);
}

bool Slab::is_free() const {
  return std::all_of(std::begin(header().leases), std::end(header().leases), [](const auto& word) {
    return (word.load(std::memory_order_acquire) & kCountsMask) == 0;
  });
}

void Slab::begin_use() {
  ++generation_;
  for (auto& word : header().leases) {
    word.store(std::uint64_t{generation_} << 32, std::memory_order_release);
  }
}

std::shared_ptr<Slab> SlabPool::acquire(std::size_t bytes) {
  const std::lock_guard lock(mutex_);
  Slab* slab = free_slab(bytes);
  if (!slab) {
    const std::size_t capacity = size_class(bytes);
    if (!make_room(capacity)) return nullptr;
    try {
      entries_.push_back({std::make_unique<Slab>(capacity), true, {}});
    } catch (const std::system_error&) {
      return nullptr;  // no memory or no file descriptors left: the message goes inline
    }
    bytes_ += capacity;
    slab = entries_.back().slab.get();
  }
  slab->begin_use();
  return std::shared_ptr<Slab>(
      slab, [pool = shared_from_this()](const Slab* used) { pool->release(used); });
}

// The one used last of those that fit well: its memory is the most likely to be in the cache.
Slab* SlabPool::free_slab(std::size_t bytes) {
  Entry* best = nullptr;
  for (Entry& entry : entries_) {
    const std::size_t capacity = entry.slab->capacity();
    const bool fits = capacity >= bytes && (capacity / 4 <= bytes || capacity == kSmallestSlab);
    if (entry.held || !fits || !entry.slab->is_free()) continue;
    if (!best || entry.last_use > best->last_use) best = &entry;
  }
  if (!best) return nullptr;
  best->held = true;
  return best->slab.get();
}

bool SlabPool::make_room(std::size_t bytes) {
  std::erase_if(entries_, [&](const Entry& entry) {
    if (bytes_ + bytes <= max_bytes_ || entry.held || !entry.slab->is_free()) return false;
    bytes_ -= entry.slab->capacity();
    return true;
  });
  return bytes_ + bytes <= max_bytes_;
}

void SlabPool::release(const Slab* slab) {
  const std::lock_guard lock(mutex_);
  for (Entry& entry : entries_) {
    if (entry.slab.get() != slab) continue;
    entry.held = false;
    entry.last_use = std::chrono::steady_clock::now();
  }
}

void SlabPool::lose_reader(std::uint32_t reader, bool is_dead) {
  const std::lock_guard lock(mutex_);
  for (const Entry& entry : entries_) entry.slab->lose_reader(reader, is_dead);
}

bool SlabPool::has_grants() const {
  const std::lock_guard lock(mutex_);
  return std::any_of(entries_.begin(), entries_.end(),
                     [](const Entry& entry) { return entry.slab->has_grants(); });
}

std::size_t SlabPool::granted(std::uint32_t reader) const {
  const std::lock_guard lock(mutex_);
  std::size_t messages = 0;
  for (const Entry& entry : entries_) messages += entry.slab->granted(reader);
  return messages;
}

std::size_t SlabPool::bytes() const {
  const std::lock_guard lock(mutex_);
  return bytes_;
}

void SlabPool::trim(std::chrono::steady_clock::duration age) {
  const auto oldest = std::chrono::steady_clock::now() - age;
  const std::lock_guard lock(mutex_);
  std::erase_if(entries_, [&](const Entry& entry) {
    if (entry.held || entry.last_use > oldest || !entry.slab->is_free()) return false;
    bytes_ -= entry.slab->capacity();
    return true;
  });
}

}  // namespace prehend::graph

#pragma once

#include <cstddef>
#include <memory>
#include <memory_resource>
#include <utility>

namespace prehend::graph {

/// What a batch of messages is given to begin with: enough for about a hundred [bytes].
inline constexpr std::size_t kBatchRoom = std::size_t{32} << 10;

/// Room for objects that are made together by one thread: taking some costs no call of the heap,
/// and all of it is given back with the last object. An allocator for std::allocate_shared.
///
/// Most of the cost of a small message is the heap: what one thread takes and another gives back
/// never comes from a thread's own store of free pieces.
template <class T>
class BatchMemory {
 public:
  using value_type = T;

  /// Room for about `bytes`; it grows when that is too little.
  explicit BatchMemory(std::size_t bytes)
      : resource_(std::make_shared<std::pmr::monotonic_buffer_resource>(bytes)) {}
  template <class Other>
  BatchMemory(const BatchMemory<Other>& other) : resource_(other.resource()) {}

  T* allocate(std::size_t count) {
    return static_cast<T*>(resource_->allocate(count * sizeof(T), alignof(T)));
  }
  void deallocate(T*, std::size_t) {}  // with the last one

  const std::shared_ptr<std::pmr::monotonic_buffer_resource>& resource() const { return resource_; }
  template <class Other>
  friend bool operator==(const BatchMemory& a, const BatchMemory<Other>& b) {
    return a.resource() == b.resource();
  }

 private:
  std::shared_ptr<std::pmr::monotonic_buffer_resource> resource_;
};

}  // namespace prehend::graph

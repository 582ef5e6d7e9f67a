#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <zmq.hpp>

namespace prehend::graph {

/// Bytes that do not change any more, and what keeps them alive: a string, a vector, a frame, a
/// piece of shared memory. Cheap to copy; copies share the bytes.
class SharedBytes {
 public:
  SharedBytes() = default;
  /// Views `size` bytes that live as long as `owner`.
  SharedBytes(const void* data, std::size_t size, std::shared_ptr<const void> owner)
      : data_(static_cast<const std::uint8_t*>(data)), size_(size), owner_(std::move(owner)) {}

  static SharedBytes copy_of(const void* data, std::size_t size);
  static SharedBytes of(std::string&& bytes);
  static SharedBytes of(std::vector<std::uint8_t>&& bytes);
  static SharedBytes of(zmq::message_t&& frame);

  const std::uint8_t* data() const { return data_; }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  std::span<const std::uint8_t> span() const { return {data_, size_}; }
  const std::shared_ptr<const void>& owner() const { return owner_; }
  /// A part, which must lie within.
  SharedBytes slice(std::size_t offset, std::size_t size) const {
    return SharedBytes(data_ + offset, size, owner_);
  }

  /// A frame of the same bytes: shared when that is cheaper than copying them.
  zmq::message_t to_frame() const;

 private:
  const std::uint8_t* data_ = nullptr;
  std::size_t size_ = 0;
  std::shared_ptr<const void> owner_;
};

}  // namespace prehend::graph

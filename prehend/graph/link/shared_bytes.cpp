#include "prehend/graph/link/shared_bytes.h"

#include <cstring>
#include <utility>

namespace prehend::graph {
namespace {

// Frames larger than this share memory with their source; smaller ones are cheaper to copy.
constexpr std::size_t kSharingPays = 1024;

template <class Container>
SharedBytes keep(Container&& bytes) {
  auto kept = std::make_shared<std::decay_t<Container>>(std::forward<Container>(bytes));
  const void* data = kept->data();
  const std::size_t size = kept->size();
  return SharedBytes(data, size, std::move(kept));
}

}  // namespace

SharedBytes SharedBytes::copy_of(const void* data, std::size_t size) {
  if (size == 0) return {};
  auto kept = std::make_shared_for_overwrite<std::uint8_t[]>(size);
  std::memcpy(kept.get(), data, size);
  const std::uint8_t* begin = kept.get();
  return SharedBytes(begin, size, std::shared_ptr<const void>(std::move(kept), begin));
}

SharedBytes SharedBytes::of(std::string&& bytes) { return keep(std::move(bytes)); }

SharedBytes SharedBytes::of(std::vector<std::uint8_t>&& bytes) { return keep(std::move(bytes)); }

SharedBytes SharedBytes::of(zmq::message_t&& frame) {
  if (frame.size() == 0) return {};
  return keep(std::move(frame));
}

zmq::message_t SharedBytes::to_frame() const {
  if (size_ < kSharingPays || !owner_) return zmq::message_t(data_, size_);
  auto* kept = new std::shared_ptr<const void>(owner_);
  return zmq::message_t(
      const_cast<std::uint8_t*>(data_), size_,
      [](void*, void* hint) { delete static_cast<std::shared_ptr<const void>*>(hint); }, kept);
}

}  // namespace prehend::graph

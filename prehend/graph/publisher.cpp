#include "prehend/graph/publisher.h"

#include <google/protobuf/message.h>

#include <new>
#include <stdexcept>

#include "prehend/graph/link/publisher_core.h"

namespace prehend::graph {
namespace {

const std::shared_ptr<PublisherCore>& checked(const std::shared_ptr<PublisherCore>& core) {
  if (!core) throw std::logic_error("this publisher was not made by Node::advertise");
  return core;
}

}  // namespace

bool PublisherBase::wait_for_subscribers(std::size_t count,
                                         std::chrono::nanoseconds timeout) const {
  return checked(core_)->wait_for_subscribers(count, timeout);
}

std::size_t PublisherBase::subscriber_count() const {
  return checked(core_)->statistics().subscribers;
}

PublisherStatistics PublisherBase::statistics() const { return checked(core_)->statistics(); }

const std::string& PublisherBase::topic() const { return checked(core_)->topic(); }

LoanedPayload PublisherBase::loan(std::size_t bytes) const {
  const auto& core = checked(core_);
  if (bytes > static_cast<std::size_t>(kMaxFrameBytes)) {
    throw std::length_error("topic " + core->topic() + ": a payload of " + std::to_string(bytes) +
                            " bytes is larger than a message may be (" +
                            std::to_string(kMaxFrameBytes) + ")");
  }
  LoanedPayload loan;
  std::uint8_t* data = nullptr;
  if ((loan.slab_ = core->slab_for(bytes))) {
    data = loan.slab_->data();
    loan.owner_ = loan.slab_;
  } else {
    auto heap = std::make_shared_for_overwrite<std::uint8_t[]>(bytes);
    data = heap.get();
    loan.owner_ = std::move(heap);
  }
  loan.bytes_ = {data, bytes};
  return loan;
}

void PublisherBase::publish_copy(const google::protobuf::Message& message) const {
  checked(core_)->publish_copy(message);
}

void PublisherBase::publish_moved(google::protobuf::Message& message) const {
  checked(core_)->publish_moved(message);
}

void PublisherBase::publish_payload(google::protobuf::Message& message,
                                    std::vector<std::uint8_t>&& payload) const {
  checked(core_)->publish_apart(message, SharedBytes::of(std::move(payload)), nullptr);
}

void PublisherBase::publish_loaned(google::protobuf::Message& message,
                                   LoanedPayload&& payload) const {
  const auto& core = checked(core_);
  SharedBytes bytes(payload.bytes_.data(), payload.bytes_.size(), std::move(payload.owner_));
  payload.bytes_ = {};
  core->publish_apart(message, std::move(bytes), std::move(payload.slab_));
}

void PublisherBase::publish_shared(std::shared_ptr<const google::protobuf::Message> message) const {
  checked(core_)->publish_shared(std::move(message));
}

void PublisherBase::publish_each(std::span<const google::protobuf::Message* const> messages) const {
  checked(core_)->publish_each(messages);
}

void PublisherBase::publish_encoded(std::string bytes, std::int64_t stamp) const {
  checked(core_)->publish(encode_raw(std::move(bytes)), stamp);
}

}  // namespace prehend::graph

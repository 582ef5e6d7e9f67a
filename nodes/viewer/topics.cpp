#include "nodes/viewer/topics.h"

#include <algorithm>
#include <utility>

namespace prehend::nodes {
namespace {

constexpr std::size_t kMostKeptBytes = std::size_t{64} << 20;  // of each topic
// Messages that wait for this node: what viewers cannot take is left out later, by them.
constexpr std::size_t kQueueDepth = 256;
constexpr std::size_t kQueueBytes = std::size_t{64} << 20;

}  // namespace

Topics::Listening& Topics::Listening::operator=(Listening&& other) noexcept {
  if (this == &other) return *this;
  end();
  topics_ = std::exchange(other.topics_, nullptr);
  topic_ = std::move(other.topic_);
  id_ = other.id_;
  return *this;
}

void Topics::Listening::end() {
  if (Topics* topics = std::exchange(topics_, nullptr)) topics->end(topic_, id_);
}

void Topics::keep(Source& source, const Message& message) {
  const std::string& sender = message->info.sender.str();
  const auto is_its = [&](const Message& one) { return one->info.sender == sender; };
  const auto forget = [&](std::deque<Message>::iterator one) {
    source.kept_bytes -= (*one)->bytes.size();
    source.kept.erase(one);
  };
  source.kept.push_back(message);
  source.kept_bytes += message->bytes.size();
  const auto count = std::count_if(source.kept.begin(), source.kept.end(), is_its);
  if (static_cast<std::size_t>(count) > source.latched) {
    forget(std::find_if(source.kept.begin(), source.kept.end(), is_its));
  }
  while (source.kept_bytes > kMostKeptBytes && source.kept.size() > 1) {
    forget(source.kept.begin());
  }
}

void Topics::deliver(Source& source, const Message& message) {
  std::vector<std::shared_ptr<Listener>> listeners;
  {
    const std::lock_guard lock(source.mutex);
    if (source.latched > 0) keep(source, message);
    for (const auto& [id, listener] : source.listeners) listeners.push_back(listener);
  }
  for (const auto& listener : listeners) {
    const std::lock_guard lock(listener->mutex);
    if (listener->callback) listener->callback(message);
  }
}

Topics::Listening Topics::listen(const std::string& topic, std::size_t latched, Callback callback) {
  const std::uint64_t id = ++last_id_;
  auto listener = std::make_shared<Listener>();
  listener->callback = std::move(callback);
  auto& source = sources_[topic];
  if (source) {
    const std::lock_guard in_order(listener->mutex);  // what comes meanwhile, comes after these
    std::deque<Message> kept;
    {
      const std::lock_guard lock(source->mutex);
      source->latched = std::max(source->latched, latched);
      source->listeners[id] = listener;
      kept = source->kept;
    }
    for (const Message& message : kept) listener->callback(message);
    return {this, topic, id};
  }
  source = std::make_shared<Source>();
  source->latched = latched;
  source->listeners[id] = listener;
  auto subscription = node_.subscribe_raw(
      "/" + topic,  // with "//" before it, a name is that of the whole graph
      graph::QoS::queue(kQueueDepth, kQueueBytes),  // latched messages come all the same
      [weak = std::weak_ptr(source)](const graph::RawMessage& message) {
        if (const auto its = weak.lock()) {
          deliver(*its, std::make_shared<const graph::RawMessage>(message));
        }
      });
  source->subscription = std::move(subscription);
  return {this, topic, id};
}

void Topics::end(const std::string& topic, std::uint64_t id) {
  const auto found = sources_.find(topic);
  if (found == sources_.end()) return;
  const std::shared_ptr<Source> source = found->second;
  std::shared_ptr<Listener> listener;
  bool was_last = false;
  {
    const std::lock_guard lock(source->mutex);
    listener = source->listeners[id];
    source->listeners.erase(id);
    was_last = source->listeners.empty();
  }
  if (listener) {
    const std::lock_guard lock(listener->mutex);
    listener->callback = nullptr;
  }
  if (was_last) sources_.erase(found);  // waits for a callback that runs
}

}  // namespace prehend::nodes

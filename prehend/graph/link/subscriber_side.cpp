#include <fmt/format.h>

#include "prehend/graph/link/topic_sides.h"

namespace prehend::graph {
namespace {

using msgs::graph::NodeRecord;
using msgs::graph::PeerMessage;
using msgs::graph::TopicEnd;

const TopicEnd* publisher_of(const NodeRecord& node, const std::string& topic) {
  for (const TopicEnd& end : node.publishers()) {
    if (end.topic() == topic) return &end;
  }
  return nullptr;
}

}  // namespace

void SubscriberSide::add(const std::shared_ptr<SubscriptionCore>& core) {
  Entry& entry = entries_[core->id()];
  entry.core = core;
  for (const auto& [instance, node] : registry_.nodes()) meet(entry, node);
}

void SubscriberSide::remove(std::uint64_t id) {
  const auto found = entries_.find(id);
  if (found == entries_.end()) return;
  log_losses(found->second, true);
  PeerMessage message;
  message.mutable_unsubscribe()->set_topic(found->second.core->topic());
  message.mutable_unsubscribe()->set_subscription(id);
  for (const auto& [server, source] : found->second.sources) {
    channels_.send_to_server(server, message);
  }
  entries_.erase(found);
}

void SubscriberSide::meet(const NodeRecord& node) {
  for (auto& [id, entry] : entries_) meet(entry, node);
}

void SubscriberSide::meet(Entry& entry, const NodeRecord& node) {
  const TopicEnd* publisher = publisher_of(node, entry.core->topic());
  const auto source = entry.sources.find(node.instance());
  if (!publisher) {
    if (source == entry.sources.end() || source->second.leaving) return;
    source->second.leaving = true;
    source->second.leaving_since = std::chrono::steady_clock::now();
    return refresh_count(entry);
  }
  if (source != entry.sources.end() && source->second.publisher_id == publisher->id()) return;
  if (!accept_schema(entry, node, *publisher)) return;
  Source& fresh = entry.sources[node.instance()] = Source();
  fresh.publisher_id = publisher->id();
  channels_.connect(node.instance(), node.endpoint());
  request(entry, node.instance());
}

bool SubscriberSide::accept_schema(Entry& entry, const NodeRecord& node,
                                   const TopicEnd& publisher) {
  const SubscriptionCore& core = *entry.core;
  if (core.schema_hash() == 0 || core.schema_hash() == publisher.schema_hash()) return true;
  if (!entry.refused.insert({node.instance(), publisher.id()}).second) return false;
  const std::string what =
      core.schema()->name == publisher.schema_name()
          ? "another definition of " + publisher.schema_name()
          : publisher.schema_name() + ", this node expects " + core.schema()->name;
  const std::string text = fmt::format("topic {}: node '{}' publishes {}; nothing of it is taken",
                                       core.topic(), node.name(), what);
  entry.core->count([](SubscriptionStatistics& s) { ++s.refused_publishers; });
  link_.report(Health::kError, text);
  return false;
}

void SubscriberSide::request(const Entry& entry, const std::string& server) {
  PeerMessage message;
  auto& subscribe = *message.mutable_subscribe();
  subscribe.set_topic(entry.core->topic());
  subscribe.set_subscription(entry.core->id());
  subscribe.set_publisher(entry.sources.at(server).publisher_id);
  subscribe.set_schema_hash(entry.core->schema_hash());
  if (entry.core->schema()) subscribe.set_schema_name(entry.core->schema()->name);
  subscribe.set_policy(to_wire_policy(entry.core->qos().policy));
  subscribe.set_depth(entry.core->qos().depth);
  subscribe.set_wants_schema(!entry.core->schema());
  if (!channels_.send_to_server(server, message)) {
    link_.log(LogLevel::kError,
              fmt::format("topic {}: cannot reach {}", entry.core->topic(), server));
  }
}

void SubscriberSide::lose_server(const std::string& server) {
  for (auto& [id, entry] : entries_) {
    if (entry.sources.erase(server)) refresh_count(entry);
  }
}

void SubscriberSide::forget_withdrawn() {
  const auto before = std::chrono::steady_clock::now() - kLastMessages;
  for (auto& [id, entry] : entries_) {
    std::erase_if(entry.sources, [before](const auto& source) {
      return source.second.leaving && source.second.leaving_since < before;
    });
  }
}

void SubscriberSide::rejoin(const std::string& server) {
  for (auto& [id, entry] : entries_) {
    if (!entry.sources.count(server)) continue;
    link_.log(LogLevel::kWarning,
              fmt::format("topic {}: connection to {} came back", entry.core->topic(), server));
    request(entry, server);
  }
}

void SubscriberSide::rejoin_all() {
  for (auto& [id, entry] : entries_) {
    for (const auto& [server, source] : entry.sources) {
      if (!source.leaving) request(entry, server);
    }
  }
}

void SubscriberSide::take_subscribed(const std::string& server,
                                     const PeerMessage::Subscribed& answer) {
  const auto found = entries_.find(answer.subscription());
  if (found == entries_.end()) return;
  Entry& entry = found->second;
  const auto source = entry.sources.find(server);
  if (source == entry.sources.end()) return;
  if (!answer.error().empty()) {  // a withdrawal or change that the registry will tell as well
    link_.log(LogLevel::kWarning, answer.error());
    return;
  }
  if (entry.core->qos().policy == QoS::Policy::kLatched &&
      answer.policy() != msgs::graph::LATCHED) {
    link_.log(LogLevel::kWarning,
              fmt::format("topic {}: this node subscribes latched, but {} does not keep messages "
                          "for late subscribers",
                          entry.core->topic(), server));
  }
  if (!entry.core->schema()) {
    source->second.schema = std::make_shared<Schema>(
        Schema{answer.schema().name(), answer.schema().hash(), answer.schema().descriptor_set()});
  }
  const bool rejoined = source->second.joined;
  source->second.joined = true;
  source->second.in_history = true;
  if (!rejoined) source->second.expected = answer.next_sequence();
  refresh_count(entry);
}

void SubscriberSide::take_history_end(const std::string& server,
                                      const PeerMessage::HistoryEnd& end) {
  const auto found = entries_.find(end.subscription());
  if (found == entries_.end()) return;
  const auto source = found->second.sources.find(server);
  if (source != found->second.sources.end()) source->second.in_history = false;
}

bool SubscriberSide::take_message(const std::string& server, Frames& frames) {
  const std::string topic = frames[0].to_string();
  msgs::graph::Envelope envelope;
  if (!envelope.ParseFromArray(frames[1].data(), static_cast<int>(frames[1].size())) ||
      envelope.sequence() == 0) {
    return false;
  }
  const auto info = std::make_shared<MessageInfo>(
      MessageInfo{topic, envelope.sequence(), envelope.stamp(), envelope.publish_time(),
                  envelope.sender(), envelope.schema_hash()});
  MessageFrames content{std::move(frames[2]), std::move(frames[3]), std::move(frames[4])};
  // While one subscription gets its history, what comes on the topic is for it alone.
  const auto is_for = [&](const Entry& entry, bool history) {
    const auto source = entry.sources.find(server);
    return entry.core->topic() == topic && source != entry.sources.end() && source->second.joined &&
           source->second.in_history == history;
  };
  bool history = false;
  for (const auto& [id, entry] : entries_) history = history || is_for(entry, true);
  for (auto& [id, entry] : entries_) {
    if (!is_for(entry, history)) continue;
    Source& source = entry.sources.at(server);
    const std::uint64_t expected_hash =
        entry.core->schema() ? entry.core->schema_hash() : source.schema->hash;
    if (envelope.schema_hash() != expected_hash) {
      entry.core->count([](SubscriptionStatistics& s) { ++s.malformed; });
      continue;
    }
    if (envelope.sequence() < source.expected) continue;  // had it before the connection broke
    follow_sequence(entry, source, envelope.sequence());
    entry.core->push({content.share(), info, source.schema});
  }
  return true;
}

void SubscriberSide::follow_sequence(Entry& entry, Source& source, std::uint64_t sequence) {
  if (source.expected != 0 && sequence > source.expected) {
    const std::uint64_t missed = sequence - source.expected;
    entry.core->count([missed](SubscriptionStatistics& s) { s.missed += missed; });
  }
  source.expected = sequence + 1;
}

void SubscriberSide::refresh_count(Entry& entry) {
  std::size_t joined = 0;
  for (const auto& [server, source] : entry.sources)
    joined += source.joined && !source.leaving ? 1 : 0;
  entry.core->count([joined](SubscriptionStatistics& s) { s.publishers = joined; });
}

void SubscriberSide::log_losses(bool at_any_rate) {
  for (auto& [id, entry] : entries_) log_losses(entry, at_any_rate);
}

void SubscriberSide::log_losses(Entry& entry, bool at_any_rate) {
  const SubscriptionStatistics statistics = entry.core->statistics();
  const std::string& topic = entry.core->topic();
  if (entry.drop_line.is_due(statistics.dropped, at_any_rate)) {
    link_.log(LogLevel::kWarning,
              fmt::format("topic {}: {} messages dropped in all, as this node's callback is slower "
                          "than they come (queue of {})",
                          topic, statistics.dropped, entry.core->qos().depth));
  }
  if (entry.gap_line.is_due(statistics.missed, at_any_rate)) {
    link_.log(LogLevel::kWarning,
              fmt::format("topic {}: {} messages never came, in all", topic, statistics.missed));
  }
  if (entry.malformed_line.is_due(statistics.malformed, at_any_rate)) {
    link_.log(LogLevel::kError, fmt::format("topic {}: {} damaged messages thrown away, in all",
                                            topic, statistics.malformed));
  }
}

void SubscriberSide::fill(msgs::graph::NodeRecord& record) const {
  for (const auto& [id, entry] : entries_) {
    auto& end = *record.add_subscribers();
    end.set_topic(entry.core->topic());
    if (entry.core->schema()) {
      end.set_schema_name(entry.core->schema()->name);
      end.set_schema_hash(entry.core->schema()->hash);
    }
    end.set_policy(to_wire_policy(entry.core->qos().policy));
    end.set_depth(entry.core->qos().depth);
    end.set_id(id);
  }
}

}  // namespace prehend::graph

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "prehend/graph/link/local_nodes.h"
#include "prehend/graph/link/topic_sides.h"

namespace prehend::graph {
namespace {

// Lost sources that are remembered for the case that they come back.
constexpr std::size_t kMaxLostSources = 1000;

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
  entry.topic = SharedName(core->topic());
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
    const LocalNode node = LocalNodes::of_this_process().find(server);
    if (link_.use_pointers && node.loop) {  // as the request went, answered yet or not
      node.loop->post([publishers = node.publishers, client = link_.instance, message] {
        publishers->leave(client, message.unsubscribe());
      });
    } else {
      channels_.send_to_server(server, message);
    }
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
  const auto lost = entry.lost_sources.find(node.instance());
  if (lost != entry.lost_sources.end()) {
    if (lost->second.first == publisher->id()) fresh.expected = lost->second.second;
    entry.lost_sources.erase(lost);
  }
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
  link_.hold_against(node.instance(), text);
  return false;
}

PeerMessage::Subscribe SubscriberSide::subscribe_request(const Entry& entry,
                                                         const std::string& server) const {
  const Source& source = entry.sources.at(server);
  PeerMessage::Subscribe request;
  request.set_topic(entry.core->topic());
  request.set_subscription(entry.core->id());
  request.set_publisher(source.publisher_id);
  request.set_schema_hash(entry.core->schema_hash());
  if (entry.core->schema()) request.set_schema_name(entry.core->schema()->name);
  request.set_policy(to_wire_policy(entry.core->qos().policy));
  request.set_depth(entry.core->qos().depth);
  request.set_wants_schema(!entry.core->schema());
  request.set_pid(::getpid());
  const auto node = registry_.nodes().find(server);
  request.set_accepts_slab(link_.use_slab && !source.inline_only &&
                           node != registry_.nodes().end() &&
                           can_open_slabs_of(node->second.pid(), node->second.process_space()));
  return request;
}

void SubscriberSide::request(const Entry& entry, const std::string& server) {
  PeerMessage message;
  *message.mutable_subscribe() = subscribe_request(entry, server);
  const LocalNode node = LocalNodes::of_this_process().find(server);
  if (link_.use_pointers && node.loop) {
    node.loop->post([this, node, server, core = entry.core, loop = link_.loop,
                     client = link_.instance, message] {
      PeerMessage::Subscribed answer;
      node.publishers->join_local(core, client, message.subscribe(), answer);
      loop->post([this, server, answer] { take_local(server, answer); });
    });
    return;
  }
  const auto record = registry_.nodes().find(server);
  if (record != registry_.nodes().end()) channels_.connect(server, record->second.endpoint());
  if (!channels_.send_to_server(server, message)) {
    link_.log(LogLevel::kError,
              fmt::format("topic {}: cannot reach {}", entry.core->topic(), server));
  }
}

void SubscriberSide::forget_source(Entry& entry, const std::string& server) {
  const auto source = entry.sources.find(server);
  if (source == entry.sources.end()) return;
  if (source->second.expected != 0) {
    if (entry.lost_sources.size() >= kMaxLostSources) entry.lost_sources.clear();
    entry.lost_sources[server] = {source->second.publisher_id, source->second.expected};
  }
  entry.sources.erase(source);
  refresh_count(entry);
}

void SubscriberSide::lose_server(const std::string& server) {
  slab_places_.erase(server);
  for (auto& [id, entry] : entries_) {
    forget_source(entry, server);
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
  // Also when the subscription has ended: what follows is leased under this number all the same.
  if (answer.slab_reader() != 0) slab_places_[server] = answer.slab_reader();
  const auto found = entries_.find(answer.subscription());
  if (found == entries_.end()) return;
  Entry& entry = found->second;
  const auto source = entry.sources.find(server);
  if (source == entry.sources.end()) return;
  if (!answer.error().empty()) {  // a withdrawal or change that the registry will tell as well
    link_.log(LogLevel::kWarning, answer.error());
    return;
  }
  warn_unless_latched(entry, server, answer);
  if (!entry.core->schema()) {
    source->second.schema = std::make_shared<Schema>(
        Schema{answer.schema().name(), answer.schema().hash(), answer.schema().descriptor_set()});
  }
  source->second.joined = true;
  source->second.in_history = true;
  // On joining anew, what came meanwhile is lost but for the history.
  follow_sequence(entry, source->second, answer.next_sequence());
  refresh_count(entry);
}

void SubscriberSide::take_local(const std::string& server, const PeerMessage::Subscribed& answer) {
  const auto found = entries_.find(answer.subscription());
  if (found == entries_.end()) return;
  const auto source = found->second.sources.find(server);
  if (source == found->second.sources.end()) return;
  if (!answer.error().empty()) {
    link_.log(LogLevel::kWarning, answer.error());
    return;
  }
  warn_unless_latched(found->second, server, answer);
  source->second.joined = true;
  source->second.local = true;
  refresh_count(found->second);
}

void SubscriberSide::warn_unless_latched(const Entry& entry, const std::string& server,
                                         const PeerMessage::Subscribed& answer) {
  if (entry.core->qos().policy != QoS::Policy::kLatched ||
      answer.policy() == msgs::graph::LATCHED) {
    return;
  }
  link_.log(LogLevel::kWarning,
            fmt::format("topic {}: this node subscribes latched, but {} does not keep messages "
                        "for late subscribers",
                        entry.core->topic(), server));
}

void SubscriberSide::take_history_end(const std::string& server,
                                      const PeerMessage::HistoryEnd& end) {
  const auto found = entries_.find(end.subscription());
  if (found == entries_.end()) return;
  const auto source = found->second.sources.find(server);
  if (source != found->second.sources.end()) source->second.in_history = false;
}

std::vector<SubscriberSide::Receiver> SubscriberSide::receivers_of(const std::string& server,
                                                                   const std::string& topic) {
  std::vector<Receiver> receivers;
  bool history = false;
  for (auto& [id, entry] : entries_) {
    if (entry.core->topic() != topic) continue;
    const auto source = entry.sources.find(server);
    if (source == entry.sources.end() || !source->second.joined || source->second.local) continue;
    receivers.push_back({&entry, &source->second});
    history = history || source->second.in_history;
  }
  // While one subscription gets its history, what comes on the topic is for it alone.
  std::erase_if(receivers,
                [history](const Receiver& r) { return r.source->in_history != history; });
  return receivers;
}

bool SubscriberSide::take_message(const std::string& server, Frames& frames) {
  msgs::graph::Envelope envelope;
  if (!envelope.ParseFromArray(frames[1].data(), static_cast<int>(frames[1].size())) ||
      envelope.sequence() == 0) {
    return false;
  }
  auto receivers = receivers_of(server, frames[0].to_string());
  if (frames.size() == 3) {
    return deliver_all(receivers, envelope, SharedBytes::of(std::move(frames[2])));
  }
  EncodedMessage message;
  message.body = SharedBytes::of(std::move(frames[2]));
  message.prefix = SharedBytes::of(std::move(frames[3]));
  message.payload = SharedBytes::of(std::move(frames[4]));
  if (envelope.has_slab() && !open_slab(server, receivers, envelope, message)) return true;
  if (is_consistent(message)) {
    deliver(receivers, envelope, message, nullptr);
    for (const Receiver& r : receivers) r.entry->core->ask_for_callbacks(r.callbacks);
    return true;
  }
  for (const Receiver& r : receivers) {
    follow_sequence(*r.entry, *r.source, envelope.sequence());
    r.source->expected = std::max(r.source->expected, envelope.sequence() + 1);
    r.entry->core->count([](SubscriptionStatistics& s) { ++s.malformed; });
  }
  return true;
}

bool SubscriberSide::deliver_all(std::vector<Receiver>& receivers, msgs::graph::Envelope& envelope,
                                 const SharedBytes& batch) {
  EncodedMessage message;
  const BatchMemory<Content> memory(kBatchRoom);
  const bool good = read_batch(batch, [&](BatchRecord record) {
    envelope.set_stamp(record.stamp);
    envelope.set_publish_time(record.publish_time);
    message.body = std::move(record.encoded);
    deliver(receivers, envelope, message, &memory);
    envelope.set_sequence(envelope.sequence() + 1);
  });
  for (const Receiver& r : receivers) r.entry->core->ask_for_callbacks(r.callbacks);
  return good;
}

bool SubscriberSide::open_slab(const std::string& server, const std::vector<Receiver>& receivers,
                               const msgs::graph::Envelope& envelope, EncodedMessage& message) {
  const auto place = slab_places_.find(server);
  const std::uint32_t reader = place == slab_places_.end() ? 0 : place->second;
  SlabMappings::Lease lease = slabs_.take_lease(envelope.slab(), reader);
  if (lease.bytes) {
    const bool is_body = envelope.slab().part() == msgs::graph::SlabContent::BODY;
    (is_body ? message.body : message.payload) = std::move(*lease.bytes);
    return true;
  }
  for (const Receiver& r : receivers) {
    if (envelope.sequence() < r.source->expected) continue;
    follow_sequence(*r.entry, *r.source, envelope.sequence() + 1);
    if (lease.can_open || r.source->inline_only) continue;
    link_.log(LogLevel::kWarning,
              fmt::format("topic {}: shared memory of {} cannot be opened ({}); a message is lost, "
                          "the next ones come inline",
                          r.entry->core->topic(), server, lease.error));
    r.source->inline_only = true;
    request(*r.entry, server);
  }
  return false;
}

void SubscriberSide::deliver(std::vector<Receiver>& receivers,
                             const msgs::graph::Envelope& envelope, const EncodedMessage& message,
                             const BatchMemory<Content>* batch) {
  std::shared_ptr<const Content> content;
  std::shared_ptr<const MessageInfo> info;
  for (Receiver& r : receivers) {
    Source& source = *r.source;
    SubscriptionCore& core = *r.entry->core;
    const std::uint64_t expected_hash = core.schema() ? core.schema_hash() : source.schema->hash;
    if (envelope.schema_hash() != expected_hash) {
      core.count([](SubscriptionStatistics& s) { ++s.malformed; });
      continue;
    }
    if (envelope.sequence() < source.expected) continue;  // had it before the connection broke
    follow_sequence(*r.entry, source, envelope.sequence());
    source.expected = envelope.sequence() + 1;
    if (!info) {
      content = batch ? std::allocate_shared<Content>(*batch, message)
                      : std::make_shared<Content>(message);
      if (source.sender.str() != envelope.sender()) source.sender = SharedName(envelope.sender());
      MessageInfo facts{r.entry->topic,          envelope.sequence(), envelope.stamp(),
                        envelope.publish_time(), source.sender,       envelope.schema_hash()};
      info = batch ? std::allocate_shared<MessageInfo>(BatchMemory<MessageInfo>(*batch),
                                                       std::move(facts))
                   : std::make_shared<MessageInfo>(std::move(facts));
    }
    r.callbacks += core.put({content, info, source.schema});
  }
}

// What lies between the number expected and `next` never came.
void SubscriberSide::follow_sequence(Entry& entry, Source& source, std::uint64_t next) {
  if (source.expected != 0 && next > source.expected) {
    const std::uint64_t missed = next - source.expected;
    entry.core->count([missed](SubscriptionStatistics& s) { s.missed += missed; });
  }
  source.expected = std::max(source.expected, next);
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

void SubscriberSide::fill(const std::string& server, PeerMessage::DeliveryAnswer& answer) const {
  for (const auto& [id, entry] : entries_) {
    const QoS& qos = entry.core->qos();
    if (!entry.sources.count(server) || qos.policy == QoS::Policy::kLatest) continue;
    auto& queue = *answer.add_queues();
    queue.set_topic(entry.core->topic());
    queue.set_depth(qos.depth);
    queue.set_max_bytes(qos.max_bytes);
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

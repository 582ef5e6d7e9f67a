#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <vector>

#include "prehend/graph/link/local_nodes.h"
#include "prehend/graph/link/topic_sides.h"

namespace prehend::graph {
namespace {

using msgs::graph::PeerMessage;

constexpr auto kOpeningTime = std::chrono::seconds(2);
constexpr std::size_t kOpeningDepth = 10000;

}  // namespace

msgs::graph::QosPolicy to_wire_policy(QoS::Policy policy) {
  switch (policy) {
    case QoS::Policy::kLatest:
      return msgs::graph::LATEST;
    case QoS::Policy::kLatched:
      return msgs::graph::LATCHED;
    case QoS::Policy::kQueue:
      break;
  }
  return msgs::graph::QUEUE;
}

void PublisherSide::add(const std::shared_ptr<PublisherCore>& core) {
  Entry& entry = entries_[core->id()];
  entry.core = core;
  entry.deadline = std::chrono::steady_clock::now() + kOpeningTime;
  drain(core->id());  // published before the loop came to know it
}

void PublisherSide::remove(std::uint64_t id) {
  const auto found = entries_.find(id);
  if (found == entries_.end()) return;
  drain(id);
  log_losses(found->second, true);
  found->second.core->stop();
  found->second.withdrawn = true;  // stays for those who are about to join and miss messages else
  if (!found->second.opening || found->second.history.empty()) entries_.erase(found);
}

void PublisherSide::drain(std::uint64_t id) {
  const auto found = entries_.find(id);
  if (found == entries_.end()) return;
  Entry& entry = found->second;
  auto taken = entry.core->take_outbox();
  entry.last_sequence = taken.last_sequence;
  if (taken.messages.empty()) return;
  const std::vector<OutgoingMessage> messages(std::make_move_iterator(taken.messages.begin()),
                                              std::make_move_iterator(taken.messages.end()));
  for (const auto& [client, subscriptions] : entry.clients) {
    publish_to(client, entry, entry.core->qos(), messages);
  }
  if (!entry.opening && entry.core->qos().policy != QoS::Policy::kLatched) return;
  for (const OutgoingMessage& message : messages) remember(entry, message);
}

void PublisherSide::publish_to(const std::string& client, const Entry& entry, const QoS& qos,
                               std::span<const OutgoingMessage> messages) {
  channels_.publish_to_client(client, slab_readers_.place_of(client),
                              {entry.core->head(), qos, entry.core}, messages);
}

std::set<std::string> PublisherSide::drain_all() {
  std::set<std::string> readers;
  for (const auto& [id, entry] : entries_) {
    drain(id);
    for (const auto& [reader, subscription] : entry.readers) readers.insert(reader);
  }
  return readers;
}

void PublisherSide::remember(Entry& entry, const OutgoingMessage& message) {
  const QoS& qos = entry.core->qos();
  const std::size_t depth = entry.opening ? std::max(qos.depth, kOpeningDepth) : qos.depth;
  entry.history_bytes += message.content->bytes();
  entry.history.push_back(message);
  while (entry.history.size() > depth ||
         (entry.history.size() > 1 && entry.history_bytes > qos.max_bytes)) {
    if (entry.opening && qos.policy == QoS::Policy::kQueue) entry.core->count_dropped(1);
    entry.history_bytes -= entry.history.front().content->bytes();
    entry.history.pop_front();
  }
}

PublisherSide::Entry* PublisherSide::admit(const PeerMessage::Subscribe& request,
                                           PeerMessage::Subscribed& answer) {
  answer.set_topic(request.topic());
  answer.set_subscription(request.subscription());
  const auto found = entries_.find(request.publisher());
  Entry* entry = found == entries_.end() ? nullptr : &found->second;
  if (!entry || entry->core->topic() != request.topic()) {
    answer.set_error("topic " + request.topic() + " is not published by node '" + link_.node_name +
                     "' any more");
    return nullptr;
  }
  if (request.schema_hash() != 0 && request.schema_hash() != entry->core->schema()->hash) {
    answer.set_error(fmt::format("topic {} carries {} of another definition or type than {}",
                                 request.topic(), entry->core->schema()->name,
                                 request.schema_name()));
    return nullptr;
  }
  entry->core->set_outbox_use(true, entry->slab_readers);
  drain(entry->core->id());  // what was published before the join is history
  const Schema& schema = *entry->core->schema();
  answer.mutable_schema()->set_name(schema.name);
  answer.mutable_schema()->set_hash(schema.hash);
  if (request.wants_schema()) answer.mutable_schema()->set_descriptor_set(schema.descriptor_set);
  answer.set_policy(to_wire_policy(entry->core->qos().policy));
  return entry;
}

// How many messages of the past a new reader gets.
std::size_t PublisherSide::history_for(const Entry& entry,
                                       const PeerMessage::Subscribe& request) const {
  return entry.opening ? entry.history.size()
                       : std::min<std::size_t>(entry.history.size(), request.depth());
}

void PublisherSide::join(const std::string& client, const PeerMessage::Subscribe& request) {
  PeerMessage message;
  auto& answer = *message.mutable_subscribed();
  Entry* entry = admit(request, answer);
  if (!entry) {
    channels_.send_to_client(client, message);
    return;
  }
  const std::size_t history = history_for(*entry, request);
  answer.set_next_sequence(entry->last_sequence + 1 - history);
  if (request.accepts_slab()) {
    answer.set_slab_reader(slab_readers_.join(client, request.pid()));
  } else {
    slab_readers_.lose(client);
  }
  if (!channels_.send_to_client(client, message)) return refresh_readers(*entry);
  QoS all = entry->core->qos();  // history was bounded when it was kept
  all.depth = std::max(all.depth, kOpeningDepth);
  const std::vector<OutgoingMessage> past(
      entry->history.end() - static_cast<std::ptrdiff_t>(history), entry->history.end());
  publish_to(client, *entry, all, past);
  PeerMessage end;
  end.mutable_history_end()->set_topic(request.topic());
  end.mutable_history_end()->set_subscription(request.subscription());
  channels_.send_to_client(client, end);
  if (entry->readers.insert({client, request.subscription()}).second) ++entry->clients[client];
  refresh_readers(*entry);
  check_opening();
}

void PublisherSide::join_local(const std::shared_ptr<SubscriptionCore>& subscription,
                               const std::string& client, const PeerMessage::Subscribe& request,
                               PeerMessage::Subscribed& answer) {
  Entry* entry = admit(request, answer);
  if (!entry) return;
  const bool has_past = entry->opening || entry->core->qos().policy == QoS::Policy::kLatched;
  entry->core->add_local(subscription, has_past ? &entry->history : nullptr,
                         entry->opening ? kOpeningDepth : request.depth());
  entry->readers.insert({client, request.subscription()});
  refresh_readers(*entry);
  check_opening();
}

void PublisherSide::refresh_readers(Entry& entry) {
  entry.slab_readers =
      std::any_of(entry.clients.begin(), entry.clients.end(),
                  [this](const auto& client) { return slab_readers_.place_of(client.first) != 0; });
  const bool keeps =
      entry.opening || !entry.clients.empty() || entry.core->qos().policy == QoS::Policy::kLatched;
  entry.core->set_outbox_use(keeps, entry.slab_readers);
  entry.core->set_subscribers(entry.readers.size());  // last: who waited for it may loan at once
}

void PublisherSide::leave(const std::string& client, const PeerMessage::Unsubscribe& request) {
  for (auto& [id, entry] : entries_) {
    if (entry.core->topic() == request.topic()) {
      erase_reader(entry, {client, request.subscription()});
    }
  }
}

void PublisherSide::lose_client(const std::string& client) {
  if (LocalNodes::of_this_process().find(client).loop) return;  // only the registry has lost it
  slab_readers_.lose(client);
  for (auto& [id, entry] : entries_) {
    std::vector<std::pair<std::string, std::uint64_t>> lost;
    for (const auto& reader : entry.readers) {
      if (reader.first == client) lost.push_back(reader);
    }
    for (const auto& reader : lost) erase_reader(entry, reader);
  }
  check_opening();
}

void PublisherSide::erase_reader(Entry& entry,
                                 const std::pair<std::string, std::uint64_t>& reader) {
  if (!entry.readers.erase(reader)) return;
  const auto client = entry.clients.find(reader.first);
  if (client == entry.clients.end()) {
    entry.core->remove_local(reader.second);
  } else if (--client->second == 0) {
    entry.clients.erase(client);
  }
  refresh_readers(entry);
}

void PublisherSide::record_sent(std::uint64_t version) {
  for (auto& [id, entry] : entries_) {
    if (entry.version == 0) entry.version = version;
  }
}

void PublisherSide::registry_knows(std::uint64_t version) {
  for (auto& [id, entry] : entries_) {
    if (entry.version != 0 && entry.version <= version) entry.known = true;
  }
  check_opening();
}

bool PublisherSide::all_have_joined(const Entry& entry) const {
  for (const auto& [instance, node] : registry_.nodes()) {
    for (const auto& end : node.subscribers()) {
      const bool fits = end.topic() == entry.core->topic() &&
                        (end.schema_hash() == 0 || end.schema_hash() == entry.core->schema()->hash);
      if (fits && !entry.readers.count({instance, end.id()})) return false;
    }
  }
  return true;
}

void PublisherSide::check_opening() {
  const auto now = std::chrono::steady_clock::now();
  bool erased = false;
  for (auto& [id, entry] : entries_) {
    if (!entry.opening) continue;
    if (entry.known && all_have_joined(entry)) {
      close_opening(entry);
    } else if (now > entry.deadline) {
      if (entry.known && entry.last_sequence > 0) {
        link_.log(LogLevel::kWarning,
                  fmt::format("topic {}: a subscriber has not joined within 2 s; it misses what "
                              "was published",
                              entry.core->topic()));
      }
      close_opening(entry);
    }
    erased = erased || (entry.withdrawn && !entry.opening);
  }
  if (!erased) return;
  std::erase_if(entries_, [](const auto& e) { return e.second.withdrawn && !e.second.opening; });
  link_.record_changed();
}

bool PublisherSide::is_idle() const {
  for (const auto& [id, entry] : entries_) {
    if (entry.opening && !entry.history.empty()) return false;
  }
  return true;
}

void PublisherSide::close_opening(Entry& entry) {
  entry.opening = false;
  const QoS& qos = entry.core->qos();
  const std::size_t kept = qos.policy == QoS::Policy::kLatched ? qos.depth : 0;
  while (entry.history.size() > kept) {
    entry.history_bytes -= entry.history.front().content->bytes();
    entry.history.pop_front();
  }
  refresh_readers(entry);
}

void PublisherSide::log_losses(bool at_any_rate) {
  for (auto& [id, entry] : entries_) log_losses(entry, at_any_rate);
}

void PublisherSide::log_losses(Entry& entry, bool at_any_rate) {
  const PublisherStatistics statistics = entry.core->statistics();
  if (!entry.loss_line.is_due(statistics.dropped, at_any_rate)) return;
  link_.log(LogLevel::kWarning,
            fmt::format("topic {}: {} messages dropped in all, as a subscriber reads too slowly",
                        entry.core->topic(), statistics.dropped));
}

void PublisherSide::fill(msgs::graph::NodeRecord& record) const {
  for (const auto& [id, entry] : entries_) {
    auto& end = *record.add_publishers();
    end.set_topic(entry.core->topic());
    end.set_schema_name(entry.core->schema()->name);
    end.set_schema_hash(entry.core->schema()->hash);
    end.set_policy(to_wire_policy(entry.core->qos().policy));
    end.set_depth(entry.core->qos().depth);
    end.set_id(id);
  }
}

void PublisherSide::stop() {
  for (auto& [id, entry] : entries_) {
    drain(id);
    entry.core->stop();
  }
}

}  // namespace prehend::graph

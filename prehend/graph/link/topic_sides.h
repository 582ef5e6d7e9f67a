#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>

#include "msgs/graph.pb.h"
#include "prehend/graph/link/node_link.h"
#include "prehend/graph/link/peer_channels.h"
#include "prehend/graph/link/publisher_core.h"
#include "prehend/graph/link/registry_link.h"
#include "prehend/graph/link/subscription_core.h"

namespace prehend::graph {

msgs::graph::QosPolicy to_wire_policy(QoS::Policy policy);

/// How long messages may be on their way after the registry has told of their publisher's end.
inline constexpr std::chrono::milliseconds kLastMessages{500};

/// The node's publishers: who has joined each, its history, what was lost. In the loop's thread
/// only.
///
/// No first message is lost: from advertise until every subscriber the registry knew at that time
/// has joined (or 2 s are over) the publisher is *opening*, and who joins gets all from the start.
class PublisherSide {
 public:
  PublisherSide(NodeLink& link, PeerChannels& channels, const RegistryLink& registry)
      : link_(link), channels_(channels), registry_(registry) {}

  void add(const std::shared_ptr<PublisherCore>& core);
  void remove(std::uint64_t id);
  void drain(std::uint64_t id);
  void join(const std::string& client, const msgs::graph::PeerMessage::Subscribe& request);
  void leave(const std::string& client, const msgs::graph::PeerMessage::Unsubscribe& request);
  void lose_client(const std::string& client);
  /// The registry knows what this node advertised up to now.
  void registry_knows(std::uint64_t version);
  /// Publishers added since have to wait for `version`.
  void record_sent(std::uint64_t version);
  /// Looks whether publishers are done opening.
  void check_opening();
  /// False while subscribers are awaited that shall have what was published.
  bool is_idle() const;
  void log_losses(bool at_any_rate);
  void fill(msgs::graph::NodeRecord& record) const;
  void stop();

 private:
  struct Entry {
    std::shared_ptr<PublisherCore> core;
    std::deque<TopicFrames> history;
    std::size_t history_bytes = 0;
    std::set<std::pair<std::string, std::uint64_t>> readers;  // client, its subscription
    std::map<std::string, int> clients;                       // number of its subscriptions
    std::uint64_t last_sequence = 0;                          // taken from the outbox
    bool opening = true;
    bool withdrawn = false;
    std::uint64_t version = 0;  // of the record that has it, 0: not sent yet
    bool known = false;         // to the registry
    std::chrono::steady_clock::time_point deadline;
    LossLine loss_line;
  };

  void remember(Entry& entry, TopicFrames frames);
  void send_history(Entry& entry, const std::string& client,
                    const msgs::graph::PeerMessage::Subscribe& request);
  bool all_have_joined(const Entry& entry) const;
  void close_opening(Entry& entry);
  void erase_reader(Entry& entry, const std::pair<std::string, std::uint64_t>& reader);
  void log_losses(Entry& entry, bool at_any_rate);

  NodeLink& link_;
  PeerChannels& channels_;
  const RegistryLink& registry_;
  std::map<std::uint64_t, Entry> entries_;
};

/// The node's subscriptions: finds their publishers, joins them, checks sequence and schema. In the
/// loop's thread only.
class SubscriberSide {
 public:
  SubscriberSide(NodeLink& link, PeerChannels& channels, const RegistryLink& registry)
      : link_(link), channels_(channels), registry_(registry) {}

  void add(const std::shared_ptr<SubscriptionCore>& core);
  void remove(std::uint64_t id);
  /// Joins the publishers of a node that is new or changed, leaves those it has withdrawn.
  void meet(const msgs::graph::NodeRecord& node);
  /// The node is gone.
  void lose_server(const std::string& server);
  /// Forgets publishers that were withdrawn a while ago.
  void forget_withdrawn();
  /// The connection broke and came back.
  void rejoin(const std::string& server);
  /// Others may have taken this node for dead and dropped its subscriptions: asks for them again.
  /// Publishers that have them still do not mind.
  void rejoin_all();
  void take_subscribed(const std::string& server, const msgs::graph::PeerMessage::Subscribed&);
  void take_history_end(const std::string& server, const msgs::graph::PeerMessage::HistoryEnd&);
  /// False: damaged.
  bool take_message(const std::string& server, Frames& frames);
  void log_losses(bool at_any_rate);
  void fill(msgs::graph::NodeRecord& record) const;

 private:
  struct Source {
    std::uint64_t publisher_id = 0;
    std::uint64_t expected = 0;  // next sequence number, 0: none seen
    bool joined = false;
    bool in_history = false;
    bool leaving = false;  // withdrawn, but its last messages may be on their way
    std::chrono::steady_clock::time_point leaving_since;
    std::shared_ptr<const Schema> schema;  // raw subscriptions
  };
  struct Entry {
    std::shared_ptr<SubscriptionCore> core;
    std::map<std::string, Source> sources;                    // by server
    std::set<std::pair<std::string, std::uint64_t>> refused;  // server, publisher id
    LossLine drop_line, gap_line, malformed_line;
  };

  void meet(Entry& entry, const msgs::graph::NodeRecord& node);
  bool accept_schema(Entry& entry, const msgs::graph::NodeRecord& node,
                     const msgs::graph::TopicEnd& publisher);
  void request(const Entry& entry, const std::string& server);
  void follow_sequence(Entry& entry, Source& source, std::uint64_t sequence);
  void refresh_count(Entry& entry);
  void log_losses(Entry& entry, bool at_any_rate);

  NodeLink& link_;
  PeerChannels& channels_;
  const RegistryLink& registry_;
  std::map<std::uint64_t, Entry> entries_;
};

}  // namespace prehend::graph

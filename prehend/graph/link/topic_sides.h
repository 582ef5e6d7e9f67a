#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "msgs/graph.pb.h"
#include "prehend/graph/link/node_link.h"
#include "prehend/graph/link/peer_channels.h"
#include "prehend/graph/link/publisher_core.h"
#include "prehend/graph/link/registry_link.h"
#include "prehend/graph/link/slab_mapping.h"
#include "prehend/graph/link/slab_readers.h"
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
      : link_(link), channels_(channels), registry_(registry), slab_readers_(link.slabs) {}

  void add(const std::shared_ptr<PublisherCore>& core);
  void remove(std::uint64_t id);
  void drain(std::uint64_t id);
  /// Sends on what was published up to now. Returns the nodes that have joined.
  std::set<std::string> drain_all();
  void join(const std::string& client, const msgs::graph::PeerMessage::Subscribe& request);
  /// The same for a subscription of the node `client` in this process; fills the answer.
  void join_local(const std::shared_ptr<SubscriptionCore>& subscription, const std::string& client,
                  const msgs::graph::PeerMessage::Subscribe& request,
                  msgs::graph::PeerMessage::Subscribed& answer);
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
  void look_after_lost_readers() { slab_readers_.look_after_lost(); }
  void fill(msgs::graph::NodeRecord& record) const;
  void fill(msgs::graph::NodeStatistics& report) const;
  void stop();

 private:
  struct Entry {
    std::shared_ptr<PublisherCore> core;
    std::deque<OutgoingMessage> history;
    std::size_t history_bytes = 0;
    std::set<std::pair<std::string, std::uint64_t>> readers;  // client, its subscription
    std::map<std::string, int> clients;  // of other processes: number of its subscriptions
    bool slab_readers = false;           // among the clients
    std::uint64_t last_sequence = 0;     // of what was published when last looked
    bool opening = true;
    bool withdrawn = false;
    std::uint64_t version = 0;  // of the record that has it, 0: not sent yet
    bool known = false;         // to the registry
    std::chrono::steady_clock::time_point deadline;
    LossLine loss_line;
  };

  Entry* admit(const msgs::graph::PeerMessage::Subscribe& request,
               msgs::graph::PeerMessage::Subscribed& answer);
  std::size_t history_for(const Entry& entry,
                          const msgs::graph::PeerMessage::Subscribe& request) const;
  void publish_to(const std::string& client, const Entry& entry, const QoS& qos,
                  std::span<const OutgoingMessage> messages);
  void remember(Entry& entry, const OutgoingMessage& message);
  void refresh_readers(Entry& entry);
  bool all_have_joined(const Entry& entry) const;
  void close_opening(Entry& entry);
  void erase_reader(Entry& entry, const std::pair<std::string, std::uint64_t>& reader);
  void log_losses(Entry& entry, bool at_any_rate);

  NodeLink& link_;
  PeerChannels& channels_;
  const RegistryLink& registry_;
  SlabReaders slab_readers_;
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
  /// The publisher, a node of this process, hands messages over from now on.
  void take_local(const std::string& server, const msgs::graph::PeerMessage::Subscribed&);
  void take_history_end(const std::string& server, const msgs::graph::PeerMessage::HistoryEnd&);
  /// A message or a batch. False: damaged.
  bool take_message(const std::string& server, Frames& frames);
  void trim_slabs() { slabs_.trim(); }
  void log_losses(bool at_any_rate);
  void fill(msgs::graph::NodeRecord& record) const;
  void fill(msgs::graph::NodeStatistics& report) const;
  /// The queues that messages of this server wait in.
  void fill(const std::string& server, msgs::graph::PeerMessage::DeliveryAnswer& answer) const;

 private:
  struct Source {
    std::uint64_t publisher_id = 0;
    std::uint64_t expected = 0;  // next sequence number, 0: none seen
    bool joined = false;
    bool in_history = false;
    bool local = false;        // hands messages over within the process
    bool inline_only = false;  // its slabs cannot be opened
    SharedName sender;
    bool leaving = false;  // withdrawn, but its last messages may be on their way
    std::chrono::steady_clock::time_point leaving_since;
    std::shared_ptr<const Schema> schema;  // raw subscriptions
  };
  struct Entry {
    std::shared_ptr<SubscriptionCore> core;
    SharedName topic;
    std::map<std::string, Source> sources;  // by server
    // Of sources that were lost: publisher and next sequence number, should they come back.
    std::map<std::string, std::pair<std::uint64_t, std::uint64_t>> lost_sources;
    std::set<std::pair<std::string, std::uint64_t>> refused;  // server, publisher id
    LossLine drop_line, gap_line, malformed_line;
  };

  void meet(Entry& entry, const msgs::graph::NodeRecord& node);
  bool accept_schema(Entry& entry, const msgs::graph::NodeRecord& node,
                     const msgs::graph::TopicEnd& publisher);
  msgs::graph::PeerMessage::Subscribe subscribe_request(const Entry& entry,
                                                        const std::string& server) const;
  void request(const Entry& entry, const std::string& server);
  void forget_source(Entry& entry, const std::string& server);
  void warn_unless_latched(const Entry& entry, const std::string& server,
                           const msgs::graph::PeerMessage::Subscribed& answer);
  struct Receiver {
    Entry* entry;
    Source* source;
    std::size_t callbacks = 0;  // to be asked for
  };
  std::vector<Receiver> receivers_of(const std::string& server, const std::string& topic);
  void deliver(std::vector<Receiver>& receivers, const msgs::graph::Envelope& envelope,
               const EncodedMessage& message, const BatchMemory<Content>* batch);
  bool deliver_all(std::vector<Receiver>& receivers, msgs::graph::Envelope& envelope,
                   const SharedBytes& batch);
  bool open_slab(const std::string& server, const std::vector<Receiver>& receivers,
                 const msgs::graph::Envelope& envelope, EncodedMessage& message);
  void follow_sequence(Entry& entry, Source& source, std::uint64_t next);
  void refresh_count(Entry& entry);
  void log_losses(Entry& entry, bool at_any_rate);

  NodeLink& link_;
  PeerChannels& channels_;
  const RegistryLink& registry_;
  SlabMappings slabs_;
  // This node's place among the leases of each server that uses shared memory: also what comes for
  // a subscription that has ended meanwhile has to be given back.
  std::map<std::string, std::uint32_t> slab_places_;
  std::map<std::uint64_t, Entry> entries_;
};

}  // namespace prehend::graph

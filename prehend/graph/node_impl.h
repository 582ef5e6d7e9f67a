#pragma once

#include <atomic>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "prehend/graph/link/action_server_core.h"
#include "prehend/graph/link/call_side.h"
#include "prehend/graph/link/curve.h"
#include "prehend/graph/link/delivery_side.h"
#include "prehend/graph/link/goal_side.h"
#include "prehend/graph/link/node_health.h"
#include "prehend/graph/link/node_link.h"
#include "prehend/graph/link/parameter_store.h"
#include "prehend/graph/link/peer_channels.h"
#include "prehend/graph/link/registry_link.h"
#include "prehend/graph/link/statistics_report.h"
#include "prehend/graph/link/topic_sides.h"
#include "prehend/graph/node.h"

namespace spdlog {
class logger;
}

namespace prehend::graph {

/// Thrown by the first call of a describing node that is not declare_parameter: see run_node.
struct DescriptionDone {};

/// Unique in a node: publishers, subscriptions.
std::uint64_t next_local_id();

/// A node's inside. The members below `loop thread` belong to the thread that runs the loop.
struct Node::Impl {
  /// `describing`: the node joins no graph, it only collects parameters for --help.
  Impl(NodeOptions node_options, bool describing);
  ~Impl();

  /// Connects to the registry and waits until it has taken the node.
  void join_graph();
  std::string no_answer(const std::string& registry_endpoint, const std::string& key_trouble) const;
  void shutdown();
  void check_not_describing() const;
  /// The name in the graph: remapped, or else in the node's namespace. Throws when malformed.
  std::string resolve(const std::string& name);
  /// Notes that this node uses the name for that purpose; throws when it does already.
  void take_name(const std::string& purpose, const std::string& name);

  std::shared_ptr<PublisherCore> make_publisher(const std::string& topic, const QoS& qos,
                                                std::shared_ptr<const Schema> schema);
  std::shared_ptr<SubscriptionCore> make_subscription(const std::string& topic, const QoS& qos,
                                                      std::shared_ptr<const Schema> schema,
                                                      SubscriptionCore::Handler handler,
                                                      bool in_loop);
  /// Waits, 1 s at most, until the registry knows what this thread has changed in the record. A
  /// publisher that anybody advertises from then on awaits this node's subscriptions.
  void wait_until_known();
  std::optional<ReaderQueues> wait_until_delivered(std::chrono::nanoseconds timeout);
  void log(LogLevel level, const std::string& text);
  void report(Health health, const std::string& text);
  void callback_failed(const std::string& source, const std::string& what);
  /// Reports `text`, which names its `source`; at once when it is news, repeated now and then.
  void work_failed(Health level, const std::string& source, const std::string& text);
  /// Another node does something wrong, which counts against this one's health until it is gone.
  void hold_against(const std::string& instance, const std::string& text);
  /// Publishes the health if it has changed.
  void tell_health();
  /// Offers topic /parameter_events, once there is a parameter.
  void announce_parameters();
  /// Logs it, calls back, and publishes one event.
  void parameters_were_set(const std::vector<ParameterInfo>& changed);
  void start_spinning();

  const NodeOptions options;
  const bool describing;
  ParameterStore parameters;
  std::shared_ptr<NodeLink> link;
  Clock clock;
  std::shared_ptr<spdlog::logger> logger;
  std::shared_ptr<PublisherCore> log_publisher;
  std::shared_ptr<PublisherCore> diagnostic_publisher;
  std::once_flag parameters_announced;
  Publisher<msgs::graph::ParameterEvent> parameter_events;
  std::shared_ptr<PublisherCore> statistics_publisher;
  std::shared_ptr<SubscriptionCore> clock_subscription;
  std::thread loop_thread;
  std::thread spin_thread;

  std::mutex mutex;
  std::set<std::string> remaps_used;
  std::set<std::string> names_used;
  NodeHealth health;
  std::map<std::string, std::pair<std::uint64_t, LossLine>> failures;  // by source
  bool is_shut_down = false;
  std::atomic<std::size_t> settings_waiting = 0;  // of parameters, for their validation
  std::vector<std::weak_ptr<ActionServerCore>> action_server_list;

  void make_own_topics();

  // loop thread
  void start_link();
  /// Throws when the keys cannot be read, or are needed and not there.
  std::unique_ptr<CurveGate> make_gate();
  /// Where peers connect to this node by tcp; empty: they use ipc.
  std::string tcp_endpoint() const;
  void flush_and_leave();
  void record_changed();
  void send_record();
  void welcome(const std::string& runtime_folder);
  std::string bind_failure(const std::string& runtime_folder, const std::string& what) const;
  void meet(const msgs::graph::NodeRecord& node);
  void warn_if_out_of_reach(const msgs::graph::NodeRecord& node);
  void lose_node(const std::string& instance);
  void forget_departed();
  void take_client_message(const std::string& client, msgs::graph::PeerMessage& message);
  void take_server_message(const std::string& server, msgs::graph::PeerMessage& message);
  void come_back(const std::string& server, std::uint64_t messages);
  void take_call(const std::string& client, msgs::graph::PeerMessage::Call& call);
  void take_goal(const std::string& client, msgs::graph::PeerMessage::Goal& goal);
  void take_cancel(const std::string& client, const msgs::graph::PeerMessage::Cancel& cancel);
  void answer_parameters(const std::string& client,
                         const msgs::graph::PeerMessage::ParameterRequest& request);
  /// In the loop's thread, or among the callbacks when user code has a say in it.
  void set_from_outside(const std::string& client, std::uint64_t id,
                        const std::map<std::string, std::string>& texts);
  bool ask_delivery(const std::string& client, const msgs::graph::PeerMessage& question);
  void answer_delivery(const std::string& server,
                       std::function<void(msgs::graph::PeerMessage::DeliveryAnswer)> reply);
  void count_malformed(const std::string& what);
  void watch_new_topics(const msgs::graph::NodeRecord& node);
  void tell_topic(const std::function<void(const TopicInfo&)>& watcher, const std::string& topic);
  void tick();

  msgs::graph::NodeRecord record;  // without the lists of ends and offers
  std::unique_ptr<CurveGate> gate;
  std::unique_ptr<PeerChannels> channels;
  std::unique_ptr<RegistryLink> registry;
  std::unique_ptr<PublisherSide> publishers;
  std::unique_ptr<SubscriberSide> subscribers;
  std::unique_ptr<StatisticsReport> statistics;
  std::unique_ptr<DeliverySide> deliveries;
  std::unique_ptr<CallSide> calls;
  std::unique_ptr<GoalSide> goals;
  bool joined = false;
  std::map<std::string, std::shared_ptr<ServiceCore>> services;
  std::map<std::string, std::shared_ptr<ActionServerCore>> action_servers;
  std::vector<std::function<void(const TopicInfo&)>> topic_watchers;
  std::set<std::string> topics_told;
  std::set<std::string> conflicts_told;
  std::map<std::string, std::chrono::steady_clock::time_point> departed;  // since when
  std::string socket_file;
  std::string runtime_folder;
  std::uint64_t malformed = 0;
  std::string malformed_example;
  LossLine malformed_line;
  bool record_change_pending = false;
  struct KnownWaiter {
    std::uint64_t version = 0;  // of the record that has the change, 0: not sent yet
    std::shared_ptr<std::promise<void>> known;
  };
  std::vector<KnownWaiter> known_waiters;
  std::function<void(const std::string& error)> join_ended;  // empty: joined
  std::chrono::steady_clock::time_point flush_deadline;
};

}  // namespace prehend::graph

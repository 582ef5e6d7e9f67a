#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include <zmq.hpp>

#include "msgs/graph.pb.h"
#include "prehend/graph/link/curve.h"
#include "prehend/graph/link/io_loop.h"
#include "prehend/graph/link/socket_monitor.h"
#include "prehend/graph/schema.h"

namespace prehend::graph {

/// A node's connection to the registry: says hello, keeps the record there up to date, beats, and
/// keeps a view of the other nodes. The view outlives the registry. In the loop's thread only.
class RegistryLink {
 public:
  struct Events {
    /// The registry took the hello. Once.
    std::function<void(const std::string& runtime_folder)> welcome;
    /// Refused: another node has the name.
    std::function<void(const std::string& error)> refused;
    /// The registry knows the record as of this version, and the view is as new.
    std::function<void(std::uint64_t version)> known;
    /// A node appeared or changed. Its former record is gone.
    std::function<void(const msgs::graph::NodeRecord&)> node_changed;
    std::function<void(const std::string& instance)> node_gone;
    /// The registry had taken this node for dead, and told others so, or is a new one.
    std::function<void()> forgotten;
    /// The registry does not answer (false) or is back (true).
    std::function<void(bool)> registry_answers;
  };

  RegistryLink(IoLoop& loop, const CurveGate& gate, const std::string& endpoint, Events events);
  ~RegistryLink();

  /// Asks for the runtime folder until welcome or refused.
  void hello(const msgs::graph::NodeRecord& record);
  /// Sends the record, with a new version, which it returns.
  std::uint64_t update(const msgs::graph::NodeRecord& record);
  /// Makes the type known if the registry asks for it.
  void offer_schema(const std::shared_ptr<const Schema>& schema);
  void goodbye();

  bool answers() const { return answers_; }
  /// What is wrong with the keys when that is why nothing answers; else empty.
  std::string key_trouble() const { return key_trouble_.words(); }
  /// The other nodes and this one, by instance.
  const std::map<std::string, msgs::graph::NodeRecord>& nodes() const { return nodes_; }

 private:
  using Time = std::chrono::steady_clock::time_point;

  bool send(msgs::graph::RegistryRequest& request);
  void connection_event(std::uint16_t event);
  void send_hello();
  void send_record();
  void tick();
  void read();
  void take(const msgs::graph::RegistryReply& reply);
  void take_update_answer(const msgs::graph::RegistryReply& reply);
  void take_all(const msgs::graph::RegistryReply& reply);
  void take_node(const msgs::graph::NodeRecord& record);
  void drop_node(const std::string& instance);
  void follow_revision(const msgs::graph::RegistryReply& reply);

  IoLoop& loop_;
  Events events_;
  KeyTrouble key_trouble_;
  zmq::socket_t socket_;
  std::optional<SocketMonitor> monitor_;
  msgs::graph::NodeRecord record_;
  std::map<std::string, msgs::graph::NodeRecord> nodes_;
  std::map<std::uint64_t, std::shared_ptr<const Schema>> schemas_;
  std::string registry_instance_;
  std::uint64_t revision_ = 0;  // of the registry's changes that were seen
  std::uint64_t next_id_ = 1;
  std::uint64_t update_id_ = 0;  // last request of each kind
  std::uint64_t list_id_ = 0;
  std::uint64_t known_version_ = 0;
  bool welcomed_ = false;
  bool answers_ = true;
  bool left_ = false;
  bool complain_ = true;  // about a refusal, once
  Time last_answer_;
  Time last_beat_;
  Time last_update_;
  Time full_list_due_;  // a new registry knows all living nodes by then
  bool full_list_wanted_ = false;
};

}  // namespace prehend::graph

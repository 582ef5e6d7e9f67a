#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "msgs/graph.pb.h"
#include "prehend/graph/registry_limits.h"

namespace prehend::graph {

/// What a registry knows and how it answers, without sockets: bytes of requests go in, replies come
/// out through `send`. A route stands for one connection of a node. In one thread only.
class RegistryState {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Send = std::function<void(const std::string& route, const msgs::graph::RegistryReply&)>;
  struct Options {
    std::chrono::milliseconds lease{3000};  ///< a node that is silent for this long is gone
    std::string instance;                   ///< unique to this run of the registry
    std::string runtime_folder;             ///< told to nodes
    std::string process_space;              ///< of this process; see runtime_folder.h
    RegistryLimits limits = {};
  };

  RegistryState(Options options, Send send);

  /// Takes the encoding of one RegistryRequest and sends what follows from it. False: it is none,
  /// and nothing has changed.
  bool take(const std::string& route, std::string_view request, Time now);
  /// Removes the nodes that are dead or silent for longer than the lease; true when there were any.
  bool sweep(Time now);

 private:
  struct Entry {
    msgs::graph::NodeRecord record;
    std::string route;
    Time last_beat;
    std::size_t bytes = 0;  // of the record
  };

  void answer(const std::string& route, const msgs::graph::RegistryRequest& request, Time now);
  void take_update(const std::string& route, const msgs::graph::NodeRecord& record,
                   msgs::graph::RegistryReply& reply, Time now);
  /// Why the record is not taken; empty when it is.
  std::string fault(const msgs::graph::NodeRecord& record);
  void take_schema(const msgs::graph::Schema& schema, msgs::graph::RegistryReply& reply);
  void forget_unused_schemas();
  void push(msgs::graph::RegistryReply& change, const std::string& except = "");
  void send(const std::string& route, msgs::graph::RegistryReply& reply);
  void remove(const std::string& node_instance);
  const msgs::graph::NodeRecord* living_node_of_name(const std::string& name,
                                                     const std::string& but_not);
  bool is_dead(const msgs::graph::NodeRecord& record) const;

  const Options options_;
  const Send send_;
  std::map<std::string, Entry> nodes_;  // by instance
  std::map<std::uint64_t, msgs::graph::Schema> schemas_;
  std::size_t record_bytes_ = 0;
  std::size_t schema_bytes_ = 0;
  std::uint64_t revision_ = 0;
};

}  // namespace prehend::graph

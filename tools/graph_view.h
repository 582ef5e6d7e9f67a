#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "msgs/graph.pb.h"
#include "tools/json.h"

namespace prehend::tools {

enum class NodeStatus { kOk, kWarning, kError, kStale };

/// A node as the registry knows it, and what it says of its traffic.
struct NodeView {
  msgs::graph::NodeRecord record;
  std::optional<msgs::graph::NodeStatistics> statistics;  ///< nothing: it does not answer

  /// Stale: it missed two of its heartbeats, which come every second, or does not answer; else its
  /// own word on its health.
  NodeStatus status() const;
  /// "ok", "warning: no table", "stale: silent for 2.3 s"
  std::string status_text() const;
  /// Null when unknown.
  const msgs::graph::TopicStatistics* topic(const std::string& topic, bool is_publisher) const;
};

/// One node's end of a topic.
struct TopicEndView {
  const NodeView* node = nullptr;
  msgs::graph::TopicEnd end;
  const msgs::graph::TopicStatistics* statistics = nullptr;  ///< null: unknown
};

struct TopicView {
  std::set<std::string> types;
  std::vector<TopicEndView> publishers, subscribers;
};

struct GraphView {
  std::string registry;  ///< its endpoint
  std::vector<NodeView> nodes;

  /// By name. Points into this view.
  std::map<std::string, TopicView> topics() const;
  std::vector<std::string> node_names() const;
  /// Throws std::runtime_error naming the nearest when there is no such node.
  const NodeView& node(const std::string& name) const;
};

/// Asks the registry and all nodes. Throws std::runtime_error when the registry does not answer.
GraphView look_at_graph(const std::string& registry);

const char* name_of(NodeStatus status);
/// "starting", "ready", "stopping"
const char* name_of(msgs::graph::NodeState state);
/// "latest", "queue(10)", "latched(1)"
std::string qos_text(const msgs::graph::TopicEnd& end);
/// True of the topics that every node has for what it says of itself.
bool is_built_in(const std::string& topic);

/// For programs.
Json to_json(const TopicEndView& end);

}  // namespace prehend::tools

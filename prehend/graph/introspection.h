#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "msgs/graph.pb.h"
#include "prehend/graph/schema.h"

namespace prehend::graph {

/// The registry that listens there cannot be asked with these keys, or without any.
class KeyError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Looks at a running graph from outside, without being a node. One thread at a time.
/// Every call throws std::runtime_error with one clear line when the registry or the node asked
/// does not answer in time; KeyError when keys are the reason.
class Introspection {
 public:
  /// `registry`: endpoint; empty: PREHEND_REGISTRY, else the default. `timeout`: of each call.
  /// `keys_file`: see NodeOptions.
  explicit Introspection(std::string registry = "",
                         std::chrono::milliseconds timeout = std::chrono::seconds(2),
                         const std::string& keys_file = "");
  ~Introspection();

  const std::string& registry() const;

  /// All nodes with their topics, services, actions, state and health, sorted by name.
  std::vector<msgs::graph::NodeRecord> nodes();

  /// The message type of a topic. Throws when nobody publishes it, naming the nearest topic.
  Schema topic_schema(const std::string& topic);
  /// A message type by name, as far as a node has declared it; throws when unknown.
  Schema schema(const std::string& name, std::uint64_t hash = 0);

  /// The message types of a service (request, response) or an action (goal, feedback, result).
  /// Throws when nobody serves it, naming the nearest.
  std::vector<Schema> service(const std::string& name);
  std::vector<Schema> action(const std::string& name);

  /// The last report of each of `nodes`, by instance. All are asked at once; a node that does not
  /// answer within `wait` is missing, one that has not reported yet has an empty report.
  std::map<std::string, msgs::graph::NodeStatistics> statistics(
      const std::vector<msgs::graph::NodeRecord>& nodes,
      std::chrono::milliseconds wait = std::chrono::milliseconds(500));

  /// Cancels the goals of an action, whoever sent them. Throws when nobody serves the action,
  /// naming the nearest, or it has no goal.
  void cancel_action(const std::string& action);

  /// A node's parameters, sorted by name. Throws when there is no such node, naming the nearest.
  std::vector<msgs::graph::ParameterRecord> parameters(const std::string& node);
  msgs::graph::ParameterRecord parameter(const std::string& node, const std::string& name);
  /// Sets and returns what the node then has; throws what the node says against it.
  msgs::graph::ParameterRecord set_parameter(const std::string& node, const std::string& name,
                                             const std::string& text);
  /// The same for several at once, name -> text: the node sets all of them or none.
  std::vector<msgs::graph::ParameterRecord> set_parameters(
      const std::string& node, const std::map<std::string, std::string>& texts);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// `value` as text, as `prehend param get` prints it.
std::string to_text(const msgs::graph::ParameterValue& value);

}  // namespace prehend::graph

#include "tools/graph_view.h"

#include <fmt/format.h>

#include <stdexcept>

#include "prehend/graph/introspection.h"
#include "prehend/text/nearest_match.h"

namespace prehend::tools {
namespace {

using msgs::graph::NodeRecord;

constexpr std::int64_t kLongestSilence = 2'000'000'000;  // ns, two beats

}  // namespace

NodeStatus NodeView::status() const {
  if (record.silence() > kLongestSilence || !statistics) return NodeStatus::kStale;
  switch (record.health()) {
    case msgs::graph::HEALTH_WARNING:
      return NodeStatus::kWarning;
    case msgs::graph::HEALTH_ERROR:
      return NodeStatus::kError;
    default:
      return NodeStatus::kOk;
  }
}

std::string NodeView::status_text() const {
  const std::string name = name_of(status());
  if (status() == NodeStatus::kStale) {
    return record.silence() > kLongestSilence
               ? fmt::format("{}: silent for {:.1f} s", name,
                             static_cast<double>(record.silence()) * 1e-9)
               : name + ": does not answer";
  }
  return record.health_text().empty() ? name : name + ": " + record.health_text();
}

const msgs::graph::TopicStatistics* NodeView::topic(const std::string& topic,
                                                    bool is_publisher) const {
  if (!statistics) return nullptr;
  for (const auto& entry : statistics->topics()) {
    if (entry.topic() == topic && entry.is_publisher() == is_publisher) return &entry;
  }
  return nullptr;
}

std::map<std::string, TopicView> GraphView::topics() const {
  std::map<std::string, TopicView> result;
  const auto add = [&](const NodeView& node, const auto& ends, bool publishers) {
    for (const auto& end : ends) {
      TopicView& topic = result[end.topic()];
      if (!end.schema_name().empty()) topic.types.insert(end.schema_name());
      (publishers ? topic.publishers : topic.subscribers)
          .push_back({&node, end, node.topic(end.topic(), publishers)});
    }
  };
  for (const NodeView& node : nodes) {
    add(node, node.record.publishers(), true);
    add(node, node.record.subscribers(), false);
  }
  return result;
}

std::vector<std::string> GraphView::node_names() const {
  std::vector<std::string> names;
  for (const NodeView& node : nodes) names.push_back(node.record.name());
  return names;
}

const NodeView& GraphView::node(const std::string& name) const {
  for (const NodeView& node : nodes) {
    if (node.record.name() == name) return node;
  }
  throw std::runtime_error("there is no node \"" + name + "\"" +
                           text::nearest_match_hint(name, node_names()));
}

GraphView look_at_graph(const std::string& registry) {
  graph::Introspection introspection(registry);
  GraphView view;
  view.registry = introspection.registry();
  const std::vector<NodeRecord> records = introspection.nodes();
  const auto statistics = introspection.statistics(records);
  for (const NodeRecord& record : records) {
    const auto found = statistics.find(record.instance());
    view.nodes.push_back(
        {record, found == statistics.end() ? std::nullopt : std::optional(found->second)});
  }
  return view;
}

const char* name_of(NodeStatus status) {
  static constexpr const char* kNames[] = {"ok", "warning", "error", "stale"};
  return kNames[static_cast<int>(status)];
}

const char* name_of(msgs::graph::NodeState state) {
  switch (state) {
    case msgs::graph::READY:
      return "ready";
    case msgs::graph::STOPPING:
      return "stopping";
    default:
      return "starting";
  }
}

std::string qos_text(const msgs::graph::TopicEnd& end) {
  switch (end.policy()) {
    case msgs::graph::LATEST:
      return "latest";
    case msgs::graph::LATCHED:
      return fmt::format("latched({})", end.depth());
    default:
      return fmt::format("queue({})", end.depth());
  }
}

bool is_built_in(const std::string& topic) {
  return topic == "/log" || topic == "/diagnostics" || topic == "/statistics";
}

Json to_json(const TopicEndView& end) {
  Json json = Json::object();
  json.set("topic", end.end.topic())
      .set("node", end.node->record.name())
      .set("type", end.end.schema_name())
      .set("qos", qos_text(end.end));
  json.set("statistics", end.statistics ? json_of(*end.statistics) : Json::null());
  return json;
}

}  // namespace prehend::tools

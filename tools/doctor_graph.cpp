#include "tools/doctor_graph.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "prehend/text/nearest_match.h"

namespace prehend::tools {
namespace {

using Level = Finding::Level;
using Topics = std::map<std::string, TopicView>;

std::string nodes_text(const std::vector<TopicEndView>& ends) {
  std::vector<std::string> names;
  for (const TopicEndView& end : ends) names.push_back(end.node->record.name());
  return fmt::format("{}", fmt::join(names, ", "));
}

void examine_node(const NodeView& node, Findings& findings) {
  const std::string subject = "node " + node.record.name();
  switch (node.status()) {
    case NodeStatus::kStale:
      findings.push_back(
          {Level::kError, subject, node.status_text(),
           fmt::format("its process is stopped, hung or overloaded: look at process {} (top, gdb), "
                       "end it with kill {}",
                       node.record.pid(), node.record.pid())});
      break;
    case NodeStatus::kError:
      findings.push_back({Level::kError, subject, "is in error: " + node.record.health_text(),
                          "prehend log --node " + node.record.name()});
      break;
    case NodeStatus::kWarning:
      findings.push_back({Level::kWarning, subject, "warns: " + node.record.health_text(),
                          "prehend log --node " + node.record.name()});
      break;
    case NodeStatus::kOk:
      break;
  }
  if (node.record.state() == msgs::graph::STARTING) {
    findings.push_back({Level::kWarning, subject, "is not ready: its set-up has not ended",
                        "prehend log --node " + node.record.name() + " says what it waits for"});
  }
  if (node.statistics && node.statistics->malformed_frames() > 0) {
    findings.push_back({Level::kWarning, subject,
                        fmt::format("threw away {} damaged or foreign messages",
                                    node.statistics->malformed_frames()),
                        "see which program connects to " + node.record.endpoint() +
                            "; nodes of another version must not share a graph"});
  }
}

void examine_clock(const Topics& topics, Findings& findings) {
  const auto clock = topics.find("/clock");
  if (clock == topics.end() || !clock->second.publishers.empty()) return;
  findings.push_back(
      {Level::kError, "topic /clock",
       "nobody publishes it, so time stands still for " + nodes_text(clock->second.subscribers),
       "start a simulation or a replay, or these nodes with --clock wall"});
}

void examine_missing_publisher(const std::string& name, const TopicView& topic,
                               const Topics& topics, Findings& findings) {
  if (!topic.publishers.empty() || topic.subscribers.empty() || name == "/clock") return;
  std::vector<std::string> published;
  for (const auto& [other, ends] : topics) {
    if (!ends.publishers.empty() && !is_built_in(other)) published.push_back(other);
  }
  const auto nearest = text::nearest_match(name, published);
  findings.push_back(
      {Level::kWarning, "topic " + name,
       "nobody publishes it; taken by " + nodes_text(topic.subscribers),
       nearest ? fmt::format("did you mean \"{0}\"? --remap {1}:={0}", *nearest, name)
               : "start its publisher, or remap it to what is published (prehend topic list)"});
}

// Every pair of ends is of one type, or one end takes any.
void examine_types(const std::string& name, const TopicView& topic, Findings& findings) {
  std::map<std::pair<std::string, std::uint64_t>, std::vector<TopicEndView>> ends_of;
  for (const auto* ends : {&topic.publishers, &topic.subscribers}) {
    for (const TopicEndView& end : *ends) {
      if (end.end.schema_hash() == 0) continue;
      ends_of[{end.end.schema_name(), end.end.schema_hash()}].push_back(end);
    }
  }
  if (ends_of.size() < 2) return;
  std::vector<std::string> parts;
  bool same_name = true;
  for (const auto& [type, ends] : ends_of) {
    parts.push_back(fmt::format("{} ({:016x}) at {}", type.first, type.second, nodes_text(ends)));
    same_name = same_name && type.first == ends_of.begin()->first.first;
  }
  findings.push_back({Level::kError, "topic " + name,
                      fmt::format("different message types: {}", fmt::join(parts, "; ")),
                      same_name ? "build all nodes from the same .proto files"
                                : "remap one of them to a topic of its own"});
}

void examine_qos(const std::string& name, const TopicView& topic, Findings& findings) {
  for (const TopicEndView& subscriber : topic.subscribers) {
    if (subscriber.end.policy() != msgs::graph::LATCHED) continue;
    for (const TopicEndView& publisher : topic.publishers) {
      if (publisher.end.policy() == msgs::graph::LATCHED) continue;
      findings.push_back(
          {Level::kWarning, "topic " + name,
           fmt::format("{} wants kept messages, but {} publishes {}",
                       subscriber.node->record.name(), publisher.node->record.name(),
                       qos_text(publisher.end)),
           fmt::format("advertise with QoS::latched in {}, or subscribe with queue in {}",
                       publisher.node->record.program(), subscriber.node->record.program())});
    }
  }
}

void examine_losses(const std::string& name, const TopicView& topic, Findings& findings) {
  const auto add = [&](Level level, const std::string& what, const std::string& mend) {
    findings.push_back({level, "topic " + name, what, mend});
  };
  for (const TopicEndView& end : topic.publishers) {
    if (!end.statistics || end.statistics->dropped() == 0) continue;
    add(Level::kWarning,
        fmt::format("{} dropped {} of {} messages, as a subscriber reads too slowly",
                    end.node->record.name(), end.statistics->dropped(), end.statistics->messages()),
        "find it with prehend topic info " + name + "; give it QoS::latest or a longer queue");
  }
  for (const TopicEndView& end : topic.subscribers) {
    if (!end.statistics) continue;
    const std::string& node = end.node->record.name();
    if (end.statistics->dropped() > 0) {
      add(Level::kWarning,
          fmt::format("{} dropped {} of {} messages, as its callback is slower than they come",
                      node, end.statistics->dropped(), end.statistics->messages()),
          "a longer queue for bursts, else QoS::latest or a faster callback");
    }
    if (end.statistics->missed() > 0) {
      add(Level::kWarning,
          fmt::format("{} messages never came to {}", end.statistics->missed(), node),
          "its publisher dropped them or the connection broke: prehend log --level warning");
    }
    if (end.statistics->malformed() > 0) {
      add(Level::kError,
          fmt::format("{} threw away {} damaged messages", node, end.statistics->malformed()),
          "build publisher and subscriber from the same .proto files");
    }
  }
}

void examine_offers(const GraphView& graph, bool actions, Findings& findings) {
  std::map<std::string, std::vector<std::string>> servers;
  for (const NodeView& node : graph.nodes) {
    for (const auto& offer : actions ? node.record.actions() : node.record.services()) {
      servers[offer.name()].push_back(node.record.name());
    }
  }
  for (const auto& [name, nodes] : servers) {
    if (nodes.size() < 2) continue;
    findings.push_back({Level::kError, (actions ? "action " : "service ") + name,
                        fmt::format("served by {}; clients take either", fmt::join(nodes, " and ")),
                        "stop one of them or remap its name"});
  }
}

}  // namespace

Findings examine_graph(const GraphView& graph) {
  Findings findings;
  const Topics topics = graph.topics();
  for (const NodeView& node : graph.nodes) examine_node(node, findings);
  examine_clock(topics, findings);
  for (const auto& [name, topic] : topics) {
    examine_missing_publisher(name, topic, topics, findings);
    examine_types(name, topic, findings);
    examine_qos(name, topic, findings);
    examine_losses(name, topic, findings);
  }
  examine_offers(graph, false, findings);
  examine_offers(graph, true, findings);
  return findings;
}

}  // namespace prehend::tools

// `prehend graph`: nodes and topics as a picture.

#include <fmt/format.h>

#include <cstdio>
#include <fstream>
#include <memory>
#include <stdexcept>

#include "tools/commands.h"
#include "tools/graph_view.h"
#include "tools/json.h"

namespace prehend::tools {
namespace {

struct GraphChoices {
  std::string registry, output;
  bool all = false, json = false;
};

std::string dot_quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += c == '\n' ? ' ' : c;
  }
  return result + '"';
}

const char* colour_of(NodeStatus status) {
  switch (status) {
    case NodeStatus::kOk:
      return "white";
    case NodeStatus::kWarning:
      return "khaki";
    case NodeStatus::kError:
      return "salmon";
    case NodeStatus::kStale:
      break;
  }
  return "lightgrey";
}

std::uint64_t losses_of(const TopicEndView& end) {
  const auto* topic = end.statistics;
  return topic ? topic->dropped() + topic->missed() + topic->malformed() : 0;
}

// "30.0/s", "30.0/s, 12 lost", or nothing when unknown.
std::string label_of(const TopicEndView& end) {
  if (!end.statistics) return "";
  std::string label = fmt::format("{:.1f}/s", end.statistics->rate());
  if (losses_of(end) > 0) label += fmt::format(", {} lost", losses_of(end));
  return label;
}

std::string edge_text(const TopicEndView& end, bool publishes) {
  const std::string node = dot_quoted("node " + end.node->record.name());
  const std::string topic = dot_quoted("topic " + end.end.topic());
  return fmt::format("  {} -> {} [label={}{}];\n", publishes ? node : topic,
                     publishes ? topic : node, dot_quoted(label_of(end)),
                     losses_of(end) > 0 ? ", color=red, fontcolor=red" : "");
}

std::string dot_text(const GraphView& graph, bool all) {
  std::string text =
      "digraph prehend {\n  rankdir=LR;\n  node [fontname=\"DejaVu Sans\", style=filled];\n"
      "  edge [fontname=\"DejaVu Sans\", fontsize=10];\n";
  for (const NodeView& node : graph.nodes) {
    text += fmt::format("  {} [shape=box, label={}, fillcolor={}, tooltip={}];\n",
                        dot_quoted("node " + node.record.name()), dot_quoted(node.record.name()),
                        colour_of(node.status()), dot_quoted(node.status_text()));
  }
  for (const auto& [name, topic] : graph.topics()) {
    if (!all && is_built_in(name)) continue;
    // Who publishes to nobody, and who waits for nobody, is seen at the topic.
    const bool whole = !topic.publishers.empty() && !topic.subscribers.empty();
    std::string types;
    for (const std::string& type : topic.types) types += (types.empty() ? "" : ", ") + type;
    text += fmt::format("  {} [shape=ellipse, label={}, fillcolor={}, tooltip={}];\n",
                        dot_quoted("topic " + name), dot_quoted(name),
                        whole ? "lightblue" : "\"#eeeeee\"", dot_quoted(types));
    for (const TopicEndView& end : topic.publishers) text += edge_text(end, true);
    for (const TopicEndView& end : topic.subscribers) text += edge_text(end, false);
  }
  return text + "}\n";
}

std::string json_text(const GraphView& graph, bool all) {
  Json nodes = Json::array(), topics = Json::array();
  for (const NodeView& node : graph.nodes) {
    nodes.add(Json::object().set("name", node.record.name()).set("status", name_of(node.status())));
  }
  for (const auto& [name, topic] : graph.topics()) {
    if (!all && is_built_in(name)) continue;
    Json publishers = Json::array(), subscribers = Json::array();
    for (const TopicEndView& end : topic.publishers) publishers.add(to_json(end));
    for (const TopicEndView& end : topic.subscribers) subscribers.add(to_json(end));
    topics.add(Json::object()
                   .set("name", name)
                   .set("publishers", publishers)
                   .set("subscribers", subscribers));
  }
  return Json::object().set("nodes", nodes).set("topics", topics).text() + "\n";
}

void draw(const GraphChoices& choices) {
  const GraphView graph = look_at_graph(choices.registry);
  const std::string text =
      choices.json ? json_text(graph, choices.all) : dot_text(graph, choices.all);
  if (choices.output.empty()) {
    std::fputs(text.c_str(), stdout);
    return;
  }
  std::ofstream file(choices.output);
  if (!(file << text).flush()) throw std::runtime_error("cannot write " + choices.output);
  std::printf("%s: %zu nodes\n", choices.output.c_str(), graph.nodes.size());
}

}  // namespace

void add_graph_command(CLI::App& app) {
  auto choices = std::make_shared<GraphChoices>();
  CLI::App* command = app.add_subcommand(
      "graph", "Draw nodes and topics with rates and losses, as text for Graphviz (DOT)");
  command->add_option("-o,--output", choices->output, "File to write; default: standard output");
  command->add_flag("--all", choices->all, "With /log, /diagnostics and /statistics");
  add_registry_option(*command, choices->registry);
  add_json_option(*command, choices->json);
  command->footer("Example:\n  prehend graph -o graph.dot && dot -Tsvg graph.dot -o graph.svg");
  command->callback([choices] { draw(*choices); });
}

}  // namespace prehend::tools

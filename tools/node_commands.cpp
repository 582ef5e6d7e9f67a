#include <cstdio>
#include <memory>

#include "prehend/graph/introspection.h"
#include "prehend/graph/nearest_match.h"
#include "tools/commands.h"
#include "tools/table.h"

namespace prehend::tools {
namespace {

using graph::Introspection;
using msgs::graph::NodeRecord;

std::string state_of(const NodeRecord& node) {
  switch (node.state()) {
    case msgs::graph::READY:
      return "ready";
    case msgs::graph::STOPPING:
      return "stopping";
    default:
      return "starting";
  }
}

std::string health_of(const NodeRecord& node) {
  const char* level = node.health() == msgs::graph::HEALTH_ERROR     ? "error"
                      : node.health() == msgs::graph::HEALTH_WARNING ? "warning"
                                                                     : "ok";
  return node.health_text().empty() ? level : std::string(level) + ": " + node.health_text();
}

void list_nodes(const std::string& registry) {
  std::vector<std::vector<std::string>> rows{{"NODE", "PROGRAM", "PID", "STATE", "HEALTH"}};
  for (const NodeRecord& node : Introspection(registry).nodes()) {
    rows.push_back(
        {node.name(), node.program(), std::to_string(node.pid()), state_of(node), health_of(node)});
  }
  print_table(rows);
}

template <class Entries, class Text>
void print_group(const char* title, const Entries& entries, Text text) {
  if (entries.empty()) return;
  std::printf("%s\n", title);
  for (const auto& entry : entries) std::printf("  %s\n", text(entry).c_str());
}

void show_node(const std::string& registry, const std::string& name) {
  std::vector<std::string> names;
  for (const NodeRecord& node : Introspection(registry).nodes()) {
    names.push_back(node.name());
    if (node.name() != name) continue;
    std::printf("%s: program %s, process %lld, %s, %s\n", node.name().c_str(),
                node.program().c_str(), static_cast<long long>(node.pid()), state_of(node).c_str(),
                health_of(node).c_str());
    const auto topic = [](const msgs::graph::TopicEnd& end) {
      return end.topic() + (end.schema_name().empty() ? "" : "  " + end.schema_name());
    };
    const auto offer = [](const msgs::graph::Offer& entry) {
      return entry.name() + "  " + joined({entry.type_names().begin(), entry.type_names().end()});
    };
    print_group("publishes", node.publishers(), topic);
    print_group("subscribes", node.subscribers(), topic);
    print_group("services", node.services(), offer);
    print_group("actions", node.actions(), offer);
    return;
  }
  throw std::runtime_error("there is no node \"" + name + "\"" +
                           graph::nearest_match_hint(name, names));
}

void list_offers(const std::string& registry, bool actions) {
  std::vector<std::vector<std::string>> rows{
      {actions ? "ACTION" : "SERVICE", actions ? "GOAL, FEEDBACK, RESULT" : "REQUEST, RESPONSE",
       "NODE"}};
  for (const NodeRecord& node : Introspection(registry).nodes()) {
    for (const auto& offer : actions ? node.actions() : node.services()) {
      rows.push_back({offer.name(), joined({offer.type_names().begin(), offer.type_names().end()}),
                      node.name()});
    }
  }
  print_table(rows);
}

}  // namespace

void add_node_commands(CLI::App& app) {
  CLI::App* group = app.add_subcommand("node", "Look at the nodes of a running graph");
  group->require_subcommand(1);
  auto registry = std::make_shared<std::string>();
  auto name = std::make_shared<std::string>();
  CLI::App* list = group->add_subcommand("list", "List all nodes with their state and health");
  add_registry_option(*list, *registry);
  list->footer("Example:\n  prehend node list");
  list->callback([registry] { list_nodes(*registry); });
  CLI::App* info = group->add_subcommand("info", "Show what one node publishes, takes and offers");
  info->add_option("node", *name, "Its name")->required();
  add_registry_option(*info, *registry);
  info->footer("Example:\n  prehend node info simulation");
  info->callback([registry, name] { show_node(*registry, *name); });
}

void add_service_commands(CLI::App& app) {
  for (const bool actions : {false, true}) {
    CLI::App* group = app.add_subcommand(
        actions ? "action" : "service",
        actions ? "Look at the actions nodes offer" : "Look at the services nodes offer");
    group->require_subcommand(1);
    auto registry = std::make_shared<std::string>();
    CLI::App* list = group->add_subcommand("list", "List them with their types and nodes");
    add_registry_option(*list, *registry);
    list->footer(std::string("Example:\n  prehend ") + (actions ? "action" : "service") + " list");
    list->callback([registry, actions] { list_offers(*registry, actions); });
  }
}

}  // namespace prehend::tools

#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "tools/commands.h"
#include "tools/graph_view.h"
#include "tools/json.h"
#include "tools/table.h"
#include "tools/traffic_table.h"

namespace prehend::tools {
namespace {

struct NodeChoices {
  std::string registry, name;
  bool json = false;
};

Json to_json(const NodeView& node) {
  Json json = Json::object();
  json.set("name", node.record.name())
      .set("program", node.record.program())
      .set("pid", node.record.pid())
      .set("state", name_of(node.record.state()))
      .set("status", name_of(node.status()))
      .set("status_text", node.status_text())
      .set("silence", static_cast<double>(node.record.silence()) * 1e-9)
      .set("record", json_of(node.record))
      .set("statistics", node.statistics ? json_of(*node.statistics) : Json::null());
  return json;
}

void list_nodes(const NodeChoices& choices) {
  const GraphView graph = look_at_graph(choices.registry);
  Json list = Json::array();
  std::vector<std::vector<std::string>> rows{{"NODE", "PROGRAM", "PID", "STATE", "STATUS"}};
  for (const NodeView& node : graph.nodes) {
    list.add(to_json(node));
    rows.push_back({node.record.name(), node.record.program(), std::to_string(node.record.pid()),
                    name_of(node.record.state()), node.status_text()});
  }
  if (choices.json) return print(list);
  print_table(rows);
}

void print_offers(const char* title,
                  const google::protobuf::RepeatedPtrField<msgs::graph::Offer>& offers) {
  if (offers.empty()) return;
  std::printf("\n%s\n", title);
  for (const auto& offer : offers) {
    std::printf("  %s  %s\n", offer.name().c_str(),
                joined({offer.type_names().begin(), offer.type_names().end()}).c_str());
  }
}

void print_ends(const char* title, const NodeView& node,
                const google::protobuf::RepeatedPtrField<msgs::graph::TopicEnd>& ends,
                bool publishers) {
  if (ends.empty()) return;
  std::printf("\n%s\n", title);
  std::vector<TopicEndView> views;
  for (const auto& end : ends) {
    std::printf("  %s  %s\n", end.topic().c_str(),
                end.schema_name().empty() ? "(any type)" : end.schema_name().c_str());
    if (is_built_in(end.topic()) && publishers) continue;
    views.push_back({&node, end, node.topic(end.topic(), publishers)});
  }
  if (!views.empty()) print_traffic("TOPIC", views);
}

void show_node(const NodeChoices& choices) {
  const GraphView graph = look_at_graph(choices.registry);
  const NodeView& node = graph.node(choices.name);
  if (choices.json) return print(to_json(node));
  std::printf("%s: program %s, process %lld, %s, %s\n", node.record.name().c_str(),
              node.record.program().c_str(), static_cast<long long>(node.record.pid()),
              name_of(node.record.state()), node.status_text().c_str());
  if (node.statistics && node.statistics->stamp() != 0) {
    std::printf(
        "process: %.1f MB of memory, %.1f s of processor time; %llu damaged frames, %llu "
        "failed callbacks\n",
        static_cast<double>(node.statistics->resident_bytes()) * 1e-6,
        node.statistics->cpu_seconds(),
        static_cast<unsigned long long>(node.statistics->malformed_frames()),
        static_cast<unsigned long long>(node.statistics->failed_callbacks()));
  }
  print_ends("publishes", node, node.record.publishers(), true);
  print_ends("subscribes", node, node.record.subscribers(), false);
  print_offers("services", node.record.services());
  print_offers("actions", node.record.actions());
}

}  // namespace

void add_node_commands(CLI::App& app) {
  CLI::App* group = app.add_subcommand("node", "Look at the nodes of a running graph");
  group->require_subcommand(1);
  auto choices = std::make_shared<NodeChoices>();
  CLI::App* list = group->add_subcommand(
      "list", "List all nodes with their state and status (ok, warning, error, stale)");
  add_registry_option(*list, choices->registry);
  add_json_option(*list, choices->json);
  list->footer("Example:\n  prehend node list");
  list->callback([choices] { list_nodes(*choices); });
  CLI::App* info = group->add_subcommand(
      "info", "Show what one node publishes, takes and offers, with rates and losses");
  info->add_option("node", choices->name, "Its name")->required();
  add_registry_option(*info, choices->registry);
  add_json_option(*info, choices->json);
  info->footer("Example:\n  prehend node info simulation");
  info->callback([choices] { show_node(*choices); });
}

}  // namespace prehend::tools

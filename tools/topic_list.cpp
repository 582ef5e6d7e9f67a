#include "tools/topic_list.h"

#include <cstdio>
#include <stdexcept>

#include "prehend/text/nearest_match.h"
#include "tools/graph_view.h"
#include "tools/json.h"
#include "tools/table.h"
#include "tools/traffic_table.h"

namespace prehend::tools {
namespace {

std::vector<std::string> nodes_of(const std::vector<TopicEndView>& ends) {
  std::vector<std::string> names;
  for (const TopicEndView& end : ends) names.push_back(end.node->record.name());
  return names;
}

std::string short_text(const std::vector<std::string>& names) {
  if (names.empty()) return "-";
  return names.size() > 3 ? std::to_string(names.size()) + " nodes" : joined(names);
}

Json to_json(const std::string& name, const TopicView& topic) {
  Json publishers = Json::array(), subscribers = Json::array();
  for (const TopicEndView& end : topic.publishers) publishers.add(to_json(end));
  for (const TopicEndView& end : topic.subscribers) subscribers.add(to_json(end));
  Json json = Json::object();
  json.set("topic", name)
      .set("types", std::vector<std::string>(topic.types.begin(), topic.types.end()))
      .set("publishers", publishers)
      .set("subscribers", subscribers);
  return json;
}

void print_ends(const char* title, const std::vector<TopicEndView>& ends) {
  if (ends.empty()) {
    std::printf("\nno %s\n", title);
    return;
  }
  std::printf("\n%s\n", title);
  print_traffic("NODE", ends);
}

}  // namespace

void list_topics(const std::string& registry, bool json) {
  const GraphView graph = look_at_graph(registry);
  Json list = Json::array();
  std::vector<std::vector<std::string>> rows{{"TOPIC", "TYPE", "PUBLISHERS", "SUBSCRIBERS"}};
  for (const auto& [name, topic] : graph.topics()) {
    list.add(to_json(name, topic));
    rows.push_back(
        {name, topic.types.empty() ? "-" : joined({topic.types.begin(), topic.types.end()}),
         short_text(nodes_of(topic.publishers)), short_text(nodes_of(topic.subscribers))});
  }
  if (json) return print(list);
  print_table(rows);
}

void show_topic(const std::string& registry, const std::string& name, bool json) {
  const GraphView graph = look_at_graph(registry);
  const auto topics = graph.topics();
  const auto found = topics.find(name);
  if (found == topics.end()) {
    std::vector<std::string> known;
    for (const auto& [topic, ends] : topics) known.push_back(topic);
    throw std::runtime_error("there is no topic " + name + text::nearest_match_hint(name, known));
  }
  const TopicView& topic = found->second;
  if (json) return print(to_json(name, topic));
  std::printf("%s: %s\n", name.c_str(),
              topic.types.empty() ? "type unknown"
                                  : joined({topic.types.begin(), topic.types.end()}).c_str());
  print_ends("publishers", topic.publishers);
  print_ends("subscribers", topic.subscribers);
}

}  // namespace prehend::tools

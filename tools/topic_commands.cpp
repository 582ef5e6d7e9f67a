#include <algorithm>
#include <cstdio>
#include <map>
#include <memory>
#include <set>

#include "prehend/graph/introspection.h"
#include "tools/commands.h"
#include "tools/table.h"
#include "tools/topic_tools.h"

namespace prehend::tools {
namespace {

struct ListedTopic {
  std::set<std::string> types;
  std::vector<std::string> publishers, subscribers;
};

void list_topics(const std::string& registry) {
  std::map<std::string, ListedTopic> topics;
  for (const auto& node : graph::Introspection(registry).nodes()) {
    for (const auto& end : node.publishers()) {
      topics[end.topic()].types.insert(end.schema_name());
      topics[end.topic()].publishers.push_back(node.name());
    }
    for (const auto& end : node.subscribers()) {
      if (!end.schema_name().empty()) topics[end.topic()].types.insert(end.schema_name());
      topics[end.topic()].subscribers.push_back(node.name());
    }
  }
  std::vector<std::vector<std::string>> rows{{"TOPIC", "TYPE", "PUBLISHERS", "SUBSCRIBERS"}};
  const auto names = [](const std::vector<std::string>& list) {
    if (list.empty()) return std::string("-");
    return list.size() > 3 ? std::to_string(list.size()) + " nodes" : joined(list);
  };
  for (const auto& [name, topic] : topics) {
    rows.push_back({name,
                    topic.types.empty() ? "-" : joined({topic.types.begin(), topic.types.end()}),
                    names(topic.publishers), names(topic.subscribers)});
  }
  print_table(rows);
}

}  // namespace

void add_topic_commands(CLI::App& app, Outcome& outcome) {
  CLI::App* group = app.add_subcommand("topic", "Look at, measure and publish topics");
  group->require_subcommand(1);

  auto registry = std::make_shared<std::string>();
  CLI::App* list = group->add_subcommand("list", "List all topics with their types and nodes");
  add_registry_option(*list, *registry);
  list->footer("Example:\n  prehend topic list");
  list->callback([registry] { list_topics(*registry); });

  auto echo = std::make_shared<EchoOptions>();
  CLI::App* echo_command = group->add_subcommand("echo", "Print the messages of a topic");
  echo_command->add_option("topic", echo->topic, "The topic")->required();
  echo_command->add_option("-n,--count", echo->count, "Messages to print; 0: until Ctrl-C");
  echo_command->add_flag("--full", echo->full, "Print long byte fields and lists, too");
  echo_command->add_flag("--wait", echo->wait, "Wait for a topic that nobody publishes yet");
  add_registry_option(*echo_command, echo->registry);
  echo_command->footer(
      "Examples:\n"
      "  prehend topic echo /gripper/state\n"
      "  prehend topic echo /camera/info -n 1 --wait");
  echo_command->callback([echo, &outcome] { outcome.exit_code = echo_topic(*echo); });

  auto rate = std::make_shared<RateOptions>();
  CLI::App* rate_command = group->add_subcommand(
      "hz", "Measure a topic: messages and bytes a second, intervals, losses");
  rate_command->add_option("topic", rate->topic, "The topic")->required();
  rate_command->add_option("-d,--duration", rate->duration, "Seconds to measure; 0: until Ctrl-C")
      ->check(CLI::NonNegativeNumber);
  add_registry_option(*rate_command, rate->registry);
  rate_command->footer("Example:\n  prehend topic hz /tactile/left --duration 5");
  rate_command->callback([rate, &outcome] { outcome.exit_code = measure_topic(*rate); });

  auto publish = std::make_shared<PublishOptions>();
  CLI::App* publish_command =
      group->add_subcommand("pub", "Publish a message given as protobuf text");
  publish_command->add_option("topic", publish->topic, "The topic")->required();
  publish_command->add_option("message", publish->text, "The message, e.g. 'mode: STOP'")
      ->required();
  publish_command->add_option("--type", publish->type,
                              "Its type; default: that of the topic's publishers or subscribers");
  publish_command->add_option("-r,--rate", publish->rate, "Messages a second; 0: one message only")
      ->check(CLI::NonNegativeNumber);
  publish_command->add_option("--wait", publish->wait, "Longest wait for a subscriber [s]")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  add_registry_option(*publish_command, publish->registry);
  publish_command->footer(
      "Example:\n"
      "  prehend topic pub /gripper/command 'mode: VELOCITY value: -0.02' --rate 10");
  publish_command->callback([publish, &outcome] { outcome.exit_code = publish_topic(*publish); });
}

}  // namespace prehend::tools

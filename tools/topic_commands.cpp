#include <memory>

#include "prehend/text/command_line.h"
#include "tools/commands.h"
#include "tools/topic_echo.h"
#include "tools/topic_list.h"
#include "tools/topic_measure.h"
#include "tools/topic_publish.h"

namespace prehend::tools {
namespace {

struct ListChoices {
  std::string registry, topic;
  bool json = false;
};

void add_list(CLI::App& group) {
  auto choices = std::make_shared<ListChoices>();
  CLI::App* list = group.add_subcommand("list", "List all topics with their types and nodes");
  add_registry_option(*list, choices->registry);
  add_json_option(*list, choices->json);
  list->footer("Example:\n  prehend topic list");
  list->callback([choices] { list_topics(choices->registry, choices->json); });
  CLI::App* info = group.add_subcommand(
      "info", "Show a topic's type, publishers and subscribers with rates and losses");
  info->add_option("topic", choices->topic, "The topic")->required();
  add_registry_option(*info, choices->registry);
  add_json_option(*info, choices->json);
  info->footer("Example:\n  prehend topic info /camera/stereo");
  info->callback([choices] { show_topic(choices->registry, choices->topic, choices->json); });
}

void add_echo(CLI::App& group, Outcome& outcome) {
  auto echo = std::make_shared<EchoOptions>();
  CLI::App* command = group.add_subcommand("echo", "Print the messages of a topic");
  command->add_option("topic", echo->topic, "The topic")->required();
  command->add_option("-n,--count", echo->count,
                      "Messages to print, of what is latched the newest; 0: until Ctrl-C");
  command->add_flag("--full", echo->full, "Print long byte fields and lists, too");
  command->add_flag("--wait", echo->wait, "Wait for a topic that nobody publishes yet");
  add_registry_option(*command, echo->registry);
  add_json_option(*command, echo->json);
  command->footer(
      "Examples:\n"
      "  prehend topic echo /gripper/state\n"
      "  prehend topic echo /camera/info -n 1 --wait");
  command->callback([echo, &outcome] { outcome.exit_code = echo_topic(*echo); });
}

void add_measure(CLI::App& group, Outcome& outcome, const std::string& name,
                 MeasureOptions::Quantity quantity, const std::string& description) {
  auto options = std::make_shared<MeasureOptions>();
  options->quantity = quantity;
  CLI::App* command = group.add_subcommand(name, description);
  command->add_option("topic", options->topic, "The topic")->required();
  command->add_option("-d,--duration", options->duration, "Seconds to measure; 0: until Ctrl-C")
      ->check(text::above_zero(true));
  command->add_option("-n,--count", options->count, "Messages to measure; 0: until Ctrl-C");
  command
      ->add_option("-w,--window", options->window, "Latest messages that the figures are taken of")
      ->check(text::in_range(2, 1000000))
      ->capture_default_str();
  if (quantity == MeasureOptions::Quantity::kDelay) {
    command
        ->add_option("--clock", options->clock,
                     "Clock that stamps are compared with; auto: simulated where somebody "
                     "publishes /clock")
        ->check(CLI::IsMember({"auto", "wall", "simulated"}))
        ->capture_default_str();
  }
  add_registry_option(*command, options->registry);
  add_json_option(*command, options->json);
  command->footer("Example:\n  prehend topic " + name + " /tactile/left --duration 5");
  command->callback([options, &outcome] { outcome.exit_code = measure_topic(*options); });
}

void add_publish(CLI::App& group, Outcome& outcome) {
  auto publish = std::make_shared<PublishOptions>();
  CLI::App* command =
      group.add_subcommand("pub", "Publish a message given as protobuf text or JSON");
  command->add_option("topic", publish->topic, "The topic")->required();
  command->add_option("message", publish->text, "The message, e.g. 'mode: STOP' or '{\"mode\": 0}'")
      ->required();
  command->add_option("--type", publish->type,
                      "Its type; default: that of the topic's publishers or subscribers");
  command->add_option("-r,--rate", publish->rate, "Messages a second; 0: one message only")
      ->check(text::above_zero(true));
  command->add_option("-n,--count", publish->count, "Messages at that rate; 0: until Ctrl-C");
  command->add_option("--wait", publish->wait, "Longest wait for a subscriber [s]")
      ->check(text::above_zero(true))
      ->capture_default_str();
  command->add_flag("--latched", publish->latched,
                    "Keep the last message for late subscribers, as long as this command runs");
  command
      ->add_option("--hold", publish->hold,
                   "With --latched: how long to stay after the last message [s]; 0: until Ctrl-C")
      ->check(text::above_zero(true));
  add_registry_option(*command, publish->registry);
  command->footer(
      "Examples:\n"
      "  prehend topic pub /gripper/command 'mode: VELOCITY value: -0.02' --rate 10\n"
      "  prehend topic pub /camera/info '{\"fx\": 500}' --type prehend.msgs.CameraInfo --latched");
  command->callback([publish, &outcome] { outcome.exit_code = publish_topic(*publish); });
}

}  // namespace

void add_topic_commands(CLI::App& app, Outcome& outcome) {
  CLI::App* group = app.add_subcommand("topic", "Look at, measure and publish topics");
  group->require_subcommand(1);
  add_list(*group);
  add_echo(*group, outcome);
  using Quantity = MeasureOptions::Quantity;
  add_measure(*group, outcome, "hz", Quantity::kRate,
              "Measure how often messages come: rate, intervals, losses");
  add_measure(*group, outcome, "bw", Quantity::kBandwidth,
              "Measure how much comes: bytes a second, sizes of messages");
  add_measure(*group, outcome, "delay", Quantity::kDelay,
              "Measure how old messages are when they come: time of receipt - stamp");
  add_publish(*group, outcome);
}

}  // namespace prehend::tools

// The command `stop`: the emergency stop, and its end.

#include <cstdio>
#include <memory>
#include <stdexcept>

#include "prehend/graph/introspection.h"
#include "prehend/graph/node.h"
#include "tools/command_node.h"
#include "tools/commands.h"
#include "tools/emergency_stop.h"

namespace prehend::tools {
namespace {

struct StopChoices {
  std::string registry, name_space, reason;
  bool resets = false;
};

// A message must be UTF-8, and a stop is not refused for a letter.
std::string sendable(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) >= 0x80) c = '?';
  }
  return text;
}

// Services that stop one device, where nobody stops all of them.
std::string other_stops(const std::string& registry) {
  std::string names;
  for (const auto& node : graph::Introspection(registry).nodes()) {
    for (const auto& offer : node.services()) {
      if (!offer.name().ends_with("/stop") || offer.name().ends_with("emergency_stop/stop"))
        continue;
      names += (names.empty() ? "" : ", ") + offer.name();
    }
  }
  return names;
}

void stop_or_reset(const StopChoices& choices) {
  graph::NodeOptions options = command_node("stop", choices.registry);
  options.name_space = choices.name_space;
  graph::Node node(std::move(options));
  const EmergencyStop emergency(node, "prehend stop");
  const std::string problem =
      choices.resets ? emergency.reset() : emergency.stop(sendable(choices.reason));
  if (problem.empty()) {
    std::puts(choices.resets ? "motion is allowed again"
                             : "all motion is stopped; prehend stop --reset allows it again");
    return;
  }
  if (choices.resets) throw std::runtime_error("not reset: " + problem);
  const std::string others = other_stops(choices.registry);
  throw std::runtime_error(
      "NOT STOPPED: " + problem +
      (others.empty() ? "" : ". What there is instead, by prehend service call: " + others));
}

}  // namespace

void add_stop_command(CLI::App& app) {
  auto choices = std::make_shared<StopChoices>();
  CLI::App* stop = app.add_subcommand(
      "stop", "Emergency stop: stop all motion, and refuse motions until --reset");
  CLI::Option* reason =
      stop->add_option("--reason", choices->reason, "Why, in words: everybody is told");
  stop->add_flag("--reset", choices->resets,
                 "Allow motion again; refused while what caused the stop goes on")
      ->excludes(reason);
  stop->add_option("--namespace", choices->name_space, "Of the robot, where it has one: /left");
  add_registry_option(*stop, choices->registry);
  stop->footer(
      "Examples:\n"
      "  prehend stop\n"
      "  prehend stop --reason \"a hand in the cell\"\n"
      "  prehend stop --reset");
  stop->callback([choices] { stop_or_reset(*choices); });
}

}  // namespace prehend::tools

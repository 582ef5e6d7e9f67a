#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <thread>

#include "prehend/graph/clock_control.h"
#include "prehend/graph/node.h"
#include "prehend/text/quantities.h"
#include "tools/commands.h"

namespace prehend::tools {
namespace {

using msgs::graph::ClockControlRequest;
using msgs::graph::ClockControlResponse;

constexpr auto kPatience = std::chrono::seconds(3);

// Asks whatever publishes /clock, as a node of its own.
class ClockCaller {
 public:
  explicit ClockCaller(const std::string& registry)
      : node_(options(registry)),
        client_(
            node_.client<ClockControlRequest, ClockControlResponse>(graph::kClockControlService)) {
    if (client_.wait_for_server(kPatience)) return;
    throw std::runtime_error(std::string("nobody serves ") + graph::kClockControlService +
                             ": a simulation or a replay that publishes /clock must run");
  }

  ClockControlResponse call(const ClockControlRequest& request) {
    const auto outcome = client_.call(request, kPatience);
    if (!outcome.ok()) throw std::runtime_error(outcome.error());
    if (!outcome->error().empty()) throw std::runtime_error(outcome->error());
    return *outcome;
  }

 private:
  static graph::NodeOptions options(const std::string& registry) {
    graph::NodeOptions result;
    result.name = "clock_" + std::to_string(::getpid());
    result.registry = registry;
    result.log_level = graph::LogLevel::kWarning;
    return result;
  }

  graph::Node node_;
  graph::ServiceClient<ClockControlRequest, ClockControlResponse> client_;
};

struct ClockChoices {
  std::string registry, step;
  double speed = 1;
  bool json = false, no_wait = false;
};

void print(const ClockControlResponse& state, bool json) {
  if (json) {
    std::printf("{\"time\": %lld, \"paused\": %s, \"speed\": %.17g}\n",
                static_cast<long long>(state.time()), state.paused() ? "true" : "false",
                state.speed());
    return;
  }
  const std::string speed =
      state.speed() > 0 ? std::to_string(state.speed()) + " x" : "as fast as it goes";
  std::printf("%lld.%09lld s, %s, speed %s\n", static_cast<long long>(state.time() / 1000000000),
              static_cast<long long>(state.time() % 1000000000),
              state.paused() ? "paused" : "running", speed.c_str());
}

void run(const ClockChoices& choices, ClockControlRequest request) {
  ClockCaller caller(choices.registry);
  ClockControlResponse state = caller.call(request);
  // A step goes at the clock's speed; what is printed is where it ended.
  while (request.command() == ClockControlRequest::STEP && !choices.no_wait && !state.paused()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    state = caller.call({});
  }
  print(state, choices.json);
}

CLI::App* add_command(CLI::App& group, const std::shared_ptr<ClockChoices>& choices,
                      const std::string& name, const std::string& description,
                      ClockControlRequest::Command command) {
  CLI::App* app = group.add_subcommand(name, description);
  add_registry_option(*app, choices->registry);
  app->add_flag("--json", choices->json, "Print JSON: time [ns], paused, speed");
  app->callback([choices, command] {
    ClockControlRequest request;
    request.set_command(command);
    if (command == ClockControlRequest::STEP) request.set_step(text::parse_duration(choices->step));
    request.set_speed(choices->speed);
    run(*choices, request);
  });
  return app;
}

}  // namespace

void add_clock_commands(CLI::App& app) {
  CLI::App* group = app.add_subcommand(
      "clock", "Pause, step and speed up the clock that a simulation or a replay publishes");
  group->require_subcommand(1);
  auto choices = std::make_shared<ClockChoices>();
  add_command(*group, choices, "status", "Print time, pause and speed", ClockControlRequest::STATUS)
      ->footer("Example:\n  prehend clock status");
  add_command(*group, choices, "pause", "Stop the clock and with it all who follow it",
              ClockControlRequest::PAUSE)
      ->footer("Example:\n  prehend clock pause");
  add_command(*group, choices, "resume", "Let the clock go on", ClockControlRequest::RESUME)
      ->footer("Example:\n  prehend clock resume");
  CLI::App* step = add_command(*group, choices, "step", "While paused: go on for exactly this long",
                               ClockControlRequest::STEP);
  step->add_option("duration", choices->step, "With unit: 10ms, 0.5s, 1000000ns")->required();
  step->add_flag("--no-wait", choices->no_wait, "Do not wait until the step is done");
  step->footer("Example:\n  prehend clock pause; prehend clock step 10ms");
  CLI::App* speed = add_command(*group, choices, "speed", "Set seconds per wall second",
                                ClockControlRequest::SET_SPEED);
  speed->add_option("factor", choices->speed, "0: as fast as it goes")->required();
  speed->footer("Example:\n  prehend clock speed 0.5");
}

}  // namespace prehend::tools

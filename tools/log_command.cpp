// `prehend log`: what nodes say on /log.

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <memory>
#include <vector>

#include "tools/command_node.h"
#include "tools/commands.h"
#include "tools/graph_view.h"
#include "tools/json.h"

namespace prehend::tools {
namespace {

using msgs::graph::LogLine;

constexpr double kGathering = 0.4;  // in which nodes send the lines they kept [s]

struct LogChoices {
  std::string registry, level = "info";
  std::vector<std::string> nodes;
  std::uint64_t count = 0;
  bool no_follow = false, json = false;
};

constexpr const char* kLevels[] = {"debug", "info", "warning", "error"};

const char* level_name(const LogLine& line) {
  return kLevels[std::clamp(static_cast<int>(line.level()), 0, 3)];
}

// Of the wall clock as the time of day, of a simulated one as seconds.
std::string time_text(std::int64_t stamp) {
  const auto seconds = static_cast<std::time_t>(stamp / 1'000'000'000);
  std::tm local{};
  if (seconds < 1'000'000'000 || !::localtime_r(&seconds, &local)) {
    return fmt::format("{:.3f}", graph::seconds(stamp));
  }
  return fmt::format("{:02}:{:02}:{:02}.{:03}", local.tm_hour, local.tm_min, local.tm_sec,
                     stamp / 1'000'000 % 1000);
}

void print_line(const LogLine& line, bool json) {
  if (json) {
    return print(Json::object()
                     .set("stamp", Json::stamp(line.stamp()))
                     .set("level", level_name(line))
                     .set("node", line.node())
                     .set("text", line.text()));
  }
  const char* colour = "";
  if (::isatty(STDOUT_FILENO) == 1 && line.level() >= msgs::graph::WARNING) {
    colour = line.level() == msgs::graph::ERROR ? "\x1b[31m" : "\x1b[33m";
  }
  std::printf("%s[%s] [%s] [%s] %s%s\n", colour, time_text(line.stamp()).c_str(), level_name(line),
              line.node().c_str(), line.text().c_str(), *colour ? "\x1b[0m" : "");
  std::fflush(stdout);
}

// Kept lines come node by node; they are put into the order of their times before the first is
// printed.
class LogPrinter {
 public:
  LogPrinter(const LogChoices& choices, std::function<void()> on_last)
      : choices_(choices), on_last_(std::move(on_last)) {
    least_ = std::find(std::begin(kLevels), std::end(kLevels), choices.level) - kLevels;
  }
  void take(const LogLine& line) {
    if (line.level() < least_) return;
    if (!choices_.nodes.empty() && std::find(choices_.nodes.begin(), choices_.nodes.end(),
                                             line.node()) == choices_.nodes.end()) {
      return;
    }
    gathered_.push_back(line);
    if (!gathering_) print_gathered();
  }
  void end_gathering() {
    if (!std::exchange(gathering_, false)) return;
    std::stable_sort(gathered_.begin(), gathered_.end(),
                     [](const auto& a, const auto& b) { return a.stamp() < b.stamp(); });
    print_gathered();
    if (choices_.no_follow) on_last_();
  }

 private:
  void print_gathered() {
    for (const LogLine& line : gathered_) {
      if (choices_.count > 0 && printed_ == choices_.count) break;
      print_line(line, choices_.json);
      if (++printed_ == choices_.count) on_last_();
    }
    gathered_.clear();
  }

  const LogChoices& choices_;
  const std::function<void()> on_last_;
  std::ptrdiff_t least_ = 0;
  std::vector<LogLine> gathered_;
  bool gathering_ = true;
  std::uint64_t printed_ = 0;
};

int follow_log(const LogChoices& choices) {
  if (!choices.nodes.empty()) {
    const GraphView graph = look_at_graph(choices.registry);
    for (const std::string& name : choices.nodes) graph.node(name);
  }
  return run_as_node("log", choices.registry, [&](graph::Node& node) {
    LogPrinter printer(choices, [&] { node.shutdown(); });
    const auto subscription =
        node.subscribe<LogLine>("/log", graph::QoS::queue(10000),
                                [&](const graph::Received<LogLine>& line) { printer.take(*line); });
    const auto timer = node.create_timer(kGathering, [&] { printer.end_gathering(); });
    node.spin();
  });
}

}  // namespace

void add_log_command(CLI::App& app, Outcome& outcome) {
  auto choices = std::make_shared<LogChoices>();
  CLI::App* command =
      app.add_subcommand("log", "Follow what all nodes log, beginning with their last 100 lines");
  command->add_option("-l,--level", choices->level, "Least level that is shown")
      ->check(CLI::IsMember({"debug", "info", "warning", "error"}))
      ->capture_default_str();
  command->add_option("--node", choices->nodes, "Only of this node; may be repeated")
      ->allow_extra_args(false);
  command->add_option("-n,--count", choices->count, "Lines to print; 0: until Ctrl-C");
  command->add_flag("--no-follow", choices->no_follow, "End after the lines that are there");
  add_registry_option(*command, choices->registry);
  add_json_option(*command, choices->json);
  command->footer(
      "A node keeps and publishes lines of its --log-level and above.\n\n"
      "Example:\n  prehend log --level warning --node simulation");
  command->callback([choices, &outcome] { outcome.exit_code = follow_log(*choices); });
}

}  // namespace prehend::tools

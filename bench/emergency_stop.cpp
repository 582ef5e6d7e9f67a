// How long an emergency stop takes, with all emulators: arm and hand move, the stop is asked for
// (or a required driver is killed, or the node that stops), and the emulated robot is watched in
// its world: the last set point that moves it, the last moment at its full speed, its standstill.
// Times in ms from the call that asks, or the kill. The world tells its joints each 10 ms.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>

#include "bench/figures.h"
#include "tests/system/stop_rig.h"

namespace {

using prehend::bench::Figures;
using prehend::testing::StoppedRobot;
using prehend::testing::StopRig;

struct Times {
  std::vector<double> told, command, slower, stands;  // ms
};

double milliseconds(StopRig::Time from, StopRig::Time to) {
  return std::chrono::duration<double, std::milli>(to - from).count();
}

void add(Times& times, const StopRig::Track& track, StopRig::Time from) {
  times.command.push_back(track.command ? milliseconds(from, *track.command) : 0);
  times.slower.push_back(track.slower ? milliseconds(from, *track.slower) : 0);
  if (track.stands) times.stands.push_back(milliseconds(from, *track.stands));
}

double median(const std::vector<double>& sorted) { return sorted[sorted.size() / 2]; }

std::string in_words(const std::vector<double>& sorted) {
  if (sorted.empty()) return "-";
  char text[64];
  std::snprintf(text, sizeof text, "%.0f (%.0f)", median(sorted), sorted.back());
  return text;
}

void tell(const std::string& robot, const std::string& what, Times times, bool has_commands,
          Figures& figures) {
  if (!has_commands) times.command.clear();
  const std::pair<const char*, std::vector<double>*> all[] = {{"told", &times.told},
                                                              {"last_command", &times.command},
                                                              {"full_speed", &times.slower},
                                                              {"stands", &times.stands}};
  nlohmann::json row;
  std::printf("  %-28s", what.c_str());
  for (const auto& [name, values] : all) {
    std::sort(values->begin(), values->end());
    std::printf(" %-12s", in_words(*values).c_str());
    if (values->empty()) continue;
    row[std::string(name) + "_ms"] = median(*values);
    row[std::string(name) + "_largest_ms"] = values->back();
  }
  std::printf("\n");
  figures.add(robot + ": " + what, row);
}

// "" or what went wrong.
std::string measure(StopRig& rig, const StoppedRobot& robot, const std::string& killed,
                    int repetitions, Figures& figures) {
  Times arm, hand;
  for (int i = 0; i < repetitions; ++i) {
    if (std::string problem = rig.move(); !problem.empty()) return problem;
    std::this_thread::sleep_for(std::chrono::milliseconds(700 + 37 * i));  // near its full speed
    const StopRig::Time from = std::chrono::steady_clock::now();
    if (killed.empty()) {
      if (!rig.stop("measured").success()) return "nobody answers the stop";
    } else if (!rig.kill(killed)) {
      return "there is no process " + killed;
    }
    if (!rig.wait_until_stands(from, std::chrono::seconds(10))) return "it does not stand";
    if (const auto told = rig.told_stopped(); told && killed != "emergency_stop") {
      arm.told.push_back(milliseconds(from, *told));
      hand.told.push_back(milliseconds(from, *told));
    }
    add(arm, rig.arm_since(from), from);
    add(hand, rig.hand_since(from), from);
    rig.reasons();  // both have ended
    if (killed == "emergency_stop") rig.start_emergency_stop();
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (!(rig.is_stopped() && rig.reset().success())) {
      if (std::chrono::steady_clock::now() > end) return "it is not reset";
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(800));
  }
  const std::string cause = killed.empty() ? "stop" : "kill -9 " + killed;
  tell(robot.name, "arm, " + cause, arm, !robot.arm_set_points.empty(), figures);
  tell(robot.name, "hand, " + cause, hand, !robot.hand_set_points.empty(), figures);
  return "";
}

}  // namespace

int main(int argc, char** argv) {
  int repetitions = 5;
  CLI::App app("How long an emergency stop takes, with all emulators.");
  app.add_option("--repetitions", repetitions, "Stops of each kind")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  std::string json;
  app.add_option("--json", json, "File for the figures, too");
  CLI11_PARSE(app, argc, argv);
  Figures figures;
  std::printf("ms from the stop: median (largest) of %d\n", repetitions);
  std::printf("  %-28s %-12s %-12s %-12s %-12s\n", "", "told", "last command", "full speed",
              "stands");
  for (const StoppedRobot& robot : prehend::testing::stopped_robots()) {
    std::printf("%s\n", robot.name.c_str());
    StopRig rig(robot);
    std::string problem = rig.wait_until_ready();
    if (problem.empty()) problem = measure(rig, robot, "", repetitions, figures);
    if (problem.empty()) problem = measure(rig, robot, robot.required.back(), repetitions, figures);
    if (problem.empty()) problem = measure(rig, robot, "emergency_stop", repetitions, figures);
    if (problem.empty()) continue;
    std::printf("  %s\n", problem.c_str());
    return 1;
  }
  figures.write(json);
  return 0;
}

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

#include "tests/system/stop_rig.h"

namespace {

using prehend::testing::StoppedRobot;
using prehend::testing::StopRig;

struct Figures {
  std::vector<double> told, command, slower, stands;
};

double milliseconds(StopRig::Time from, StopRig::Time to) {
  return std::chrono::duration<double, std::milli>(to - from).count();
}

void add(Figures& figures, const StopRig::Track& track, StopRig::Time from) {
  figures.command.push_back(track.command ? milliseconds(from, *track.command) : 0);
  figures.slower.push_back(track.slower ? milliseconds(from, *track.slower) : 0);
  if (track.stands) figures.stands.push_back(milliseconds(from, *track.stands));
}

std::string in_words(std::vector<double> values) {
  if (values.empty()) return "-";
  std::sort(values.begin(), values.end());
  char text[64];
  std::snprintf(text, sizeof text, "%.0f (%.0f)", values[values.size() / 2], values.back());
  return text;
}

void print(const std::string& what, const Figures& figures, bool has_commands) {
  std::printf("  %-28s %-12s %-12s %-12s %-12s\n", what.c_str(), in_words(figures.told).c_str(),
              has_commands ? in_words(figures.command).c_str() : "-",
              in_words(figures.slower).c_str(), in_words(figures.stands).c_str());
}

// "" or what went wrong.
std::string measure(StopRig& rig, const StoppedRobot& robot, const std::string& killed,
                    int repetitions) {
  Figures arm, hand;
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
  print("arm, " + cause, arm, !robot.arm_set_points.empty());
  print("hand, " + cause, hand, !robot.hand_set_points.empty());
  return "";
}

}  // namespace

int main(int argc, char** argv) {
  int repetitions = 5;
  CLI::App app("How long an emergency stop takes, with all emulators.");
  app.add_option("--repetitions", repetitions, "Stops of each kind")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  std::printf("ms from the stop: median (largest) of %d\n", repetitions);
  std::printf("  %-28s %-12s %-12s %-12s %-12s\n", "", "told", "last command", "full speed",
              "stands");
  for (const StoppedRobot& robot : prehend::testing::stopped_robots()) {
    std::printf("%s\n", robot.name.c_str());
    StopRig rig(robot);
    std::string problem = rig.wait_until_ready();
    if (problem.empty()) problem = measure(rig, robot, "", repetitions);
    if (problem.empty()) problem = measure(rig, robot, robot.required.back(), repetitions);
    if (problem.empty()) problem = measure(rig, robot, "emergency_stop", repetitions);
    if (problem.empty()) continue;
    std::printf("  %s\n", problem.c_str());
    return 1;
  }
  return 0;
}

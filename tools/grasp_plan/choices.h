#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace prehend::tools {

/// The tree's folder config, wherever the program is started.
std::string own_config();

/// What `prehend plan` is asked for.
struct PlanChoices {
  std::string file;
  std::optional<double> scale;       // m per unit of the file
  std::string viewpoint, up, table;  // of a cloud, see perception/recorded_cloud.h
  std::string split;                 // empty: tops
  bool in_place = false;
  int object = 0;
  std::optional<int> alternatives;  // 2 for a cloud
  double tolerance = 0;             // m, of a cloud's meshes; 0: none asked for
  std::string hand = "pg70";
  std::string platform;  // its hand counts; empty: none
  std::string approach = "any";
  std::vector<std::string> generators;
  std::vector<std::string> preshapes;
  std::vector<double> move;
  std::string path_planner, collision_checker;  // of the arm; empty: the defaults
  double remedy_budget = 10;                    // s
  std::map<std::string, double> grasp_knobs, arm_knobs, decision_knobs;  // that were given, by name
  std::uint64_t seed = 1;
  int rows = 10;
  std::string config = own_config();
  std::string database;
  std::string known;
  std::string out;
  std::string save;
  bool json = false;
};

/// Declares the options of `prehend plan` on `command`.
void add_plan_options(CLI::App& command, PlanChoices& choices);

}  // namespace prehend::tools

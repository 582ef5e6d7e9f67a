#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace prehend::tools {

/// Options of `prehend hand` and of the program that it becomes.
struct HandChoices {
  std::string command;  // learn
  std::string file, out, palm, on;
  double friction = 0.6, least_sure = 0.25;
  bool overwrite = false;
};

/// Adds its commands. `choices` lives as long as the app.
void add_hand_options(CLI::App& app, HandChoices& choices);

}  // namespace prehend::tools

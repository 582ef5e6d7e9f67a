#pragma once

#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace prehend::tools {

/// Options of `prehend jog`, `home` and `hand`, and of the program that they become.
struct JogChoices {
  std::string platform, registry;
  std::string table = "0";   // m, or none
  double clearance = 0.005;  // m
  double patience = 5;       // s
  double speed = 0;          // share; 0: the command's own
  std::string preshape;
  // jog
  double hold = 0.15;  // s
  // home
  std::string home = "home";
  bool keep_hand = false;
  // hand
  std::string what;
  double force = 0;  // N; 0: as the hand can
};

void add_jog_options(CLI::App& command, JogChoices& choices);
void add_home_options(CLI::App& command, JogChoices& choices);
void add_hand_options(CLI::App& command, JogChoices& choices);

/// A command with what it says of itself.
struct JogCommand {
  const char* name;
  const char* about;
  const char* footer;
  void (*add_options)(CLI::App&, JogChoices&);
};
const std::vector<JogCommand>& jog_commands();

/// Height of the table in the world [m], none for "none". @throws std::invalid_argument otherwise.
std::optional<double> table_height(const std::string& text);

}  // namespace prehend::tools

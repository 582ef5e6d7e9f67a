#pragma once

#include <CLI/CLI.hpp>

#include <string>

namespace prehend::tools {

/// What a command leaves behind for main: the exit code.
struct Outcome {
  int exit_code = 0;
};

/// Each adds its commands to the `prehend` program. A command throws std::exception with one clear
/// line when it fails. `outcome` must outlive the app's parsing.
void add_launch_command(CLI::App& app, Outcome& outcome);
void add_node_commands(CLI::App& app);
void add_topic_commands(CLI::App& app, Outcome& outcome);
void add_service_commands(CLI::App& app);
void add_param_commands(CLI::App& app);
void add_recording_commands(CLI::App& app);
void add_bag_commands(CLI::App& app, Outcome& outcome);

/// Option --registry of a command.
void add_registry_option(CLI::App& command, std::string& registry);

}  // namespace prehend::tools

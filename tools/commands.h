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
void add_offer_commands(CLI::App& app, Outcome& outcome);
void add_param_commands(CLI::App& app);
void add_stop_command(CLI::App& app);
void add_log_command(CLI::App& app, Outcome& outcome);
void add_graph_command(CLI::App& app);
void add_doctor_command(CLI::App& app, Outcome& outcome);
void add_completion_command(CLI::App& app);
void add_explain_command(CLI::App& app);
void add_clutter_command(CLI::App& app);
void add_sweep_command(CLI::App& app);
void add_plan_command(CLI::App& app);
void add_model_command(CLI::App& app);
void add_calibrate_command(CLI::App& app);
void add_jog_commands(CLI::App& app);
void add_hand_command(CLI::App& app);  // after those
void add_grasps_command(CLI::App& app);
void add_keys_commands(CLI::App& app);
void add_clock_commands(CLI::App& app);
void add_recording_commands(CLI::App& app);
void add_bag_commands(CLI::App& app, Outcome& outcome);

/// Options --keys and --bind of a command that joins a graph or starts one.
void add_security_options(CLI::App& command);
/// Option --registry of a command, and those above.
void add_registry_option(CLI::App& command, std::string& registry);

/// What a shell asks by `prehend __complete WORD...`: prints a line for each word that can stand in
/// the place of the last one.
void print_completions(CLI::App& app, int argc, char** argv);

/// Option --json of a command.
void add_json_option(CLI::App& command, bool& json);

}  // namespace prehend::tools

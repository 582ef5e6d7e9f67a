// The `prehend` command: starts graphs, looks into running ones, handles recordings.

#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "tools/commands.h"
#include "tools/mistyped.h"
#include "tools/version.h"

void prehend::tools::add_json_option(CLI::App& command, bool& json) {
  command.add_flag("--json", json, "Print JSON, for programs");
}

int main(int argc, char** argv) {
  using namespace prehend::tools;
  CLI::App app(
      "prehend: a robot grasps objects it never saw. Starts graphs of nodes, looks into "
      "running ones, and handles recordings.",
      "prehend");
  app.footer(
      "Examples:\n"
      "  prehend launch launch/demo.yaml scene:=table_objects\n"
      "  prehend node list\n"
      "  prehend topic echo /gripper/state\n"
      "  prehend stop\n"
      "  prehend doctor\n"
      "  prehend jog\n"
      "  prehend explain config/scenes/demo.yaml\n"
      "  prehend plan object.ply --hand pg70 --out out/plan\n"
      "  prehend record -o run.mcap\n"
      "Each command explains itself: prehend topic echo --help");
  app.require_subcommand(1);
  app.set_version_flag("--version", std::string("prehend ") + kVersion,
                       "Print the version and exit");
  Outcome outcome;
  add_launch_command(app, outcome);
  add_node_commands(app);
  add_topic_commands(app, outcome);
  add_offer_commands(app, outcome);
  add_param_commands(app);
  add_stop_command(app);
  add_log_command(app, outcome);
  add_graph_command(app);
  add_doctor_command(app, outcome);
  add_explain_command(app);
  add_clutter_command(app);
  add_sweep_command(app);
  add_plan_command(app);
  add_model_command(app);
  add_calibrate_command(app);
  add_jog_commands(app);
  add_hand_command(app);
  add_grasps_command(app);
  add_keys_commands(app);
  add_clock_commands(app);
  add_recording_commands(app);
  add_bag_commands(app, outcome);
  add_completion_command(app);
  if (argc > 1 && std::string(argv[1]) == "__complete") {
    print_completions(app, argc, argv);
    return 0;
  }
  std::vector<std::string> words(argv + 1, argv + argc);
  if (!words.empty() && words.front() == "__parse") {
    words.erase(words.begin());
    // For a check of written commands: what they would do is left out.
    app.parse_complete_callback([] { throw CLI::Success(); });
  }
  if (const std::string wrong = mistyped(app, words); !wrong.empty()) {
    std::fprintf(stderr, "%s\n", wrong.c_str());
    return 2;
  }
  try {
    app.parse(std::vector<std::string>(words.rbegin(), words.rend()));  // CLI11 takes them reversed
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "prehend: %s\n", error.what());
    return 1;
  }
  return outcome.exit_code;
}

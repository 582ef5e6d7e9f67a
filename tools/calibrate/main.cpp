// calibrate COMMAND ... : what `prehend calibrate` becomes; see there.

#include <cstdio>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include "prehend/text/command_line.h"
#include "tools/calibrate/runs.h"

int main(int argc, char** argv) {
  using namespace prehend::tools;
  CLI::App app{"Calibrates cameras, where they are, the table and force sensors"};
  app.require_subcommand(1);
  struct Run {
    const char* name;
    void (*run)(const CalibrateChoices&);
  };
  static constexpr Run kRuns[] = {
      {"camera", run_calibrate_camera},     {"stereo", run_calibrate_stereo},
      {"hand-eye", run_calibrate_hand_eye}, {"poses", run_calibrate_poses},
      {"collect", run_calibrate_collect},   {"table", run_calibrate_table},
      {"wrench", run_calibrate_wrench},     {"board", run_calibrate_board}};
  std::string name;
  void (*run)(const CalibrateChoices&) = nullptr;
  std::vector<std::unique_ptr<CalibrateChoices>> all;
  const CalibrateChoices* chosen = nullptr;
  for (const CalibrateCommand& one : calibrate_commands()) {
    all.push_back(std::make_unique<CalibrateChoices>());
    CLI::App* command = app.add_subcommand(one.name, one.about);
    one.add_options(*command, *all.back());
    command->callback([&, at = all.back().get(), command] {
      chosen = at;
      name = command->get_name();
      for (const Run& candidate : kRuns) {
        if (name == candidate.name) run = candidate.run;
      }
    });
  }
  if (const auto code = prehend::text::parse_command_line(app, argc, argv)) return *code;
  try {
    run(*chosen);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "prehend calibrate %s: %s\n", name.c_str(), error.what());
    return 1;
  }
  return 0;
}

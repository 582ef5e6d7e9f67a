// jog COMMAND ... : what `prehend jog`, `home` and `hand` become; see there.

#include <cstdio>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include "prehend/text/command_line.h"
#include "tools/jog/runs.h"

int main(int argc, char** argv) {
  using namespace prehend::tools;
  CLI::App app{"Moves a robot by hand"};
  app.require_subcommand(1);
  struct Run {
    const char* name;
    int (*run)(const JogChoices&);
  };
  static constexpr Run kRuns[] = {{"jog", run_jog}, {"home", run_home}, {"hand", run_hand}};
  std::string name;
  std::vector<std::unique_ptr<JogChoices>> all;
  const JogChoices* chosen = nullptr;
  for (const JogCommand& one : jog_commands()) {
    all.push_back(std::make_unique<JogChoices>());
    CLI::App* command = app.add_subcommand(one.name, one.about);
    one.add_options(*command, *all.back());
    command->add_option("--registry", all.back()->registry, "Endpoint of the registry");
    command->callback([&, at = all.back().get(), command] {
      chosen = at;
      name = command->get_name();
    });
  }
  if (const auto code = prehend::text::parse_command_line(app, argc, argv)) return *code;
  try {
    for (const Run& one : kRuns) {
      if (name == one.name) return one.run(*chosen);
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "prehend %s: %s\n", name.c_str(), error.what());
  }
  return 1;
}

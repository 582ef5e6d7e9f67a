// Independent runs of a program: what `prehend sweep` starts.

#include <cstdio>
#include <exception>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "tools/sweep/choices.h"
#include "tools/sweep/run_sweep.h"

int main(int argc, char** argv) {
  using namespace prehend;
  CLI::App app("Independent runs of a program, for every combination of its options", "sweep");
  tools::SweepChoices choices;
  tools::add_sweep_options(app, choices);
  try {
    app.parse(argc, argv);
    return tools::run_sweep(choices);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "prehend sweep: {}\n", error.what());
    return 1;
  }
}

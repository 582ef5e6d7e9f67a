// Where the whole chain works, where it refuses, and whether it is ever wrong in silence. Writes
// docs/chain_extremes.md and its picture.

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include "eval/case_choice.h"
#include "eval/case_runs.h"
#include "eval/grasp/chain_extremes.h"
#include "eval/text_files.h"
#include "prehend/geometry/errors.h"

namespace {

using namespace prehend;
namespace fs = std::filesystem;

constexpr double kPatience = 600;  // s, after which a case counts as hung, and its process ends

struct Options {
  eval::CaseRunOptions runs{.out = "out/chain_extremes", .timeout = kPatience};
  fs::path platform = "config/robots/stage_pg70.yaml";
  bool coarse = false;
};

int run(Options options) {
  const eval::PlatformUnderTest platform(options.platform);
  const eval::ExtremeGrid grid = eval::extreme_grid(options.coarse);
  const std::vector<eval::ExtremeCase> cases = grid.cases();
  std::vector<std::string> names;
  for (const eval::ExtremeCase& one : cases) names.push_back(one.name());
  options.runs.setting = options.platform.string();
  const auto outcomes = eval::run_cases(options.runs, names, eval::read_extreme_result, [&](int i) {
    return eval::run_extreme_case(cases[i], platform);
  });
  eval::ExtremeResults results;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (outcomes[i].result) results[names[i]] = *outcomes[i].result;
  }
  const eval::ExtremeTotals sum = eval::totals(cases, results);
  std::printf("%d cases: %d work, %d refused, %d said, %d silent, %d crashed\n", sum.cases,
              sum.works, sum.refused, sum.said, sum.silent, sum.crashed);
  std::string command = "build/bin/eval_chain_extremes";
  if (options.coarse) command += " --coarse";
  if (options.platform != Options().platform) command += " --platform " + options.platform.string();
  const std::string picture = "chain_extremes.svg";
  const fs::path page = options.runs.out / "chain_extremes.md";
  eval::write_text(options.runs.out / picture, eval::extremes_picture(grid, results));
  eval::write_text(page, eval::extremes_page(grid, results, command, picture));
  std::printf("%s\n", page.c_str());
  return results.size() == cases.size() ? EXIT_SUCCESS : EXIT_FAILURE;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app(
      "Runs the whole chain, from a rendered depth picture to the lift in simulation, where "
      "points, "
      "size, distance, noise, outliers, tilt, view, mass or friction are far from the usual. Says "
      "where it works, where it refuses, and where it is wrong and does not know it. The same "
      "figures every time.");
  app.add_option("--out", options.runs.out,
                 "folder of the page, its picture, and the cases' results")
      ->capture_default_str();
  app.add_option("--platform", options.platform, "file of an arm and its hand")
      ->check(CLI::ExistingFile)
      ->capture_default_str();
  app.add_flag("--coarse", options.coarse, "the ends of each axis, one object, one seed");
  eval::add_run_options(app, options.runs);
  return eval::parse_and_run(app, argc, argv, [&options] { return run(options); });
}

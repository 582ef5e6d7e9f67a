#include "tools/sweep/said.h"

#include <cstdio>
#include <sstream>

#include <fmt/format.h>

namespace prehend::tools {
namespace {

constexpr int kMostShown = 20;  // failed cases with what they printed

}  // namespace

bool print_status(const sweep::Cases& cases, const sweep::FindResult& find,
                  const std::string& command) {
  std::int64_t done = 0, failed = 0;
  std::string failures;
  for (std::int64_t i = 0; i < cases.size(); ++i) {
    const std::string name = cases.at(i).name;
    const auto result = find(name);
    if (!result) continue;
    ++(result->failed() ? failed : done);
    if (!result->failed() || failed > kMostShown) continue;
    failures += fmt::format("{}: {}\n", name, result->problem);
    std::istringstream lines(result->output);
    for (std::string line; std::getline(lines, line);) failures += "    " + line + "\n";
  }
  fmt::print("{} cases: {} done, {} failed, {} open\n{}", cases.size(), done, failed,
             cases.size() - done - failed, failures);
  if (failed > kMostShown) fmt::print("... and {} more that failed\n", failed - kMostShown);
  if (failed > 0) {
    fmt::print("Run them again by `{} --again failed`, one alone by --again NAME\n", command);
  }
  std::fflush(stdout);
  return done == cases.size();
}

}  // namespace prehend::tools

// A parameter that a node reads once, when it starts, is read-only: else `param set` says that it
// is set, and nothing happens.

#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <sstream>
#include <string>

#include "msgs/graph.pb.h"

namespace prehend::testing {
namespace {

namespace fs = std::filesystem;

std::string output_of(const std::string& command) {
  std::string text;
  FILE* pipe = ::popen((command + " 2>/dev/null").c_str(), "r");
  char buffer[4096];
  for (std::size_t got = 0; (got = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;) {
    text.append(buffer, got);
  }
  EXPECT_EQ(::pclose(pipe), 0) << command;
  return text;
}

// What the sources of nodes look at again: by Node::parameter, or told by on_change.
std::set<std::string> looked_at_again() {
  static const std::regex kRead(R"(parameter<[^(]*>\(\s*"([A-Za-z_.0-9]+)\")");
  static const std::regex kTold(R"(\.name = "([A-Za-z_.0-9]+)\"(?:(?!\.name = )[^}])*\.on_change)");
  // The emulators' faults, by what declares them with on_change (drivers/wire/node).
  static const std::regex kFault(
      R"((?:part|Switch [a-z_]+|LateParameter<[a-z]+> [a-z_]+|[a-z]+_)\(\s*(?:node,\s*)?(?:\{\.name = )?"([a-z_0-9]+)\")");
  std::set<std::string> names;
  for (const char* folder : {"nodes", "drivers"}) {
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      const auto extension = entry.path().extension();
      if (extension != ".cpp" && extension != ".h") continue;
      std::ifstream file(entry.path());
      const std::string text{std::istreambuf_iterator<char>(file), {}};
      for (const std::regex* pattern : {&kRead, &kTold, &kFault}) {
        for (std::sregex_iterator m(text.begin(), text.end(), *pattern), end; m != end; ++m) {
          names.insert((*m)[1]);
        }
      }
    }
  }
  return names;
}

TEST(Parameters, ThatAreReadOnceAreReadOnly) {
  const fs::path programs = std::getenv("PREHEND_BIN");
  const std::set<std::string> again = looked_at_again();
  ASSERT_GT(again.size(), 20u);
  std::istringstream list(output_of((programs / "container").string() + " --list"));
  std::size_t adjustable = 0, fixed = 0;
  for (std::string name; std::getline(list, name);) {
    if (!fs::exists(programs / name)) continue;  // its program is not built
    msgs::graph::NodeProgramDescription description;
    const auto status = google::protobuf::util::JsonStringToMessage(
        output_of((programs / name).string() + " --describe"), &description);
    ASSERT_TRUE(status.ok()) << name << ": " << status.ToString();
    for (const auto& parameter : description.parameters()) {
      ++(parameter.read_only() ? fixed : adjustable);
      EXPECT_TRUE(parameter.read_only() || again.count(parameter.name()) > 0)
          << name << ": parameter " << parameter.name()
          << " can be set while the node runs, which does not look at it again: declare it "
             ".read_only";
    }
  }
  EXPECT_GT(adjustable, 20u);
  EXPECT_GT(fixed, 50u);
}

}  // namespace
}  // namespace prehend::testing

// Every command of README and the docs is taken as it is written.

#include "tests/system/documented_commands.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/system/launched.h"

namespace prehend::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class DocumentedCommands : public ::testing::Test {
 protected:
  DocumentedCommands()
      : tree_(fs::current_path()),
        checker_(tree_, fs::absolute(std::getenv("PREHEND_BIN")), scratch_.path()) {}
  ~DocumentedCommands() override { fs::current_path(tree_); }

  // Evaluations and benchmarks may be left out of a build.
  static bool is_left_out(const std::string& problem) {
    return std::getenv("PREHEND_WITHOUT_BENCHMARKS") != nullptr &&
           (problem.find("no program eval_") != std::string::npos ||
            problem.find("no program bench_") != std::string::npos);
  }

  std::string problem_of(const std::string& command, bool is_mention = false) {
    return checker_.problem_of({"", command, is_mention});
  }

  const fs::path tree_;
  const ScratchFolder scratch_;
  const CommandChecker checker_;
};

TEST_F(DocumentedCommands, AreTaken) {
  std::vector<fs::path> documents{tree_ / "README.md"};
  for (const char* folder : {"docs", "launch", "config", "nodes", "drivers", "prehend", "tests"}) {
    for (const auto& entry : fs::recursive_directory_iterator(tree_ / folder)) {
      if (entry.path().extension() == ".md") documents.push_back(entry.path());
    }
  }
  std::size_t count = 0;
  for (const fs::path& document : documents) {
    for (const DocumentedCommand& command : commands_of(document)) {
      ++count;
      const std::string problem = checker_.problem_of(command);
      if (is_left_out(problem)) continue;
      EXPECT_EQ(problem, "") << command.place << ": " << command.text;
    }
  }
  EXPECT_GT(count, 100u) << "the documents have more commands than that";
}

TEST_F(DocumentedCommands, WrongOnesAreFound) {
  EXPECT_THAT(problem_of("prehend param get stereo_segmentation"), HasSubstr("required"));
  EXPECT_THAT(problem_of("prehend topik list"), HasSubstr("did you mean \"topic\"?"));
  EXPECT_THAT(problem_of("prehend topic pup", true), HasSubstr("did you mean \"pub\"?"));
  EXPECT_THAT(problem_of("prehend record --atach a.yaml"), HasSubstr("--attach"));
  EXPECT_THAT(problem_of("prehend launch launch/none.yaml"), HasSubstr("no such launch file"));
  EXPECT_THAT(problem_of("prehend launch launch/demo.yaml scen:=a"), HasSubstr("scene"));
  EXPECT_THAT(problem_of("build/bin/prehnd node list"), HasSubstr("no program"));
  EXPECT_THAT(problem_of("make demmo"), HasSubstr("no target"));
  EXPECT_THAT(problem_of("shape_completion --nmae a"), HasSubstr("no option --nmae"));
  EXPECT_EQ(problem_of("prehend topic pub", true), "") << "a mention may be incomplete";
  EXPECT_EQ(problem_of("PREHEND_BIND=10.0.0.1 prehend node list"), "");
  if (std::getenv("PREHEND_WITHOUT_BENCHMARKS") == nullptr) {
    EXPECT_THAT(problem_of("build/bin/eval_tradeoff shape --budget 20ms"),
                HasSubstr("at most 20 ms"));
  }
}

// They were looked for in the working directory only.
TEST_F(DocumentedCommands, LaunchFilesAndWhatTheyNameAreFoundFromAnywhere) {
  const fs::path elsewhere = scratch_.path() / "elsewhere";
  fs::create_directories(elsewhere);
  fs::current_path(elsewhere);
  for (const char* file : {"demo", "/launch/demo.yaml"}) {
    EXPECT_EQ(problem_of(std::string("prehend launch ") +
                         (file[0] == '/' ? tree_.string() : std::string()) + file),
              "");
  }
  EXPECT_THAT(problem_of("prehend launch dmo"), HasSubstr("no such launch file"));
  // A node finds its defaults, too: it says no word of a missing file.
  const Outcome described = run_program("pg70_emulator", {"--describe"}, std::chrono::seconds(20));
  EXPECT_EQ(described.exit_code, 0);
  EXPECT_THAT(described.output, HasSubstr("/config/robots/pg70_dsa.yaml"));
}

}  // namespace
}  // namespace prehend::testing

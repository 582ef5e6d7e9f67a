// The launch files that come with the repository.

#include <gmock/gmock.h>

#include <algorithm>

#include "tests/launch/supervision_fixture.h"

namespace prehend::testing {
namespace {

using std::chrono::seconds;
using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(LaunchFilesOfTheRepository, AreAllCorrect) {
  const ScratchDirectory scratch;
  ChildProgram check("prehend", {"launch", "--check", "launch"}, scratch.path("output.txt"));
  EXPECT_EQ(check.wait(seconds(100)), 0) << check.output();
  const auto is_launch_file = [](const auto& entry) { return entry.path().extension() == ".yaml"; };
  const auto files =
      std::count_if(std::filesystem::directory_iterator("launch"), {}, is_launch_file);
  ASSERT_GE(files, 6);
  const std::string output = check.output();
  std::size_t correct = 0;
  for (auto at = output.find(": correct, "); at != std::string::npos;
       at = output.find(": correct, ", at + 1)) {
    ++correct;
  }
  EXPECT_EQ(correct, static_cast<std::size_t>(files)) << output;
  EXPECT_EQ(output.find("not checked: it does not"), std::string::npos) << output;
}

TEST(LaunchFilesOfTheRepository, AreCheckedWithThePredictionComposed) {
  const ScratchDirectory scratch;
  ChildProgram check("prehend", {"launch", "--check", "launch/prediction.yaml", "composed:=true"},
                     scratch.path("output.txt"));
  EXPECT_EQ(check.wait(seconds(30)), 0) << check.output();
}

// `generators` is a list with choices: its default came over as a text, so that every form of it
// was refused, "[circles]" as well.
TEST(LaunchFilesOfTheRepository, ListsAreCheckedAgainstWhatTheProgramTakes) {
  const ScratchDirectory scratch;
  int calls = 0;
  const auto check = [&](const std::string& parameters) {
    scratch.write("a.yaml", "nodes: [{node: grasp_planning, parameters: {" + parameters + "}}]\n");
    ChildProgram program("prehend", {"launch", "--check", scratch.path("a.yaml")},
                         scratch.path(std::to_string(++calls)));
    const bool is_right = program.wait(seconds(30)) == 0;
    return (is_right ? "right: " : "wrong: ") + program.output();
  };
  for (const char* right :
       {"generators: [circles]", "generators: \"[segments, boxes]\"",
        "generators: [circles, segments, boxes, antipodal, medial_axis]", "move: [0, 0.1, 0]"}) {
    EXPECT_THAT(check(right), HasSubstr("right: ")) << right;
  }
  EXPECT_THAT(check("generators: [circles, segment]"),
              AllOf(HasSubstr("wrong: "), HasSubstr("must be one of: circles, segments"),
                    HasSubstr("(item 2)")));
  EXPECT_THAT(check("generators: circles"), HasSubstr("must be a list between brackets"));
  EXPECT_THAT(check("move: [0, up, 0]"), HasSubstr("item 2 is none"));
  EXPECT_THAT(check("density: [1, 2]"), HasSubstr("of type number"));
}

}  // namespace
}  // namespace prehend::testing

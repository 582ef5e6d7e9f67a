// The launch files that come with the repository.

#include <gmock/gmock.h>

#include <algorithm>

#include "tests/launch/supervision_fixture.h"

namespace prehend::testing {
namespace {

using std::chrono::seconds;
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

}  // namespace
}  // namespace prehend::testing

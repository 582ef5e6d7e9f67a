// prehend calibrate tactile.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "prehend/robot/pad_calibration.h"
#include "tests/launch/child_program.h"

namespace prehend::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class PadFitCommand : public ::testing::Test {
 protected:
  std::string run(std::vector<std::string> words) {
    words.insert(words.begin(), {"calibrate", "tactile"});
    ChildProgram program("prehend", words, folder_.path("output"));
    exit_code_ = program.wait(std::chrono::seconds(60)).value_or(-1);
    return program.output();
  }

  // A pad of 2 x 3 texels of 1 kN/m, pressed three times at two speeds; what of rounding is noise.
  std::string log() {
    std::ostringstream text;
    text << "time,depth,force,count[0],count[1],count[2],count[3],count[4],count[5]\n";
    double depth = -1e-4, before = depth;
    int row = 0;
    const auto go = [&](double to, int rows) {
      const double from = depth;
      for (int i = 1; i <= rows; ++i, ++row) {
        before = depth;
        depth = from + (to - from) * i / rows;
        const double force = depth > 0 ? 1e3 * depth + 10 * (depth - before) / 0.01 : 0.0;
        const double shown = std::max(0.0, force) + 1e-3 * std::sin(12.9898 * row);
        text << 0.01 * row << ',' << depth << ',' << 6 * shown;
        for (int t = 0; t < 6; ++t) {
          text << ',' << std::max(0L, std::lround(std::max(0.0, force) / 5e-4));
        }
        text << '\n';
      }
    };
    for (const double to : {1e-3, 1.4e-3, 0.8e-3}) {
      go(to, 50);
      go(to, 30);
      go(-1e-4, 200);
    }
    return folder_.write("presses.csv", text.str());
  }

  ScratchDirectory folder_;
  int exit_code_ = -1;
};

TEST_F(PadFitCommand, WritesACalibrationThatIsRead) {
  const std::string out = folder_.path("pad.yaml"), presses = log();
  const std::string output = run({presses, "--rows", "2", "--columns", "3", "--creep-terms", "0",
                                  "--hysteresis-terms", "0", "-o", out, "--check", presses});
  EXPECT_EQ(exit_code_, 0) << output;
  EXPECT_THAT(output, AllOf(HasSubstr("stiffness"), HasSubstr("newton_per_count"),
                            HasSubstr("3 presses"), HasSubstr("predicted to")));
  const robot::PadCalibration read = robot::read_pad_calibration(out);
  EXPECT_EQ(read.rows, 2);
  EXPECT_NEAR(read.newton_per_count, 5e-4, 2e-5);
  EXPECT_NEAR(*read.stiffness, 1000, 30);
}

TEST_F(PadFitCommand, ExplainsItselfAndSaysWhatIsWrong) {
  EXPECT_THAT(run({"--help"}), AllOf(HasSubstr("--creep-terms"), HasSubstr("--check"),
                                     HasSubstr("count[0]"), HasSubstr("docs/touch.md")));
  EXPECT_EQ(exit_code_, 0);
  const std::string presses = log();
  EXPECT_THAT(run({presses}),
              AllOf(HasSubstr("prehend calibrate tactile: "), HasSubstr("6 texels")));
  EXPECT_EQ(exit_code_, 1);
  EXPECT_THAT(run({presses, "--rows", "2", "--columns", "3", "--column", "force=newton"}),
              HasSubstr("no column 'newton'"));
  EXPECT_THAT(run({presses, "--rows", "2", "--columns", "3"}), HasSubstr("does not determine"));
  EXPECT_EQ(exit_code_, 1);
}

}  // namespace
}  // namespace prehend::testing

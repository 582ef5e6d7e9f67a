#include "eval/grasp/success_fit.h"

#include <string>

#include <gtest/gtest.h>

namespace prehend::eval {
namespace {

// As many of each share as the line says, of ten objects.
std::vector<KnownSuccess> drawn_from(const SuccessLine& line, int of_each) {
  std::vector<KnownSuccess> known;
  for (const double held : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    const double lifted = line.at(held) * of_each;
    for (int i = 0; i < of_each; ++i) {
      known.push_back({held, i < lifted, "object " + std::to_string(i % 10)});
    }
  }
  return known;
}

TEST(SuccessFit, FindsTheLineThatAttemptsAreDrawnFrom) {
  const SuccessLine line = fit_success(drawn_from({0.3, 0.9}, 200));
  EXPECT_NEAR(line.of_none, 0.3, 0.03);
  EXPECT_NEAR(line.of_all, 0.9, 0.03);
  EXPECT_LT(calibration_of(drawn_from({0.3, 0.9}, 200), line).calibration_error, 0.03);
}

// What falls with the share held is no line of this kind: it is level then.
TEST(SuccessFit, DoesNotFall) {
  const SuccessLine line = fit_success(drawn_from({0.9, 0.3}, 200));
  EXPECT_NEAR(line.of_none, line.of_all, 0.006);
  EXPECT_NEAR(line.of_none, 0.6, 0.03);
}

TEST(SuccessFit, FewAttemptsMakeNothingSure) {
  const SuccessLine line = fit_success({{1, true, "a"}, {1, true, "b"}});
  EXPECT_GT(line.of_none, 0.01);
  EXPECT_LT(line.of_all, 0.95);
  EXPECT_GE(line.of_all, line.of_none);
}

TEST(SuccessFit, CountsWhatIsMissed) {
  const std::vector<KnownSuccess> known = drawn_from({0.5, 0.5}, 100);
  const SuccessCalibration right = calibration_of(known, {0.5, 0.5});
  EXPECT_EQ(right.attempts, 500);
  EXPECT_EQ(right.lifted, 250);
  EXPECT_NEAR(right.calibration_error, 0, 1e-9);
  EXPECT_NEAR(right.brier, 0.25, 1e-12);
  EXPECT_NEAR(right.brier, right.brier_of_constant, 1e-12);
  const SuccessCalibration wrong = calibration_of(known, {0.9, 0.9});
  EXPECT_NEAR(wrong.calibration_error, 0.4, 0.1);
  EXPECT_EQ(calibration_of({}, {0.5, 0.5}).attempts, 0);
}

// An object that always fails is foretold by the others.
TEST(SuccessFit, AnObjectIsForetoldByTheOthers) {
  std::vector<KnownSuccess> known;
  for (int i = 0; i < 40; ++i) known.push_back({1, i >= 10, i < 10 ? "slippery" : "box"});
  EXPECT_GT(cross_validated(known).brier, calibration_of(known, fit_success(known)).brier);
}

}  // namespace
}  // namespace prehend::eval

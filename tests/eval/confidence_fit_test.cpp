#include "eval/confidence_fit.h"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <random>

#include <gtest/gtest.h>

#include "tests/eval/temporary_folder.h"

namespace prehend::eval {
namespace {

std::vector<JudgedEvidence> drawn(const shape::ConfidenceModel& truth, int count,
                                  std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1.0p-53; };
  std::vector<JudgedEvidence> judged;
  for (int i = 0; i < count; ++i) {
    JudgedEvidence one;
    one.evidence.method = static_cast<shape::CompletionMethod>(random() % 2);
    one.evidence.contradicted = 0.6 * uniform();
    one.evidence.support = uniform();
    one.evidence.concavity = 0.3 * uniform();
    one.right = uniform() < shape::confidence(one.evidence, truth);
    judged.push_back(one);
  }
  return judged;
}

TEST(ConfidenceFit, FindsTheModelThatDrewTheData) {
  shape::ConfidenceModel truth;
  truth.mirror = 3;
  truth.rotation = 1;
  truth.contradicted = 6;
  truth.unsupported = 1;
  truth.concavity = 4;
  const shape::ConfidenceModel found = fitted_confidence(drawn(truth, 4000, 1), {}, 10);
  EXPECT_NEAR(found.mirror, 3, 0.5);
  EXPECT_NEAR(found.rotation, 1, 0.5);
  EXPECT_NEAR(found.contradicted, 6, 0.8);
  EXPECT_NEAR(found.unsupported, 1, 0.4);
  EXPECT_NEAR(found.concavity, 4, 1.5);
  // What the data do not say stays.
  EXPECT_EQ(found.cut_by_image, shape::ConfidenceModel().cut_by_image);

  const Calibration sure = calibration_of(drawn(truth, 5000, 2), found, 0.7);
  ASSERT_GT(sure.sure, 20);
  EXPECT_GT(sure.right, 0.7 * sure.sure);
}

TEST(ConfidenceFit, CrossValidationLeavesOutAnObjectsOwnViews) {
  // One object has evidence of its own kind, which only its own views could teach.
  std::vector<JudgedEvidence> judged = drawn({}, 400, 5);
  for (std::size_t i = 0; i < judged.size(); ++i) {
    judged[i].object = i % 4 == 0 ? "odd" : "even" + std::to_string(i % 4);
    judged[i].evidence.method = shape::CompletionMethod::kMirror;
    judged[i].right = true;
    if (judged[i].object != "odd") continue;
    judged[i].evidence.method = shape::CompletionMethod::kRotation;
    judged[i].right = false;
  }
  const shape::ConfidenceModel all = fitted_confidence(judged);
  const std::vector<double> left_out = cross_validated(judged);
  ASSERT_EQ(left_out.size(), judged.size());
  EXPECT_LT(shape::confidence(judged[0].evidence, all), left_out[0] - 0.1);
  const Calibration sure = calibration_of(judged, left_out, 0);
  EXPECT_EQ(sure.sure, 400);
  EXPECT_EQ(sure.right, 300);
  EXPECT_EQ(sure.all_right, 300);
}

TEST(ConfidenceFit, CoefficientsAreNeverNegativeAndCanBeReadBack) {
  // The more support, the worse: no model says so.
  std::vector<JudgedEvidence> judged = drawn({}, 500, 3);
  for (JudgedEvidence& one : judged) one.right = one.evidence.support < 0.5;
  const shape::ConfidenceModel found = fitted_confidence(judged);
  EXPECT_EQ(found.unsupported, 0);
  const testing::TemporaryFolder folder;
  std::ofstream(folder.path / "model.yaml") << to_yaml(found);
  EXPECT_EQ(shape::read_confidence_model(folder.path / "model.yaml"), found);
  EXPECT_THROW(fitted_confidence({}), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::eval

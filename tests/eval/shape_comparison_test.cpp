#include "eval/shape_comparison.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/case_runner.h"
#include "eval/reconstruction_methods.h"
#include "prehend/geometry/triangle_mesh.h"

namespace prehend::eval {
namespace {

using ::testing::HasSubstr;

geometry::TriangleMesh standing_box(const Eigen::Vector3d& size, double height = 0) {
  geometry::TriangleMesh mesh = geometry::make_box(size);
  const double shift = height - geometry::bounds(mesh).min().z();
  for (Eigen::Vector3d& v : mesh.vertices) v.z() += shift;
  return mesh;
}

TEST(ShapeComparison, ChamferAndHausdorffOfBallsInOneAnother) {
  const MethodResult result = measured(geometry::make_sphere(0.05), geometry::make_sphere(0.04), 1);
  // Facets are inside of the spheres by less than 0.2 mm.
  EXPECT_NEAR(chamfer_of(result), 0.01, 3e-4);
  EXPECT_NEAR(hausdorff_of(result), 0.01, 3e-4);
  EXPECT_TRUE(std::isnan(chamfer_of({})));
  EXPECT_TRUE(std::isnan(hausdorff_of({})));
}

TEST(ShapeComparison, HausdorffIsTheLargerOfBothDirections) {
  // The long box goes 50 mm beyond the cube at either end; of the cube nothing is far from it.
  const auto cube = standing_box({0.1, 0.1, 0.1}), rod = standing_box({0.2, 0.1, 0.1});
  EXPECT_NEAR(hausdorff_of(measured(rod, cube, 1)), 0.05, 1e-3);
  EXPECT_NEAR(hausdorff_of(measured(cube, rod, 1)), 0.05, 1e-3);
}

TEST(ShapeComparison, SolidsAreMeasuredByOverlapAndByWhetherTheyStand) {
  const auto truth = standing_box({0.06, 0.06, 0.12});
  MethodResult same;
  measure_solid(truth, truth, {}, &same);
  EXPECT_EQ(same.jaccard, 1);
  EXPECT_EQ(stands_of(same), 1);
  // Predicted 10 mm over the table: it drops by as much.
  MethodResult high;
  measure_solid(standing_box({0.06, 0.06, 0.12}, 0.01), truth, {}, &high);
  EXPECT_NEAR(high.jaccard, 11. / 13, 0.035);  // to 1.5 voxels of the 43 in its height
  EXPECT_NEAR(high.moved, 0.01, 5e-4);
  EXPECT_EQ(stands_of(high), 0);
}

TEST(ShapeComparison, StandingAllowsFiveMillimetresAndFiveDegrees) {
  MethodResult result;
  EXPECT_EQ(stands_of(result), 0);  // without a mesh
  result.moved = 0.0049;
  result.turned = 4.9 * std::numbers::pi / 180;
  EXPECT_EQ(stands_of(result), 1);
  result.moved = 0.0051;
  EXPECT_EQ(stands_of(result), 0);
  result.moved = 0;
  result.turned = 5.1 * std::numbers::pi / 180;
  EXPECT_EQ(stands_of(result), 0);
}

MethodResult result_of_method(const std::string& method, double deviation, double jaccard,
                              double moved) {
  MethodResult result;
  result.method = method;
  result.mean = result.back_mean = result.max = result.back_max = deviation;
  result.jaccard = jaccard;
  result.moved = moved;
  result.turned = 0;
  result.seconds = 0.05;
  return result;
}

const Goal& goal_of(const std::vector<Goal>& goals, const std::string& part) {
  for (const Goal& goal : goals) {
    if (goal.name.find(part) != std::string::npos) return goal;
  }
  throw std::out_of_range("no goal '" + part + "'");
}

TEST(ShapeComparison, GoalsAreToBeBestButForTheTruth) {
  CaseResult one;
  one.methods = {result_of_method("Ours", 0.002, 0.8, 0),
                 result_of_method("GPIS", 0.003, 0.7, 0.01), result_of_method("Truth", 0, 1, 0)};
  std::vector<CaseResult> results = {one};
  std::vector<Goal> goals = judge_single_view(results);
  for (const Goal& goal : goals) EXPECT_EQ(goal.outcome, Goal::Outcome::kMet) << goal.name;
  EXPECT_THAT(goal_of(goals, "Chamfer").measured, HasSubstr("of GPIS"));

  results[0].methods[1].jaccard = 0.9;
  EXPECT_EQ(goal_of(judge_single_view(results), "Jaccard").outcome, Goal::Outcome::kMissed);
  results[0].methods[0].seconds = 0.061;
  EXPECT_EQ(goal_of(judge_single_view(results), "time").outcome, Goal::Outcome::kMissed);

  // A case in which nothing was found counts as one where nothing stands.
  results.emplace_back();
  EXPECT_EQ(goal_of(judge_single_view(results), "stood").outcome, Goal::Outcome::kMissed);
  EXPECT_EQ(goal_of(judge_single_view(results), "stood").measured, "50.0 % of 2");
}

TEST(ShapeComparison, MethodsAreKnown) {
  for (const ShapeComparison& comparison : shape_comparisons()) {
    EXPECT_EQ(methods_named(comparison.methods).size(), comparison.methods.size());
  }
  EXPECT_THROW(methods_named({"Psychic"}), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::eval

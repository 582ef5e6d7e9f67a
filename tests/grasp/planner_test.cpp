#include "prehend/grasp/planner.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <limits>
#include <numeric>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "tests/grasp/planner_scene.h"

namespace prehend::grasp {
namespace {

using geometry::TriangleMesh;
using testing::carrier;
using testing::kPlannerGripper;
using testing::object_at;

int rejected(const GraspPlan& result, Reason reason) {
  int count = 0;
  for (const Rejection& entry : result.rejections)
    count += entry.reason == reason ? entry.count : 0;
  return count;
}

int rejected(const GraspPlan& result) {
  return std::accumulate(result.rejections.begin(), result.rejections.end(), 0,
                         [](int sum, const Rejection& entry) { return sum + entry.count; });
}

GraspPlan plan(const std::string& name, const surface::ObjectModel& object,
               const Reachability& reachability = carrier(), const Obstacles& obstacles = {}) {
  const auto start = std::chrono::steady_clock::now();
  const auto result =
      plan_grasps(object, geometry::Plane{}, obstacles, kPlannerGripper, reachability);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::printf("%s: %d candidates, %zu grasps listed, %.3f s, %s\n", name.c_str(), result.candidates,
              result.grasps.size(), seconds, result.problem.c_str());
  for (const Rejection& entry : result.rejections) {
    std::printf("  %5d %s (%s)\n", entry.count, to_string(entry.reason).c_str(),
                entry.nearest_miss.c_str());
  }
  EXPECT_EQ(static_cast<int>(result.grasps.size()) + rejected(result), result.candidates);
  EXPECT_EQ(result.grasps.empty(), !result.problem.empty());
  EXPECT_EQ(result.grasps.empty(), result.outcome == PlanOutcome::kUngraspable);
  for (std::size_t i = 1; i < result.grasps.size(); ++i) {
    EXPECT_GE(result.grasps[i - 1].score, result.grasps[i].score);
  }
  return result;
}

TEST(PlanGrasps, CubeFromAbove) {
  const auto result =
      plan("cube 50 mm", object_at(geometry::make_box({0.05, 0.05, 0.05}), {0.4, 0.1, 0.025}, 0.3));
  ASSERT_FALSE(result.grasps.empty()) << result.problem;
  const Grasp& best = result.grasps.front();
  EXPECT_NEAR(best.predicted.opening, 0.05, 5e-4);
  EXPECT_NEAR(best.predicted.lifted_mass, 0.1, 1e-3);
  EXPECT_NEAR(best.predicted.tactile_sum, best.force, 0.02 * best.force);
  EXPECT_NEAR(best.approach_W.z(), -1, 1e-12);
  EXPECT_NEAR(best.X_WG.translation().x(), 0.4, 1e-3);
  EXPECT_NEAR(best.X_WG.translation().y(), 0.1, 1e-3);
  EXPECT_GT(best.quality, 0);
  // The fingertips stay over the table.
  EXPECT_GT((best.X_WG * Eigen::Vector3d(0, 0, kPlannerGripper.tip_z())).z(), 0.0039);
  // The contacts lie on opposite faces of the cube, 50 mm apart.
  ASSERT_FALSE(best.contacts.empty());
  EXPECT_EQ(best.contacts.front().pad, 0);
  EXPECT_EQ(best.contacts.back().pad, 1);
  const Eigen::Vector3d apart =
      best.contacts.front().contact_W.point - best.contacts.back().contact_W.point;
  EXPECT_NEAR(std::abs(apart.dot(best.X_WG.linear().col(1))), 0.05, 1e-3);
}

TEST(PlanGrasps, CanAndBall) {
  const auto can = plan(
      "can 62 x 115 mm",
      object_at(geometry::make_revolution({{0.031, -0.0575}, {0.031, 0.0575}}), {0.3, 0, 0.0575}));
  ASSERT_FALSE(can.grasps.empty()) << can.problem;
  EXPECT_NEAR(can.grasps.front().predicted.opening, 0.062, 1e-3);
  const auto ball = plan("ball 60 mm", object_at(geometry::make_sphere(0.03), {0.3, 0, 0.03}));
  ASSERT_FALSE(ball.grasps.empty()) << ball.problem;
  EXPECT_LT(ball.grasps.front().predicted.contact_area, can.grasps.front().predicted.contact_area);
}

TEST(PlanGrasps, BottleWithAnArmThatReachesAll) {
  const auto result = plan(
      "bottle, all directions",
      object_at(
          geometry::make_revolution({{0.03, 0}, {0.03, 0.13}, {0.012, 0.17}, {0.012, 0.2}}, 48),
          {0.3, 0, 0}),
      Reachability{});
  ASSERT_FALSE(result.grasps.empty()) << result.problem;
}

TEST(PlanGrasps, WideCup) {
  // A cup 90 mm wide: it is held by its wall.
  const TriangleMesh cup = geometry::make_revolution(
      {{0.045, 0}, {0.045, 0.09}, {0.039, 0.09}, {0.039, 0.01}, {0.0, 0.01}}, 64);
  surface::ObjectModel object = object_at(cup, {0.3, 0, 0});
  const auto result = plan("cup 90 mm", object);
  ASSERT_FALSE(result.grasps.empty()) << result.problem;
  for (const Grasp& grasp : result.grasps) {
    EXPECT_EQ(grasp.generator, "antipodal");
    EXPECT_LT(grasp.predicted.opening, 0.02);
  }
  EXPECT_GT(result.grasps.front().robustness, 0.5);
}

TEST(PlanGrasps, WideCupByTheGeneratorsThatAreAskedForAlone) {
  const TriangleMesh cup = geometry::make_revolution(
      {{0.045, 0}, {0.045, 0.09}, {0.039, 0.09}, {0.039, 0.01}, {0.0, 0.01}}, 64);
  PlannerOptions options;
  options.further_generators.clear();
  const auto result =
      plan_grasps(object_at(cup, {0.3, 0, 0}), {}, {}, kPlannerGripper, carrier(), options);
  EXPECT_EQ(result.problem, "narrowest width 90 mm exceeds the gripper's 69 mm");
}

TEST(PlanGrasps, TooWideBoxSaysHowWide) {
  const auto result =
      plan("box 94 mm", object_at(geometry::make_box({0.12, 0.094, 0.1}), {0.4, 0, 0.05}, 0.2));
  EXPECT_TRUE(result.grasps.empty());
  EXPECT_EQ(result.outcome, PlanOutcome::kUngraspable);
  EXPECT_EQ(in_words(result),
            "cannot be grasped: narrowest width 94 mm exceeds the gripper's 69 mm");
}

TEST(PlanGrasps, LedgerSaysHowNearTheBestCame) {
  const auto result =
      plan("box 80 mm", object_at(geometry::make_box({0.12, 0.08, 0.1}), {0.4, 0, 0.05}, 0.2));
  bool told = false;
  for (const Rejection& entry : result.rejections) {
    if (entry.reason != Reason::kTooWide || entry.generator != "circles") continue;
    EXPECT_EQ(entry.nearest_miss, "80.0 mm > 66.0 mm");
    told = true;
  }
  EXPECT_TRUE(told);
}

TEST(PlanGrasps, OutOfTimeSaysWhatWasNotTried) {
  PlannerOptions options;
  options.budget = 1e-9;
  const auto result = plan_grasps(object_at(geometry::make_box({0.05, 0.05, 0.05}), {0, 0, 0.025}),
                                  geometry::Plane{}, {}, kPlannerGripper, carrier(), options);
  EXPECT_TRUE(result.grasps.empty());
  EXPECT_EQ(rejected(result, Reason::kNoTime), result.candidates);
  EXPECT_NE(result.problem.find("not tried"), std::string::npos) << result.problem;
}

// Whenever it is stopped: what it has are grasps of the whole plan, the best of them first.
TEST(PlanGrasps, StoppedAtAnyMomentWhatItHasIsValid) {
  PlannerOptions options;
  options.uncertainty.samples = 0;
  options.largest_count = 10000;
  const surface::ObjectModel object =
      object_at(geometry::make_box({0.05, 0.06, 0.12}), {0.4, 0, 0.06});
  const auto plan = [&] {
    return plan_grasps(object, geometry::Plane{}, {}, kPlannerGripper, carrier(), options);
  };
  const GraspPlan whole = plan();
  ASSERT_FALSE(whole.grasps.empty());
  std::size_t most = 0;
  for (const double budget : {1e-4, 1e-3, 5e-3, 0.02, 0.05, 0.1, 60.0}) {
    options.budget = budget;
    const GraspPlan part = plan();
    EXPECT_EQ(static_cast<int>(part.grasps.size()) + rejected(part), part.candidates) << budget;
    for (std::size_t i = 0; i < part.grasps.size(); ++i) {
      if (i > 0) EXPECT_GE(part.grasps[i - 1].score, part.grasps[i].score) << budget;
      const bool is_of_the_whole =
          std::any_of(whole.grasps.begin(), whole.grasps.end(), [&](const Grasp& one) {
            return one.X_WG.matrix() == part.grasps[i].X_WG.matrix() &&
                   one.quality == part.grasps[i].quality;
          });
      EXPECT_TRUE(is_of_the_whole) << budget << " s, grasp " << i;
    }
    most = part.grasps.size();
  }
  EXPECT_EQ(most, whole.grasps.size()) << "in a minute";
}

TEST(PlanGrasps, TooHeavySaysHowHeavy) {
  PlannerOptions options;
  options.density = 20000;
  const auto result = plan_grasps(object_at(geometry::make_box({0.05, 0.05, 0.2}), {0, 0, 0.1}),
                                  geometry::Plane{}, {}, kPlannerGripper, carrier(), options);
  EXPECT_TRUE(result.grasps.empty());
  EXPECT_NE(result.problem.find("too heavy"), std::string::npos) << result.problem;
}

TEST(PlanGrasps, CrumbIsOutOfTheFingertipsReach) {
  const auto result =
      plan("crumb 4 mm", object_at(geometry::make_box({0.004, 0.004, 0.004}), {0.4, 0, 0.002}));
  EXPECT_TRUE(result.grasps.empty());
  EXPECT_EQ(result.outcome, PlanOutcome::kUngraspable) << result.problem;
}

TEST(PlanGrasps, OutOfTheWorkspace) {
  Reachability reachability = carrier();
  reachability.workspace_W =
      Eigen::AlignedBox3d(Eigen::Vector3d(1, 1, 0), Eigen::Vector3d(2, 2, 1));
  const auto result =
      plan("out of reach", object_at(geometry::make_box({0.05, 0.05, 0.05}), {0.4, 0.1, 0.025}),
           reachability);
  EXPECT_EQ(result.problem, "no approach to it is within the robot's reach");
}

TEST(PlanGrasps, NeighboursNarrowTheChoice) {
  const surface::ObjectModel cube =
      object_at(geometry::make_box({0.04, 0.04, 0.05}), {0.4, 0, 0.025});
  const auto alone = plan("cube 40 mm alone", cube);
  // Walls at both sides in y leave only closing along x.
  Obstacles walls;
  for (double side : {-1.0, 1.0}) {
    walls.meshes_W.push_back(
        object_at(geometry::make_box({0.3, 0.02, 0.1}), {0.4, side * 0.034, 0.05}).mesh_W);
  }
  const auto between = plan("cube 40 mm between walls", cube, carrier(), walls);
  ASSERT_FALSE(alone.grasps.empty());
  EXPECT_GT(rejected(between, Reason::kObstacle), 0);
  for (const auto& grasp : between.grasps) {
    EXPECT_GT(std::abs(grasp.X_WG.linear().col(1).x()), 0.9);
  }
  // Walls all round leave nothing.
  for (double side : {-1.0, 1.0}) {
    walls.meshes_W.push_back(
        object_at(geometry::make_box({0.02, 0.3, 0.1}), {0.4 + side * 0.034, 0, 0.05}).mesh_W);
  }
  const auto enclosed = plan("cube 40 mm enclosed", cube, carrier(), walls);
  EXPECT_TRUE(enclosed.grasps.empty());
  EXPECT_NE(enclosed.problem.find("another object"), std::string::npos) << enclosed.problem;
}

TEST(PlanGrasps, NarrowerOpeningBesideANeighbour) {
  const surface::ObjectModel cube =
      object_at(geometry::make_box({0.03, 0.03, 0.06}), {0.4, 0, 0.03});
  Obstacles walls;
  for (double side : {-1.0, 1.0}) {  // finger's back at 20 + 12 mm, + 5 mm margin: 37 mm
    walls.meshes_W.push_back(
        object_at(geometry::make_box({0.3, 0.02, 0.1}), {0.4, side * 0.050, 0.05}).mesh_W);
  }
  const auto result = plan("narrow opening", cube, carrier(), walls);
  ASSERT_FALSE(result.grasps.empty());
  bool narrowed = false;
  for (const auto& grasp : result.grasps) {
    if (std::abs(grasp.X_WG.linear().col(1).y()) > 0.9) {
      EXPECT_LT(pregrasp_opening(grasp), 0.045);
      narrowed = true;
    }
  }
  EXPECT_TRUE(narrowed);
}

TEST(PlanGrasps, LowNeighboursAllowANarrowerOpening) {
  const surface::ObjectModel post =
      object_at(geometry::make_box({0.03, 0.03, 0.12}), {0.4, 0, 0.06});
  Obstacles walls;
  for (double side : {-1.0, 1.0}) {
    walls.meshes_W.push_back(
        object_at(geometry::make_box({0.3, 0.02, 0.05}), {0.4, side * 0.050, 0.025}).mesh_W);
    walls.meshes_W.push_back(
        object_at(geometry::make_box({0.02, 0.3, 0.05}), {0.4 + side * 0.050, 0, 0.025}).mesh_W);
  }
  const auto result = plan("post between low walls", post, carrier(), walls);
  ASSERT_FALSE(result.grasps.empty()) << result.problem;
}

TEST(PlanGrasps, SameInputSameResultInAnyNumberOfThreads) {
  const auto object = object_at(geometry::make_sphere(0.028), {0.1, 0.2, 0.028});
  const auto a = plan("ball", object);
  for (const int threads : {0, 1, 2, 5}) {
    PlannerOptions options;
    options.threads = threads;
    const auto b = plan_grasps(object, geometry::Plane{}, {}, kPlannerGripper, carrier(), options);
    ASSERT_EQ(a.grasps.size(), b.grasps.size());
    ASSERT_EQ(a.rejections.size(), b.rejections.size());
    for (std::size_t i = 0; i < a.rejections.size(); ++i) {
      EXPECT_EQ(a.rejections[i].reason, b.rejections[i].reason);
      EXPECT_EQ(a.rejections[i].count, b.rejections[i].count);
      EXPECT_EQ(a.rejections[i].nearest_miss, b.rejections[i].nearest_miss);
    }
    for (std::size_t i = 0; i < a.grasps.size(); ++i) {
      EXPECT_EQ(a.grasps[i].score, b.grasps[i].score);
      EXPECT_EQ(a.grasps[i].robustness, b.grasps[i].robustness);
      EXPECT_EQ(a.grasps[i].X_WG.matrix(), b.grasps[i].X_WG.matrix());
      EXPECT_EQ(a.grasps[i].predicted.opening, b.grasps[i].predicted.opening);
    }
  }
}

TEST(PlanGrasps, OpenMeshStillHasAWeight) {
  surface::ObjectModel object =
      object_at(geometry::make_box({0.05, 0.05, 0.05}), {0.4, 0.1, 0.025});
  object.mesh_W.triangles.pop_back();
  const auto result = plan("cube with a hole", object);
  ASSERT_FALSE(result.grasps.empty()) << result.problem;
  EXPECT_NEAR(result.grasps.front().predicted.lifted_mass, 0.1, 1e-3);
}

TEST(PlanGrasps, InsideOutMeshIsTurned) {
  surface::ObjectModel object =
      object_at(geometry::make_box({0.05, 0.05, 0.05}), {0.4, 0.1, 0.025});
  for (auto& t : object.mesh_W.triangles) std::swap(t[0], t[1]);
  EXPECT_FALSE(plan("inside out", object).grasps.empty());
}

TEST(PlanGrasps, BrokenMeshesAreInputErrors) {
  surface::ObjectModel object;
  EXPECT_THROW(plan_grasps(object, geometry::Plane{}, {}, kPlannerGripper, carrier()),
               geometry::InputError);
  object = object_at(geometry::make_box({0.05, 0.05, 0.05}), {0, 0, 0.025});
  object.mesh_W.vertices[3].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(plan_grasps(object, geometry::Plane{}, {}, kPlannerGripper, carrier()),
               geometry::InputError);
  object = object_at(geometry::make_box({0.05, 0.05, 0.05}), {0, 0, 0.025});
  object.mesh_W.triangles[0][1] = 99;
  EXPECT_THROW(plan_grasps(object, geometry::Plane{}, {}, kPlannerGripper, carrier()),
               geometry::InputError);
  // A flat sheet bounds no solid.
  object.mesh_W.vertices = {{0, 0, 0.1}, {0.1, 0, 0.1}, {0, 0.1, 0.1}, {0.1, 0.1, 0.1}};
  object.mesh_W.triangles = {{0, 1, 2}, {2, 1, 3}};
  EXPECT_THROW(plan_grasps(object, geometry::Plane{}, {}, kPlannerGripper, carrier()),
               geometry::InputError);
}

TEST(PlanGrasps, RejectsNonsenseOptions) {
  const auto object = object_at(geometry::make_box({0.05, 0.05, 0.05}), {0, 0, 0.025});
  PlannerOptions options;
  options.density = -1;
  EXPECT_THROW(plan_grasps(object, geometry::Plane{}, {}, kPlannerGripper, carrier(), options),
               std::invalid_argument);
  options = {};
  options.safety_factor = 0.5;
  EXPECT_THROW(plan_grasps(object, geometry::Plane{}, {}, kPlannerGripper, carrier(), options),
               std::invalid_argument);
}

}  // namespace
}  // namespace prehend::grasp

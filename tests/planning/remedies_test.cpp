// What would help: every figure is checked by planning with it, and with one step less.

#include "prehend/planning/remedies.h"

#include <limits>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/surface/model.h"

namespace prehend::planning {
namespace {

using geometry::TriangleMesh;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

constexpr RemedyOptions kPatient{.budget = 300};

TriangleMesh brick_at(const Eigen::Vector3d& size, const Eigen::Vector3d& center) {
  return geometry::transformed(geometry::make_box(size),
                               geometry::make_transform(Eigen::Quaterniond::Identity(), center));
}

class RemediesTest : public ::testing::Test {
 protected:
  RemediesTest() {
    down.approach_W = -Eigen::Vector3d::UnitZ();
    // As remedies are counted.
    options.uncertainty.samples = 0;
    options.pads.width_tolerance = 0;
    options.hollow_share = 1;
  }
  void put(const Eigen::Vector3d& size) {
    object = surface::model_of_mesh(brick_at(size, {0, 0, size.z() / 2}));
  }
  grasp::GraspPlan plan() const {
    return grasp::plan_grasps(object, table, obstacles, grasp::HandToClose(hand), down, options);
  }
  Remedies remedies(const RemedyOptions& remedy = kPatient) const {
    const grasp::GraspPlan without = plan();
    EXPECT_TRUE(without.grasps.empty());
    return remedies_for_grasps(object, table, obstacles, hand, down, options, without.rejections,
                               remedy);
  }
  static const Remedy* of(const Remedies& all, RemedyChange change) {
    for (const Remedy& one : all.found) {
      if (one.amounts.size() == 1 && one.amounts.front().change == change) return &one;
    }
    return nullptr;
  }
  int count() {
    options.largest_count = 10000;
    return static_cast<int>(plan().grasps.size());
  }

  surface::ObjectModel object;
  geometry::Plane table;
  grasp::Obstacles obstacles;
  robot::HandModel hand = robot::parallel_hand(robot::GripperModel());
  grasp::Reachability down;
  grasp::PlannerOptions options;
};

TEST_F(RemediesTest, TellsTheLeastOpeningForWhatIsTooWide) {
  put({0.0795, 0.09, 0.1});
  const Remedies all = remedies();
  EXPECT_TRUE(all.complete);
  const Remedy* opening = of(all, RemedyChange::kOpening);
  ASSERT_NE(opening, nullptr);
  const auto [change, planned, needed] = opening->amounts.front();
  EXPECT_DOUBLE_EQ(planned, hand.gripper->max_opening);
  EXPECT_GT(needed, 0.08);
  EXPECT_LT(needed, 0.09);
  EXPECT_THAT(opening->text, StartsWith("with 14 mm more opening (83 mm): "));
  EXPECT_THAT(in_words(all), StartsWith("It would help: with 14 mm more opening"));
  hand.gripper->max_opening = needed;
  EXPECT_EQ(count(), opening->grasps);
  hand.gripper->max_opening = needed - 1e-3;
  EXPECT_EQ(count(), 0);
}

TEST_F(RemediesTest, TellsTheLeastForceAndTheMassForWhatIsTooHeavy) {
  put({0.05, 0.06, 0.12});
  options.density = 9000;
  const Remedies all = remedies();
  const Remedy* force = of(all, RemedyChange::kForce);
  const Remedy* mass = of(all, RemedyChange::kMass);
  ASSERT_NE(force, nullptr);
  ASSERT_NE(mass, nullptr);
  EXPECT_DOUBLE_EQ(force->amounts.front().planned, 52);
  EXPECT_THAT(force->text, HasSubstr("the gripper's largest current gives 187 N"));
  const double needed = force->amounts.front().needed;
  options.pads.largest_force = needed;
  EXPECT_EQ(count(), force->grasps);
  options.pads.largest_force = needed - 1;
  EXPECT_EQ(count(), 0);
  options.pads.largest_force = 0;
  EXPECT_NEAR(mass->amounts.front().planned, 9000 * 0.05 * 0.06 * 0.12, 1e-9);
  options.density = mass->amounts.front().needed / (0.05 * 0.06 * 0.12);
  EXPECT_EQ(count(), mass->grasps);
}

TEST_F(RemediesTest, WhatStandsInACornerWouldBeGraspedAlone) {
  put({0.05, 0.05, 0.1});
  // On all sides, 3 mm away.
  for (const double side : {-1.0, 1.0}) {
    obstacles.meshes_W.push_back(brick_at({0.05, 0.2, 0.2}, {side * 0.053, 0, 0.1}));
    obstacles.meshes_W.push_back(brick_at({0.05, 0.05, 0.2}, {0, side * 0.053, 0.1}));
  }
  const Remedy* alone = nullptr;
  const Remedies all = remedies();
  alone = of(all, RemedyChange::kNeighbours);
  ASSERT_NE(alone, nullptr) << in_words(all);
  obstacles = {};
  EXPECT_EQ(count(), alone->grasps);
}

TEST_F(RemediesTest, TwoChangesWhereNoneHelpsAlone) {
  put({0.08, 0.09, 0.1});
  for (const double side : {-1.0, 1.0}) {
    obstacles.meshes_W.push_back(brick_at({0.05, 0.3, 0.2}, {side * 0.068, 0, 0.1}));
    obstacles.meshes_W.push_back(brick_at({0.08, 0.05, 0.2}, {0, side * 0.073, 0.1}));
  }
  // All are too wide: only a wider opening leads into the walls.
  const Remedies all = remedies();
  ASSERT_FALSE(all.found.empty()) << in_words(all);
  const Remedy& both = all.found.front();
  ASSERT_EQ(both.amounts.size(), 2u);
  EXPECT_EQ(both.amounts[0].change, RemedyChange::kOpening);
  EXPECT_EQ(both.amounts[1].change, RemedyChange::kNeighbours);
  hand.gripper->max_opening = both.amounts[0].needed;
  EXPECT_EQ(count(), 0) << "the walls are still there";
  obstacles = {};
  EXPECT_EQ(count(), both.grasps);
  EXPECT_THAT(all.in_vain, ::testing::Contains("100 mm more opening (169 mm)"));
}

TEST_F(RemediesTest, OutOfTheArmsReachTellsWhereItWouldBeReached) {
  put({0.05, 0.05, 0.1});
  options.reaches = [](const geometry::RigidTransform& X_WH) {
    return X_WH.translation().x() > 0.22;
  };
  const Remedies all = remedies();
  const Remedy* place = of(all, RemedyChange::kPlace);
  ASSERT_NE(place, nullptr);
  EXPECT_NEAR(place->amounts.front().needed, 0.2, 1e-9);
  EXPECT_THAT(place->text, HasSubstr("x 200 mm, y 0 mm"));
  options.reaches = [](const geometry::RigidTransform& X_WH) {
    return X_WH.translation().x() + 0.2 > 0.22;
  };
  EXPECT_EQ(count(), place->grasps);
}

TEST_F(RemediesTest, SaysHowMuchLargerTheWorkspaceMustBe) {
  put({0.05, 0.05, 0.1});
  down.workspace_W = {Eigen::Vector3d(0.1, -1, -1), Eigen::Vector3d(1, 1, 1)};
  const Remedies all = remedies();
  const Remedy* workspace = of(all, RemedyChange::kWorkspace);
  ASSERT_NE(workspace, nullptr);
  const double needed = workspace->amounts.front().needed;
  EXPECT_NEAR(needed, 0.1, 0.03);
  down.workspace_W.min().array() -= needed;
  EXPECT_EQ(count(), workspace->grasps);
}

TEST_F(RemediesTest, SaysWhatDoesNotHelp) {
  put({0.4, 0.4, 0.4});
  const Remedies all = remedies();
  EXPECT_THAT(all.found, IsEmpty());
  EXPECT_THAT(all.in_vain, ::testing::Contains("100 mm more opening (169 mm)"));
  EXPECT_THAT(in_words(all), StartsWith("It would not help: 100 mm more opening"));
}

TEST_F(RemediesTest, TheSameTwiceAndNothingHalfWhenTheTimeIsUp) {
  put({0.08, 0.09, 0.1});
  const Remedies once = remedies(), again = remedies();
  ASSERT_EQ(once.found.size(), again.found.size());
  for (std::size_t i = 0; i < once.found.size(); ++i) {
    EXPECT_EQ(once.found[i].text, again.found[i].text);
    EXPECT_EQ(once.found[i].grasps, again.found[i].grasps);
  }
  const Remedies hurried = remedies({.budget = 1e-4});
  EXPECT_THAT(hurried.found, IsEmpty());
  EXPECT_FALSE(hurried.complete);
  EXPECT_THAT(in_words(hurried), HasSubstr("not found out in time"));
  const Remedies none = remedies({.budget = 0});
  EXPECT_THAT(none.found, IsEmpty());
  EXPECT_EQ(in_words(none), "");
  EXPECT_THROW(remedies({.budget = std::numeric_limits<double>::quiet_NaN()}),
               std::invalid_argument);
  EXPECT_THROW(remedies({.budget = -1}), std::invalid_argument);
}

TEST(MotionRemedies, TheArmHasAWayWithNothingBesideTheObject) {
  const robot::Platform platform = robot::read_platform("config/robots/kr5_pg70.yaml");
  const robot::Positions home = platform.home("home").arm;
  PlatformScene scene;
  scene.object_pieces_W = {brick_at({0.04, 0.04, 0.16}, {0, 0, 0.08})};
  scene.obstacle_pieces_W = {brick_at({0.3, 0.3, 0.05}, {0, 0, 0.3})};  // a shelf over it
  PlatformGrasp grasp;
  grasp.X_WG.linear() << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  grasp.X_WG.translation() = Eigen::Vector3d(0, 0, 0.14);
  grasp.preshape = platform.hand.preshapes.front().name;
  const PlatformPickOptions options;
  ASSERT_FALSE(plan_platform_pick(platform, home, {grasp}, scene, options).motion.found());
  const Remedies all = remedies_for_motion(platform, home, {grasp}, scene, options, kPatient);
  ASSERT_FALSE(all.found.empty()) << in_words(all);
  EXPECT_EQ(all.found.front().amounts.front().change, RemedyChange::kNeighbours);
  scene.obstacle_pieces_W.clear();
  EXPECT_TRUE(plan_platform_pick(platform, home, {grasp}, scene, options).motion.found());
}

}  // namespace
}  // namespace prehend::planning

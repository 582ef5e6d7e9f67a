// Plans with a database behind them: stored grasps are reused where they serve.

#include "prehend/grasp/known/grasp_memory.h"

#include <unistd.h>

#include <filesystem>

#include <gtest/gtest.h>

#include "tests/grasp/hand_scene.h"

namespace prehend::grasp {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;

const robot::GripperModel kMemoryGripper;

class Memory : public ::testing::Test {
 protected:
  Memory() {
    std::string pattern = (std::filesystem::temp_directory_path() / "memory_XXXXXX").string();
    folder_ = ::mkdtemp(pattern.data());
    database_.emplace(folder_ / "grasps.db");
    options_.uncertainty.samples = 0;
  }
  ~Memory() override {
    database_.reset();
    std::filesystem::remove_all(folder_);
  }

  // A carton that stands at `p` [m], turned by `yaw` [rad].
  static PlacedObject at(const Vector3d& p, double yaw) {
    return {
        content_hash(mesh()), "carton",
        geometry::make_transform(Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Vector3d::UnitZ())), p)};
  }
  static geometry::TriangleMesh mesh() {
    return moved(geometry::make_box({0.04, 0.05, 0.1}), Vector3d(0, 0, 0.05));
  }
  GraspPlan plan(const PlacedObject& placed, const Obstacles& obstacles = {}) {
    surface::ObjectModel object;
    object.mesh_W = moved(mesh(), placed.X_WO);
    Reachability from_above;
    from_above.approach_W = -Vector3d::UnitZ();
    return plan_grasps_with_memory(*database_, placed, object, geometry::Plane{}, obstacles,
                                   HandToClose(gripper_), from_above, options_, &remembered_);
  }
  std::vector<StoredGrasp> stored() const {
    return database_->grasps(kMemoryGripper.name, content_hash(mesh()));
  }

  robot::HandModel gripper_ = robot::parallel_hand(kMemoryGripper);
  std::filesystem::path folder_;
  std::optional<GraspDatabase> database_;
  PlannerOptions options_;
  Remembered remembered_;
};

TEST_F(Memory, GraspsAreStoredOnceAndUsedWhereTheObjectStandsNext) {
  const PlacedObject here = at({0.1, 0, 0}, 0.3), there = at({-0.2, 0.1, 0}, 1.9);
  const auto first = plan(here);
  ASSERT_FALSE(first.grasps.empty());
  EXPECT_FALSE(remembered_.reused);
  EXPECT_EQ(stored().size(), first.grasps.size());
  const auto second = plan(there);
  EXPECT_TRUE(remembered_.reused);
  EXPECT_EQ(remembered_.stored, static_cast<int>(first.grasps.size()));
  EXPECT_EQ(second.candidates, remembered_.stored);
  EXPECT_EQ(stored().size(), first.grasps.size());
  ASSERT_FALSE(second.grasps.empty());
  EXPECT_EQ(second.grasps.front().generator, kGiven);
  // The best is the same grasp of the object.
  const RigidTransform X_OG = here.X_WO.inverse() * first.grasps.front().X_WG;
  const RigidTransform X_OG_there = there.X_WO.inverse() * second.grasps.front().X_WG;
  EXPECT_LT((X_OG.matrix() - X_OG_there.matrix()).norm(), 1e-3);
  EXPECT_NEAR(second.grasps.front().score, first.grasps.front().score, 1e-3);
}

TEST_F(Memory, WhatDoesNotServeIsTestedAndWhatIsFoundInsteadIsAdded) {
  const PlacedObject here = at({0.1, 0, 0}, 0);
  const auto first = plan(here);
  ASSERT_FALSE(first.grasps.empty());
  // Walls beside it leave one closing direction: only stored grasps along the other fall.
  Obstacles walls;
  const Vector3d best_side = first.grasps.front().X_WG.linear().col(1);
  for (const double side : {-1.0, 1.0}) {
    walls.meshes_W.push_back(moved(geometry::make_box({0.02, 0.02, 0.3}),
                                   Vector3d(0.1, 0, 0.15) + side * 0.055 * best_side));
  }
  const auto second = plan(here, walls);
  for (const auto& grasp : second.grasps) {
    EXPECT_LT(std::abs(grasp.X_WG.linear().col(1).dot(best_side)), 0.99);
  }
  // Nothing of the database serves under a lid: planned anew, in vain, and nothing is added.
  const std::size_t before = stored().size();
  Obstacles lid;
  lid.meshes_W.push_back(moved(geometry::make_box({0.3, 0.3, 0.02}), Vector3d(0.1, 0, 0.13)));
  const auto none = plan(here, lid);
  EXPECT_TRUE(none.grasps.empty());
  EXPECT_FALSE(remembered_.reused);
  EXPECT_GT(none.candidates, static_cast<int>(before));
  EXPECT_EQ(stored().size(), before);
}

TEST_F(Memory, WhatFailedRanksLower) {
  const PlacedObject here = at({0.1, 0, 0}, 0.3);
  plan(here);
  const auto before = plan(here);
  ASSERT_GT(before.grasps.size(), 1u);
  const Grasp best = before.grasps.front();
  ASSERT_TRUE(remember_execution(*database_, here, kMemoryGripper.name, best.X_WG, false));
  ASSERT_TRUE(remember_execution(*database_, here, kMemoryGripper.name, best.X_WG, false));
  EXPECT_FALSE(remember_execution(*database_, here, "another hand", best.X_WG, true));
  const auto after = plan(here);
  ASSERT_EQ(after.grasps.size(), before.grasps.size());
  double of_failed = -1;
  for (const auto& grasp : after.grasps) {
    if ((grasp.X_WG.matrix() - best.X_WG.matrix()).norm() < 1e-9) of_failed = grasp.score;
  }
  EXPECT_NEAR(of_failed, best.score / 3, 1e-9);
  for (std::size_t i = 1; i < after.grasps.size(); ++i) {
    EXPECT_GE(after.grasps[i - 1].score, after.grasps[i].score);
  }
}

TEST_F(Memory, HandsRememberPreshapes) {
  const TestHand hand("sdh2");
  const PlacedObject here = at({0.1, 0, 0}, 0.3), there = at({-0.2, 0.1, 0}, 1.9);
  PlannerOptions options = default_options(hand.model);
  options.candidates.circles.directions_per_circle = 4;
  options.candidates.circles.rolls = 2;
  options.candidates.circles.standoffs = 2;
  options.uncertainty.samples = 0;
  options.largest_count = 6;
  const auto plan_at = [&](const PlacedObject& placed) {
    surface::ObjectModel object;
    object.mesh_W = moved(mesh(), placed.X_WO);
    return plan_grasps_with_memory(*database_, placed, object, geometry::Plane{}, {}, hand.ready,
                                   {}, options, &remembered_);
  };
  const GraspPlan first = plan_at(here);
  ASSERT_FALSE(first.grasps.empty());
  EXPECT_FALSE(remembered_.reused);
  const GraspPlan second = plan_at(there);
  EXPECT_TRUE(remembered_.reused);
  ASSERT_FALSE(second.grasps.empty());
  EXPECT_LE(second.candidates, remembered_.stored);
  EXPECT_EQ(second.grasps.front().preshape, first.grasps.front().preshape);
  EXPECT_EQ(second.grasps.front().generator, kGiven);

  // Grasps of a hand that closed otherwise than any preshape of this one are left out.
  auto known = database_->grasps(hand.model.name, here.hash);
  for (auto& grasp : known) grasp.joints.front() += 0.1;
  database_->replace(hand.model.name, here.hash, "carton", known);
  const GraspPlan third = plan_at(here);
  EXPECT_FALSE(remembered_.reused);
  EXPECT_EQ(third.grasps.size(), first.grasps.size());
}

}  // namespace
}  // namespace prehend::grasp

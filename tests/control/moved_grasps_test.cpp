#include "prehend/control/moved_grasps.h"

#include <cmath>
#include <numbers>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/control/failed_attempts.h"
#include "tests/control/grasp_cycle_fixture.h"

namespace prehend::control {
namespace {

using ::testing::HasSubstr;

/// Turned by `angle` about `axis` through `at`, then moved.
RigidTransform turned_by(const Eigen::Vector3d& axis, double angle, const Eigen::Vector3d& at,
                         const Eigen::Vector3d& moved) {
  RigidTransform X = RigidTransform::Identity();
  X.linear() = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
  X.translation() = at - X.linear() * at + moved;
  return X;
}

std::vector<grasp::Grasp> two_grasps() {
  std::vector<grasp::Grasp> grasps{grasp_at(0), grasp_at(0.02)};
  for (grasp::Grasp& grasp : grasps) {
    grasp.left_contacts_W = {grasp.X_WG.translation() + Eigen::Vector3d(0, 0.025, -0.02)};
    grasp.right_contacts_W = {grasp.X_WG.translation() + Eigen::Vector3d(0, -0.025, -0.02)};
  }
  return grasps;
}

TEST(MovedGrasps, GoWithTheObject) {
  const auto X = turned_by(Eigen::Vector3d::UnitZ(), 0.8, {0, 0, 0}, {0.1, -0.2, 0});
  const auto before = two_grasps();
  const MovedGrasps now = moved_grasps(before, X);
  ASSERT_EQ(now.grasps.size(), 2u) << now.problem;
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_TRUE(now.grasps[i].X_WG.isApprox(X * before[i].X_WG, 1e-12));
    EXPECT_TRUE(now.grasps[i].left_contacts_W[0].isApprox(X * before[i].left_contacts_W[0], 1e-12));
    EXPECT_TRUE(now.grasps[i].approach_W.isApprox(before[i].approach_W));
  }
}

TEST(MovedGrasps, StayUprightWhereTheObjectLeansALittle) {
  const auto X = turned_by(Eigen::Vector3d::UnitX(), 0.06, {0, 0, 0.02}, {0.1, 0, 0});
  const auto before = two_grasps();
  const MovedGrasps now = moved_grasps(before, X);
  ASSERT_EQ(now.grasps.size(), 2u) << now.problem;
  EXPECT_TRUE((now.grasps[0].X_WG.linear().col(2)).isApprox(-Eigen::Vector3d::UnitZ(), 1e-9));
  // The contacts' middle is where the object took it.
  const Eigen::Vector3d middle_G(0, 0, 0.02);  // in the hand, z down
  EXPECT_TRUE((now.grasps[0].X_WG * middle_G).isApprox(X * (before[0].X_WG * middle_G), 1e-9));
}

TEST(MovedGrasps, AreRefusedWithTheReason) {
  const auto reason = [](const RigidTransform& X, const MovedGraspLimits& limits = {}) {
    const MovedGrasps now = moved_grasps(two_grasps(), X, limits);
    EXPECT_TRUE(now.grasps.empty());
    return now.problem;
  };
  EXPECT_THAT(
      reason(turned_by(Eigen::Vector3d::UnitX(), std::numbers::pi / 2, {0, 0, 0}, {0, 0, 0})),
      HasSubstr("tipped by 90 deg"));
  EXPECT_THAT(reason(turned_by(Eigen::Vector3d::UnitZ(), 0, {0, 0, 0}, {0, 0, -0.7})),
              HasSubstr("700 mm lower"));
  MovedGraspLimits near;
  near.workspace_W = {Eigen::Vector3d(-0.3, -0.3, -1), Eigen::Vector3d(0.3, 0.3, 1)};
  EXPECT_THAT(reason(turned_by(Eigen::Vector3d::UnitZ(), 0, {0, 0, 0}, {0.5, 0, 0}), near),
              HasSubstr("reach"));
  RigidTransform nowhere = RigidTransform::Identity();
  nowhere.linear() *= std::nan("");
  EXPECT_FALSE(reason(nowhere).empty());
  EXPECT_THAT(moved_grasps({}, RigidTransform::Identity()).problem, HasSubstr("no grasp"));
}

TEST(MovedGrasps, FromTheSideCannotTurnWithTheObject) {
  auto grasps = two_grasps();
  grasps[1].approach_W = Eigen::Vector3d::UnitX();
  grasps[1].X_WG.linear() = (Eigen::Matrix3d() << 0, 0, 1, 0, 1, 0, -1, 0, 0).finished();
  const auto turned =
      moved_grasps(grasps, turned_by(Eigen::Vector3d::UnitZ(), 1.2, {0, 0, 0}, {0, 0, 0}));
  EXPECT_EQ(turned.grasps.size(), 1u);
  std::swap(grasps[0], grasps[1]);
  EXPECT_THAT(
      moved_grasps(grasps, turned_by(Eigen::Vector3d::UnitZ(), 1.2, {0, 0, 0}, {0, 0, 0})).indices,
      ::testing::ElementsAre(1));
  const auto shifted =
      moved_grasps(grasps, turned_by(Eigen::Vector3d::UnitZ(), 0, {0, 0, 0}, {0.1, 0, 0}));
  EXPECT_EQ(shifted.grasps.size(), 2u);
}

TEST(FailedAttempts, NameWhatCameFurthestAndTheLast) {
  FailedAttempts attempts;
  attempts.add(4, "closed on nothing");
  EXPECT_EQ(attempts.text(), "no grasp succeeded in 1 attempt; the last: closed on nothing");
  attempts.add(9, "lost while carrying");
  attempts.add(4, "closed on nothing again");
  EXPECT_EQ(attempts.text(),
            "no grasp succeeded in 3 attempts; attempt 2 came furthest: lost while carrying; "
            "the last: closed on nothing again");
  attempts.clear();
  attempts.add(9, "lost while carrying");
  EXPECT_EQ(attempts.text(), "no grasp succeeded in 1 attempt; the last: lost while carrying");
}

}  // namespace
}  // namespace prehend::control

#include "prehend/robot/placed_links.h"

#include <limits>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

namespace prehend::robot {
namespace {

// The links of a hand are where its own kinematics has them, carried by the arm.
TEST(PlacedLinks, StandWhereArmAndHandHaveThem) {
  const Platform platform = read_platform("config/robots/kr5_sdh.yaml");
  const KinematicChain chain = platform.arm_chain();
  const Positions arm = platform.home("home").arm;
  const Eigen::VectorXd hand = platform.hand.all_positions(platform.hand.preshapes.front().open);
  const std::vector<geometry::TriangleMesh> placed = placed_links(platform, arm, hand);
  ASSERT_FALSE(placed.empty());
  std::vector<geometry::RigidTransform> X_HL;
  platform.hand.link_poses(hand, X_HL);
  const geometry::RigidTransform X_WH = platform.X_WB * chain.forward(arm) * platform.X_FH;
  Eigen::AlignedBox3d all, fingers;
  for (const auto& link : placed) all.extend(geometry::bounds(link));
  for (std::size_t l = 0; l < X_HL.size(); ++l) {
    if (!platform.hand.model.links[l].shapes.empty()) {
      fingers.extend((X_WH * X_HL[l]).translation());
    }
  }
  EXPECT_TRUE(all.contains(fingers));
  // Turning the first joint carries the hand round the base.
  Positions turned = arm;
  turned[0] += 0.3;
  const auto there = placed_links(platform, turned, hand);
  const geometry::RigidTransform X =
      platform.X_WB * chain.forward(turned) * (platform.X_WB * chain.forward(arm)).inverse();
  for (const auto& [before, after] : {std::pair(&placed.back(), &there.back())}) {
    ASSERT_EQ(before->vertices.size(), after->vertices.size());
    for (std::size_t v = 0; v < before->vertices.size(); ++v) {
      EXPECT_LT((X * before->vertices[v] - after->vertices[v]).norm(), 1e-9);
    }
  }
}

TEST(PlacedLinks, AreThoseOfTheArmAndThoseOfTheHand) {
  for (const std::string name : {"kr5_sdh", "pa10_barrett", "pa10_sensorhand", "stage_pg70"}) {
    const Platform platform = read_platform("config/robots/" + name + ".yaml");
    const Positions arm = platform.home("home").arm;
    const Eigen::VectorXd hand = platform.hand.all_positions(platform.hand.preshapes.front().open);
    const geometry::RigidTransform X_WH =
        platform.X_WB * platform.arm_chain().forward(arm) * platform.X_FH;
    std::vector<geometry::TriangleMesh> both = placed_arm_links(platform, arm);
    const auto of_hand = placed_hand_links(platform.hand, X_WH, hand);
    EXPECT_FALSE(of_hand.empty()) << name;
    both.insert(both.end(), of_hand.begin(), of_hand.end());
    const auto all = placed_links(platform, arm, hand);
    ASSERT_EQ(both.size(), all.size()) << name;
    Eigen::AlignedBox3d apart, together;
    for (const auto& link : both) apart.extend(geometry::bounds(link));
    for (const auto& link : all) together.extend(geometry::bounds(link));
    EXPECT_LT((apart.min() - together.min()).norm(), 1e-9) << name;
    EXPECT_LT((apart.max() - together.max()).norm(), 1e-9) << name;
  }
}

TEST(PlacedLinks, RefusesPositionsOfAnotherRobot) {
  const Platform platform = read_platform("config/robots/stage_pg70.yaml");
  const Positions arm = platform.home("home").arm;
  const Eigen::VectorXd hand = platform.hand.all_positions(platform.hand.preshapes.front().open);
  EXPECT_FALSE(placed_links(platform, arm, hand).empty());
  EXPECT_THROW(placed_links(platform, Eigen::VectorXd::Zero(9), hand), std::invalid_argument);
  EXPECT_THROW(placed_links(platform, arm, Eigen::VectorXd::Zero(0)), std::invalid_argument);
  EXPECT_THROW(placed_arm_links(platform, Eigen::VectorXd::Zero(9)), std::invalid_argument);
  EXPECT_THROW(placed_hand_links(platform.hand, geometry::RigidTransform::Identity(),
                                 Eigen::VectorXd::Zero(9)),
               std::invalid_argument);
  Positions nowhere = arm;
  nowhere[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(placed_links(platform, nowhere, hand), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::robot

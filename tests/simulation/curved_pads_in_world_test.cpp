// Pads on curved surfaces in a robot's world, beside closed forms (tests/contact/curved_pads_test).

#include <cmath>
#include <memory>

#include <gtest/gtest.h>

#include "prehend/robot/pad_surface.h"
#include "prehend/simulation/explain.h"
#include "prehend/simulation/robot_world.h"
#include "prehend/simulation/shapes.h"

namespace prehend::simulation {
namespace {

constexpr double kRadius = 0.01;         // m, of the tip
constexpr double kBlock = 0.05;          // m, height of what it presses on
constexpr double kRoot = 0.155;          // m, of the probe's housing over the table, tip downward
constexpr double kTip = 0.09 + kRadius;  // m, from there to the tip's end, drawn in

double stiffness_of_area(const robot::HandModel& hand) {  // N/m^3
  return hand.pads.front().model.law.stiffness / contact::kReferenceTexelArea;
}

struct Pressing {
  double depth = 0;  // m, of the tip's end in the block
  double force = 0;  // N, along the probe, at the wrist
  double sideways = 0;
  HandPadReading pad;
  Eigen::Vector3d texels = Eigen::Vector3d::Zero();  // N, sum on the pad in its link
  bool touches_beside = false;  // of what presses on the block anything is not a texel
};

Pressing press(const robot::HandModel& hand, double effort) {
  geometry::RigidTransform X_WH = geometry::RigidTransform::Identity();
  X_WH.linear() = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
  X_WH.translation().z() = kRoot;
  RobotWorld world(hand, X_WH);
  geometry::TriangleMesh block = make_standing_box({0.08, 0.08, kBlock});
  // Flanks that slide along what they are pressed on would bear a part by friction.
  world.add_object("block", block, 5, true, 1e-3);
  HandCommand command;
  command.position = Eigen::VectorXd::Constant(1, 0.03);
  command.until_contact = true;
  command.speed = 0.3;
  command.effort = Eigen::VectorXd::Constant(1, effort);
  world.move_hand(command);
  for (int i = 0; i < 1500; ++i) world.step();
  Pressing result;
  result.depth = kBlock - (kRoot - kTip - world.hand_positions()[0]);
  const ContactWrench wrist = world.wrist_wrench();
  result.force = -wrist.force.z();
  result.sideways = wrist.force.head<2>().norm();
  result.pad = world.pads().front();
  const contact::PadLayout& layout = *hand.pads.front().layout;
  std::size_t touching = 0;
  for (std::size_t i = 0; i < layout.size(); ++i) {
    result.texels += result.pad.force[i] * (hand.pads.front().X_LP.linear() * layout.normal(i));
    touching += result.pad.force[i] > 0;
  }
  result.touches_beside = world.object_touches("block").size() > touching;
  return result;
}

// The probe with its tip a cylinder across it, and a grid laid on that.
robot::HandModel roller(int rows, int columns) {
  robot::HandModel hand = robot::read_hand_model("config/robots/ball_probe.yaml");
  robot::HandPad& pad = hand.pads.front();
  robot::Link& link = hand.model.links[static_cast<std::size_t>(pad.link)];
  robot::CollisionShape cylinder;
  cylinder.kind = robot::CollisionShape::Kind::kCylinder;
  cylinder.radius = kRadius;
  cylinder.length = 0.0202;
  cylinder.X_LS.linear() = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX()).toRotationMatrix();
  link.shapes = {cylinder};
  pad.X_LP.translation().z() = kRadius;
  pad.model.rows = rows;
  pad.model.columns = columns;
  pad.layout = std::make_shared<const contact::PadLayout>(
      robot::lay_on_link(link, pad.X_LP, {rows, columns, 0.016, 0.02, pad.model.thickness}));
  return hand;
}

TEST(CurvedPadsInWorld, AHalfBallBearsTheIntegralOverItsCap) {
  const robot::HandModel probe = robot::read_hand_model("config/robots/ball_probe.yaml");
  double before = 0;
  for (const double effort : {2.0, 6.0, 12.0}) {
    const Pressing result = press(probe, effort);
    EXPECT_GT(result.depth, before + 2e-4);
    before = result.depth;
    const double force = M_PI * kRadius * stiffness_of_area(probe) * std::pow(result.depth, 2);
    EXPECT_NEAR(result.force, force, 0.12 * force) << "193 texels";
    EXPECT_NEAR(result.texels.z(), result.force, 0.01 * result.force) << "all is felt";
    EXPECT_LT(result.sideways, 0.01 * result.force) << "by symmetry";
    EXPECT_FALSE(result.touches_beside) << "the rod behind the foam is not met";
    EXPECT_EQ(result.pad.rows * result.pad.columns, 193);
    EXPECT_EQ(result.pad.counts.size(), 193u);
  }
}

TEST(CurvedPadsInWorld, AGridOnACylinderBearsTheSameHoweverItIsDivided) {
  for (const auto& [rows, columns] : {std::pair{5, 16}, {10, 32}, {20, 64}}) {
    const robot::HandModel hand = roller(rows, columns);
    const Pressing result = press(hand, 8);
    const double d = result.depth, c = (kRadius - d) / kRadius, t = std::acos(c);
    const double force =
        2 * stiffness_of_area(hand) * kRadius * 0.02 * (kRadius * std::sin(t) - (kRadius - d) * t);
    EXPECT_GT(result.force, 2);
    EXPECT_NEAR(result.force, force, 0.05 * force) << rows << " x " << columns;
    EXPECT_NEAR(result.texels.z(), result.force, 0.01 * result.force);
    EXPECT_EQ(result.pad.rows, rows);
    EXPECT_EQ(result.pad.columns, columns);
  }
}

TEST(CurvedPadsInWorld, TheRodIsMetWhereItsFoamEnds) {
  robot::HandModel soft = robot::read_hand_model("config/robots/ball_probe.yaml");
  soft.pads.front().model.law.stiffness = 100;
  const Pressing result = press(soft, 15);
  EXPECT_TRUE(result.touches_beside);
  EXPECT_GT(result.depth, 0.003);
  EXPECT_LT(result.depth, 0.004) << "a point's spring gives way by 0.1 mm for 2 N";
  EXPECT_LT(result.texels.z(), 0.6 * result.force);
}

TEST(CurvedPadsInWorld, CellsThatAreNotThereShowNothingWhateverTheNoise) {
  const robot::HandModel hand = robot::read_hand_model("config/robots/bh8.yaml");
  RobotWorldOptions options;
  options.tactile.sensor = TactileSensorOptions::realistic();
  options.tactile.sensor.noise = 50;
  options.tactile.sensor.threshold = 0;
  geometry::RigidTransform X_WH = geometry::RigidTransform::Identity();
  X_WH.translation().z() = 0.5;
  RobotWorld world(hand, X_WH, "", options);
  int noisy = 0;
  for (int i = 0; i < 100; ++i) {
    world.step();
    const std::vector<HandPadReading> pads = world.pads();
    for (const std::size_t corner : {0, 3, 24, 27}) EXPECT_EQ(pads.back().counts[corner], 0);
    noisy += pads.back().counts[1] > 0;
  }
  EXPECT_GT(noisy, 20);
}

// What is said of a pad, its law left out.
std::string explained(const robot::HandModel& hand, const std::string& pad) {
  const RobotWorld world(hand, geometry::RigidTransform::Identity());
  for (const ModelledPart& part : world.explained().modelled) {
    if (part.what == "pad " + pad) return part.how.substr(0, part.how.find(':'));
  }
  return "";
}

TEST(CurvedPadsInWorld, AreExplained) {
  EXPECT_EQ(explained(robot::read_hand_model("config/robots/ball_probe.yaml"), "tip"),
            "on tip, a mesh's surface, 193 texels of 6.22 cm2, 3 mm of foam");
  const robot::HandModel barrett = robot::read_hand_model("config/robots/bh8.yaml");
  EXPECT_EQ(explained(barrett, "palm"),
            "on palm, laid on its surface, 24 texels (7 x 4 without 4) of 8.64 cm2, 3 mm of foam");
  EXPECT_EQ(explained(barrett, "fingertip_2"),
            "on finger_2_outer_link, laid on its surface, 8 x 3 texels of 6 cm2, 3 mm of foam");
  EXPECT_EQ(explained(robot::read_hand_model("config/robots/sdh2.yaml"), "thumb_distal"),
            "on thumb_distal_link, flat, 13 x 6 texels of 9.02 cm2, 3 mm of foam");
}

}  // namespace
}  // namespace prehend::simulation

#include "prehend/robot/hand_model.h"

#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

#include "tests/robot/arms.h"
#include "tests/robot/robot_file.h"

namespace prehend::robot {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;

HandModel shipped(const std::string& name) {
  return read_hand_model("config/robots/" + name + ".yaml");
}

RigidTransform pose_of(const HandModel& hand, const std::string& link, const Eigen::VectorXd& all) {
  std::vector<RigidTransform> poses;
  hand.link_poses(all, poses);
  return poses[static_cast<std::size_t>(hand.model.link_index(link))];
}

Eigen::VectorXd actuated(const HandModel& hand,
                         const std::vector<std::pair<std::string, double>>& set) {
  Eigen::VectorXd q = Eigen::VectorXd::Zero(hand.size());
  for (const auto& [joint, value] : set) q[hand.actuated_index(joint)] = value;
  return q;
}

TEST(Sdh2, HasThePublishedSizes) {
  const HandModel hand = shipped("sdh2");
  EXPECT_EQ(hand.size(), 7);
  EXPECT_NEAR(hand.mass(), 1.95, 0.01);
  EXPECT_EQ(hand.pads.size(), 6u);
  const Eigen::VectorXd zero = hand.all_positions(Eigen::VectorXd::Zero(7));
  const Vector3d first = pose_of(hand, "finger_1_knuckle", zero).translation();
  const Vector3d second = pose_of(hand, "finger_2_knuckle", zero).translation();
  const Vector3d thumb = pose_of(hand, "thumb_knuckle", zero).translation();
  EXPECT_NEAR((first - second).norm(), 0.066, 1e-9);
  EXPECT_NEAR((first - thumb).norm(), 0.066, 2e-5);
  EXPECT_NEAR((second - thumb).norm(), 0.066, 2e-5);
  // Upright: palm, pivot to proximal axis, to distal axis, to the fingertip.
  const Vector3d tip = pose_of(hand, "thumb_distal_link", zero) * Vector3d(0, 0, 0.0685);
  EXPECT_TRUE(tip.isApprox(Vector3d(-0.0381, 0, 0.0745 + 0.0165 + 0.0865 + 0.0685), 1e-9));
}

TEST(Sdh2, PivotTurnsTwoFingersInOppositeSenses) {
  const HandModel hand = shipped("sdh2");
  for (const double degrees : {0.0, 30.0, 60.0, 90.0}) {
    const double angle = degrees * std::numbers::pi / 180;
    const Eigen::VectorXd all = hand.all_positions(actuated(hand, {{"pivot", angle - 1e-7}}));
    const Vector3d first = pose_of(hand, "finger_1_distal_link", all).linear().col(0);
    const Vector3d second = pose_of(hand, "finger_2_distal_link", all).linear().col(0);
    EXPECT_LT((first - Vector3d(-std::cos(angle), -std::sin(angle), 0)).norm(), 1e-6);
    EXPECT_LT((second - Vector3d(-std::cos(angle), std::sin(angle), 0)).norm(), 1e-6);
  }
  // At 60 degrees all three look at the middle of the triangle.
  const Eigen::VectorXd all = hand.all_positions(actuated(hand, {{"pivot", std::numbers::pi / 3}}));
  for (const char* link : {"finger_1_knuckle", "finger_2_knuckle", "thumb_knuckle"}) {
    const RigidTransform X = pose_of(hand, link, all);
    const Vector3d out = (Vector3d(0, 0, X.translation().z()) - X.translation()).normalized();
    EXPECT_GT(out.dot(X.linear().col(0)), 0.99999) << link;
  }
}

TEST(Sdh2, ParallelPreshapeKeepsTheDistalLinksUpright) {
  const HandModel hand = shipped("sdh2");
  const Preshape& parallel = hand.preshape("parallel");
  for (const double t : {0.0, 0.3, 0.6}) {
    Eigen::VectorXd q = parallel.open;
    for (int i = 0; i < hand.size(); ++i) {
      q[i] += t * parallel.closing[static_cast<std::size_t>(i)].rate;
    }
    const Eigen::VectorXd all = hand.all_positions(q);
    for (const char* link : {"finger_1_distal_link", "finger_2_distal_link", "thumb_distal_link"}) {
      EXPECT_NEAR(pose_of(hand, link, all).linear()(2, 2), 1, 1e-12) << link;
    }
    // Closing brings the fingers nearer to the thumb, as 2 x 86.5 mm x the sines tell.
    const double gap = pose_of(hand, "finger_1_distal_link", all).translation().x() -
                       pose_of(hand, "thumb_distal_link", all).translation().x();
    EXPECT_NEAR(gap, 0.05715 + 2 * 0.0865 * std::sin(0.45 - t), 1e-9);
  }
}

TEST(Sdh2, PadsLookOutOfTheClosingSide) {
  const HandModel hand = shipped("sdh2");
  const Eigen::VectorXd all = hand.all_positions(hand.preshape("parallel").open);
  std::vector<RigidTransform> poses;
  hand.link_poses(all, poses);
  for (const HandPad& pad : hand.pads) {
    const RigidTransform X_HP = poses[static_cast<std::size_t>(pad.link)] * pad.X_LP;
    const bool thumb = pad.name.find("thumb") != std::string::npos;
    EXPECT_GT((thumb ? 1 : -1) * X_HP.linear()(0, 2), 0.5) << pad.name;  // inwards
    EXPECT_GT(X_HP.linear()(2, 1), 0.5) << pad.name;                     // row 0 at the tip
    EXPECT_NEAR(X_HP.linear().determinant(), 1, 1e-12);
    EXPECT_EQ(pad.model.rows, pad.name.find("distal") != std::string::npos ? 13 : 14);
    // The face lies on the link's shape.
    const CollisionShape& shape = hand.model.links[static_cast<std::size_t>(pad.link)].shapes[0];
    const Vector3d in_shape = shape.X_LS.inverse() * pad.X_LP.translation();
    EXPECT_NEAR(in_shape.x(), shape.size.x() / 2, 1e-9) << pad.name;
    EXPECT_LE(std::abs(in_shape.z()) + pad.model.length() / 2, shape.size.z() / 2) << pad.name;
  }
}

TEST(Bh8, HasThePublishedSizesAndCouplings) {
  const HandModel hand = shipped("bh8");
  EXPECT_EQ(hand.size(), 4);
  EXPECT_NEAR(hand.mass(), 0.98, 0.01);
  const double spread = 0.7, inner = 0.9, degree = std::numbers::pi / 180;
  const Eigen::VectorXd all = hand.all_positions(
      actuated(hand, {{"spread", spread}, {"finger_2_inner", inner}, {"finger_3_inner", 0.3}}));
  EXPECT_NEAR(all[hand.model.joint_index("finger_2_outer")], inner / 3, 1e-12);
  // GraspIt's Denavit-Hartenberg chain: 50 mm, 70 mm at inner - 2.46 deg, 50 mm at 42.46 deg more.
  const double first = inner - 2.46 * degree, second = inner + 40 * degree + inner / 3;
  const double out = 0.05 + 0.07 * std::cos(first) + 0.05 * std::cos(second);
  const double up = 0.08 + 0.07 * std::sin(first) + 0.05 * std::sin(second);
  const Vector3d tip = pose_of(hand, "finger_2_outer_link", all) * Vector3d(0.05, 0, 0);
  EXPECT_TRUE(
      tip.isApprox(Vector3d(out * std::cos(spread), 0.025 + out * std::sin(spread), up), 1e-5))
      << tip.transpose();
  // The spread is shared in opposite senses; finger 3 stands opposite.
  const Vector3d other = pose_of(hand, "finger_1_base", all).linear().col(0);
  EXPECT_TRUE(other.isApprox(Vector3d(std::cos(spread), -std::sin(spread), 0), 1e-9));
  const Vector3d third = pose_of(hand, "finger_3_inner_link", all).translation();
  EXPECT_TRUE(third.isApprox(Vector3d(-0.05, 0, 0.08), 1e-9));
  ASSERT_EQ(hand.breakaways.size(), 3u);
  EXPECT_NEAR(hand.breakaways[0].rate, 125 / 93.75, 1e-12);
}

TEST(Pg70, IsTheGripperOfItsModel) {
  const HandModel hand = shipped("pg70");
  const GripperModel gripper = read_gripper_model("config/robots/pg70_dsa.yaml");
  const Preshape& open = hand.preshape("open");
  std::vector<RigidTransform> poses;
  hand.link_poses(hand.all_positions(open.open), poses);
  const RigidTransform X_GP = open.X_PG.inverse();
  for (const HandPad& pad : hand.pads) {
    const RigidTransform X_GPad = X_GP * poses[static_cast<std::size_t>(pad.link)] * pad.X_LP;
    const double side = pad.name == "left" ? 1 : -1;
    EXPECT_TRUE(
        X_GPad.translation().isApprox(Vector3d(0, side * gripper.max_opening / 2, 0), 1e-9));
    EXPECT_TRUE(X_GPad.linear().col(2).isApprox(Vector3d(0, -side, 0), 1e-9));
  }
  const CollisionShape& finger =
      hand.model.links[static_cast<std::size_t>(hand.model.link_index("left_finger"))].shapes[0];
  EXPECT_TRUE(finger.size.isApprox(gripper.finger_size, 1e-9));
  const CollisionShape& housing = hand.model.links[0].shapes[0];
  EXPECT_TRUE(housing.size.isApprox(gripper.housing_size, 1e-9));
  EXPECT_NEAR((X_GP * housing.X_LS).translation().z() + housing.size.z() / 2,
              gripper.housing_front_z(), 1e-9);
  EXPECT_NEAR(
      (X_GP * poses[static_cast<std::size_t>(hand.model.link_index("left_finger"))] * finger.X_LS)
              .translation()
              .z() +
          finger.size.z() / 2,
      gripper.tip_z(), 1e-9);
}

TEST(HandModel, EveryPreshapeIsWithinTheLimitsAllTheWayOpen) {
  for (const char* name : {"sdh2", "bh8", "sensorhand", "pg70"}) {
    const HandModel hand = shipped(name);
    for (const Preshape& preshape : hand.preshapes) {
      EXPECT_EQ(hand.limit_problem(hand.all_positions(preshape.open)), "") << preshape.name;
      EXPECT_NEAR(preshape.X_PG.linear().determinant(), 1, 1e-12);
    }
    EXPECT_THROW(hand.all_positions(Eigen::VectorXd::Zero(hand.size() + 1)), std::invalid_argument);
  }
  const HandModel sdh = shipped("sdh2");
  EXPECT_EQ(sdh.limit_problem(sdh.all_positions(actuated(sdh, {{"thumb_distal", 1.7}}))),
            "joint 'thumb_distal' at 97.4 deg is beyond 90.0 deg");
}

// The planner knows the names: here any will do.
TEST(HandModel, SaysByWhichMethodItCloses) {
  HandModel hand = shipped("bh8");
  EXPECT_EQ(hand.closing, "");
  EXPECT_EQ(hand.closing_method(), "fingers");
  EXPECT_EQ(shipped("pg70").closing_method(), "pads");
  EXPECT_EQ(parallel_hand({}).closing_method(), "pads");
  hand.closing = "scoop";
  EXPECT_EQ(hand.closing_method(), "scoop");
}

class HandFile : public RobotFile {
 protected:
  std::string error(const std::string& from, const std::string& to,
                    const std::string& file = "sdh2.yaml") {
    return error_of([&] { read_hand_model(changed(file, from, to)); });
  }
};

#define EXPECT_HAS(text, part) EXPECT_NE((text).find(part), std::string::npos) << (text)

TEST_F(HandFile, ErrorsNameLineNearestAndMend) {
  std::string text = error("friction: 0.7", "fricton: 0.7");
  EXPECT_HAS(text, "sdh2.yaml:12: unknown key 'fricton'");
  EXPECT_HAS(text, "'friction'");
  text = error("palm: palm", "palm: plam");
  EXPECT_HAS(text, "sdh2.yaml:5:");
  EXPECT_HAS(text, "'palm'");
  text = error("finger_1_proximal: -0.45", "finger_1_proxmal: -0.45");
  EXPECT_HAS(text, "hand.preshapes.parallel.open.finger_1_proxmal");
  EXPECT_HAS(text, "The nearest is 'finger_1_proximal'");
  text = error("with: finger_1_proximal", "with: finger_1");
  EXPECT_HAS(text, "closing.finger_1_distal.with");
  EXPECT_HAS(error("thumb_proximal: -1.4", "thumb_proximal: -1.8"),
             "joint 'thumb_proximal' at -103.1 deg is beyond -90.0 deg");
  EXPECT_HAS(error("thumb_distal]", "finger_2_pivot]"), "does not move by itself");
  EXPECT_HAS(error(", thumb_distal]", "]"), "leaves out 'thumb_distal'");
  EXPECT_HAS(error("thumb_knuckle, thumb_prox", "thumb_prox"), "does not follow");
  EXPECT_HAS(error("rows: 14", "rows: 0"), "rows must be");
  EXPECT_HAS(error("normal: [1, 0, 0]", "normal: [0, 0, 0]"), "normal has no length");
  EXPECT_HAS(error("normal: [1, 0, 0]", "normal: [0, 0, 1]"), "does not lie in the face");
  EXPECT_HAS(error("friction: 0.7", "friction: -1"), "friction is not positive");
  EXPECT_HAS(error("friction: 0.7", "friction: .nan"), "no finite number");
  EXPECT_HAS(error("closing: fingers", "closing: ''"),
             "sdh2.yaml:13: hand.closing names no method");
  EXPECT_HAS(error("urdf: schunk_sdh2.urdf", "urdf: missing.urdf"), "missing.urdf");
  EXPECT_HAS(error("  pinch:", "  parallel:"), "parallel");
  EXPECT_HAS(error("torque: 0.5", "torque: 0", "bh8.yaml"), "torque is not positive");
  EXPECT_HAS(error("  finger_1_outer: {torque", "  finger_1_inner: {torque", "bh8.yaml"),
             "follows no joint");
  EXPECT_HAS(error_of([] { shipped("sdh2").preshape("cylindric"); }),
             "The nearest is 'cylindrical'");
  EXPECT_HAS(error_of([] { read_hand_model("config/robots/none.yaml"); }), "does not exist");
}

}  // namespace
}  // namespace prehend::robot

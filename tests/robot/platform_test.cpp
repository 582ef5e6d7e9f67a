#include "prehend/robot/platform.h"

#include <stdexcept>

#include <gtest/gtest.h>

#include "prehend/robot/inverse_kinematics.h"
#include "tests/robot/arms.h"
#include "tests/robot/robot_file.h"

namespace prehend::robot {
namespace {

using geometry::RigidTransform;

constexpr const char* kPlatforms[] = {"kr5_sdh", "pa10_barrett", "pa10_sensorhand", "kr5_pg70"};

Platform shipped_platform(const std::string& name) {
  return read_platform("config/robots/" + name + ".yaml");
}

TEST(Platform, HomesHoldTheHandDownWithinReach) {
  for (const char* name : kPlatforms) {
    const Platform platform = shipped_platform(name);
    const KinematicChain arm = platform.arm_chain();
    for (const Platform::Home& home : platform.homes) {
      const RigidTransform X_WF = platform.X_WB * arm.forward(home.arm);
      EXPECT_LT(X_WF.linear()(2, 2), -0.999) << name << " " << home.name;
      EXPECT_GT(X_WF.translation().z(), 0.3) << name << " " << home.name;
    }
  }
}

TEST(Platform, ToolIsWhereInverseKinematicsPutsIt) {
  for (const char* name : kPlatforms) {
    const Platform platform = shipped_platform(name);
    const KinematicChain arm = platform.arm_chain();
    const InverseKinematics inverse(arm);
    for (const Preshape& preshape : platform.hand.preshapes) {
      RigidTransform X_WG = RigidTransform::Identity();
      X_WG.linear() = Eigen::AngleAxisd(3.0, Eigen::Vector3d::UnitX()).toRotationMatrix();
      X_WG.translation() = Eigen::Vector3d(-0.05, 0.05, 0.1);
      const InverseAnswer answer = inverse.solve(platform.X_BF(X_WG, preshape));
      ASSERT_FALSE(answer.solutions.empty()) << name << " " << preshape.name << answer.reason;
      // Over the joined model: base to the hand's palm, then to the tool.
      const KinematicChain to_palm(platform.model, platform.base, "hand_palm");
      for (const Positions& q : answer.solutions) {
        EXPECT_LT(difference(platform.X_WB * to_palm.forward(q) * preshape.X_PG, X_WG), 1e-6);
      }
    }
  }
}

TEST(Platform, AStagesJointsAreWhereItsToolIs) {
  const Platform stage = shipped_platform("stage_pg70");
  EXPECT_EQ(stage.hand_port, HandPort::kGripper);
  const Positions q = (Positions(4) << 0.1, -0.2, 0.3, 0.5).finished();
  RigidTransform X_WG = RigidTransform::Identity();
  X_WG.rotate(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()));
  X_WG.linear() = X_WG.linear() * Eigen::Vector3d(1, -1, -1).asDiagonal();
  X_WG.translation() = q.head<3>();
  const Preshape& open = stage.hand.preshapes.front();
  EXPECT_LT(difference(stage.X_WB * stage.arm_chain().forward(q) * stage.X_FG(open), X_WG), 1e-12);
  EXPECT_EQ(stage.acceleration, (Positions(4) << 1, 1, 1, 3).finished());
}

TEST(Platform, OnlyAStageHasAFixedApproach) {
  const Platform stage = shipped_platform("stage_pg70");
  const auto down = stage.fixed_approach(stage.hand.preshapes.front());
  ASSERT_TRUE(down);
  EXPECT_EQ(*down, -Eigen::Vector3d::UnitZ());  // exactly
  for (const char* name : kPlatforms) {
    const Platform arm = shipped_platform(name);
    EXPECT_FALSE(arm.fixed_approach(arm.hand.preshapes.front())) << name;
    EXPECT_EQ(arm.hand_port, HandPort::kJoints) << name;
  }
  // Mounted across, the joint that turns tilts it.
  Platform across = stage;
  across.X_FH.rotate(Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitY()));
  EXPECT_FALSE(across.fixed_approach(across.hand.preshapes.front()));
}

TEST(Platform, TakesTheGripperThatARobotSays) {
  Platform stage = shipped_platform("stage_pg70");
  GripperModel wide = *stage.hand.gripper;
  wide.max_opening = 0.12;
  wide.pad.rows = 10;
  stage.set_gripper(wide);
  EXPECT_EQ(stage.hand.gripper->max_opening, 0.12);
  EXPECT_EQ(stage.hand.preshapes.front().open[0], 0.06);
  EXPECT_EQ(stage.hand.pads.front().model.rows, 10);
  for (const RobotModel* model : {&stage.hand.model, &stage.model}) {
    int jaws = 0;
    for (const Joint& joint : model->joints) jaws += joint.upper == 0.06;
    EXPECT_EQ(jaws, 2);
  }
  EXPECT_EQ(stage.arm_chain().joints()[0].upper, 0.6);  // the arm stays
}

TEST(Platform, JoinsArmAndHandWithTheirMimics) {
  const Platform platform = shipped_platform("pa10_barrett");
  const RobotModel& model = platform.model;
  const Joint& outer =
      model.joints[static_cast<std::size_t>(model.joint_index("hand_finger_2_outer"))];
  ASSERT_TRUE(outer.mimic);
  EXPECT_EQ(model.joints[static_cast<std::size_t>(outer.mimic->joint)].name, "hand_finger_2_inner");
  // Parents come before their children.
  for (const Joint& joint : model.joints) EXPECT_LT(joint.parent, joint.child) << joint.name;
  EXPECT_EQ(model.links.size(), platform.hand.model.links.size() +
                                    read_urdf("config/robots/pa10_7c.urdf").links.size());
}

TEST(Platform, HandFixedAtPositionsStandsThere) {
  const Platform platform = shipped_platform("kr5_sdh");
  const Eigen::VectorXd all = platform.hand.all_positions(platform.hand.preshape("spherical").open);
  const RobotModel fixed = platform.with_hand_at(all);
  const KinematicChain to_tip(fixed, platform.base, "hand_thumb_distal_link");
  EXPECT_EQ(to_tip.size(), 6);
  std::vector<RigidTransform> poses;
  platform.hand.link_poses(all, poses);
  const Positions& home = platform.home("home").arm;
  const RigidTransform expected =
      platform.arm_chain().forward(home) * platform.X_FH *
      poses[static_cast<std::size_t>(platform.hand.model.link_index("thumb_distal_link"))];
  EXPECT_LT(difference(to_tip.forward(home), expected), 1e-12);
  EXPECT_THROW(platform.with_hand_at(Eigen::VectorXd::Zero(3)), std::invalid_argument);
}

class PlatformFile : public RobotFile {
 protected:
  std::string error(const std::string& from, const std::string& to) {
    return error_of([&] { read_platform(changed("kr5_sdh.yaml", from, to)); });
  }
};

#define EXPECT_HAS(text, part) EXPECT_NE((text).find(part), std::string::npos) << (text)

TEST_F(PlatformFile, ErrorsNameLineNearestAndMend) {
  EXPECT_HAS(error("flange: tool0", "flange: tol0"), "The nearest is 'tool0'");
  EXPECT_HAS(error("mount:", "mout:"), "The nearest is 'mount'");
  EXPECT_HAS(error("axis_5: 1.5707963", "axis_5: 2.5"), "is beyond 120.0 deg");
  EXPECT_HAS(error("axis_6: 0}", "axis_7: 0}"), "home.axis_6 is missing");
  EXPECT_HAS(error("hand: sdh2.yaml", "hand: sdh3.yaml"), "sdh3.yaml does not exist");
  EXPECT_HAS(error("arm: kr5_sixx_r850.urdf", ""), "platform.arm is missing");
  EXPECT_HAS(error("xyz: [0, 0, 0.02]", "xyz: [0, 0]"), "3 finite numbers");
  const auto stage = [this](const std::string& from, const std::string& to) {
    return error_of([&] { read_platform(changed("stage_pg70.yaml", from, to)); });
  };
  EXPECT_HAS(stage("hand_port: gripper", "hand_port: grpper"), "Write one of joints, gripper");
  EXPECT_HAS(stage("hand: pg70.yaml", "hand: sdh2.yaml"), "but sdh2.yaml has none");
  EXPECT_HAS(stage("z: 1, yaw: 3}", "z: 0, yaw: 3}"), "acceleration.z is not positive");
  EXPECT_HAS(stage("z: 1, yaw: 3}", "yaw: 3}"), "acceleration.z is missing");
  EXPECT_HAS(error_of([] { shipped_platform("kr5_sdh").home("hme"); }), "The nearest is 'home'");
}

// The camera goes along with the flange: seen from it, nothing of the arm's motion is left.
TEST(Platform, TheCameraThatTheArmCarriesGoesAlong) {
  const Platform platform = read_platform("config/robots/kr5_sdh_camera.yaml");
  ASSERT_TRUE(platform.X_FC);
  EXPECT_FALSE(read_platform("config/robots/kr5_sdh.yaml").X_FC);
  for (const Platform::Home& home : platform.homes) {
    const geometry::RigidTransform X_WF = platform.X_WB * platform.arm_chain().forward(home.arm);
    EXPECT_TRUE((X_WF.inverse() * platform.X_WC(home.arm)).isApprox(*platform.X_FC)) << home.name;
  }
  // At home it looks down at the table in front of the arm.
  const geometry::RigidTransform X_WC = platform.X_WC(platform.home("home").arm);
  const Eigen::Vector3d eye = X_WC.translation(), ahead = X_WC.linear().col(2);
  ASSERT_LT(ahead.z(), -0.5);
  const Eigen::Vector3d on_table = eye - eye.z() / ahead.z() * ahead;
  EXPECT_LT(on_table.head<2>().norm(), 0.15) << on_table.transpose();
}

}  // namespace
}  // namespace prehend::robot

// Robots whose links are meshes in the simulated world, against the same with boxes.

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <unistd.h>

#include "prehend/simulation/robot_world.h"
#include "prehend/simulation/shapes.h"
#include "tests/robot/as_meshes.h"

namespace prehend::simulation {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;

class MeshRobotWorld : public testing::Test {
 protected:
  MeshRobotWorld()
      : folder_(std::filesystem::temp_directory_path() /
                ("prehend_mesh_world_" + std::to_string(getpid()))) {
    std::filesystem::remove_all(folder_);
    std::filesystem::copy("config/robots", folder_);
  }
  ~MeshRobotWorld() override { std::filesystem::remove_all(folder_); }

  robot::HandModel hand_of_meshes(const std::string& urdf, const std::string& hand) const {
    robot::write_with_meshes(urdf, folder_);
    return robot::read_hand_model(folder_ / hand);
  }

  std::filesystem::path folder_;
};

/// H above `p_W`, its z straight down, so that the tool of the first preshape is at `p_W`.
RigidTransform hand_above(const robot::HandModel& hand, const Vector3d& p_W) {
  RigidTransform X_WG = RigidTransform::Identity();
  X_WG.linear() = Eigen::AngleAxisd(M_PI, Vector3d::UnitX()).toRotationMatrix();
  X_WG.translation() = p_W;
  return X_WG * (hand.X_HP * hand.preshapes.front().X_PG).inverse();
}

struct Grip {
  double squeeze = 0;  // N, of each finger
  double weight = 0;   // N, borne by the wrist after a lift
  double slip = 0;     // m
  double opening = 0;  // m
};

/// A PG70 closes on a box of 40 mm with 30 N a finger and lifts it.
Grip grip(const robot::HandModel& hand, const geometry::TriangleMesh& object) {
  RobotWorld world(hand, hand_above(hand, {0, 0, 0.05}));
  world.add_object("box", object, 0.3);
  HandCommand close;
  close.position = Eigen::VectorXd::Zero(1);
  close.speed = 0.3;
  close.until_contact = true;
  // One motor moves both fingers.
  close.effort = Eigen::VectorXd::Constant(1, 60);
  world.move_hand(close);
  for (int i = 0; i < 4000 && world.hand().moving(); ++i) world.step();
  EXPECT_TRUE(world.hand().blocked());
  for (int i = 0; i < 300; ++i) world.step();
  Grip result;
  for (const LinkContact& contact : world.link_contacts()) {
    result.squeeze += std::abs(contact.force.y()) / 2;
  }
  result.opening = 2 * world.hand_positions()[0];
  const RigidTransform before = world.X_WH().inverse() * world.body("box").X_WB;
  RigidTransform up = world.X_WH();
  up.translation().z() += 0.1;
  world.carry(up, 1.0);
  for (int i = 0; i < 1500; ++i) world.step();
  result.weight = -(world.X_WH().linear() * world.wrist_wrench().force).z();
  const RigidTransform after = world.X_WH().inverse() * world.body("box").X_WB;
  result.slip = (after.translation() - before.translation()).norm();
  EXPECT_GT(world.body("box").height, 0.09);
  return result;
}

TEST_F(MeshRobotWorld, FingersOfMeshesHoldAsFingersOfBoxesDo) {
  const robot::HandModel boxes = robot::read_hand_model("config/robots/pg70.yaml");
  const robot::HandModel meshes = hand_of_meshes("pg70.urdf", "pg70.yaml");
  const geometry::TriangleMesh box = make_standing_box({0.05, 0.04, 0.1});
  const Grip a = grip(boxes, box), b = grip(meshes, box);
  EXPECT_NEAR(b.squeeze, a.squeeze, 0.05 * a.squeeze);
  EXPECT_NEAR(b.opening, a.opening, 1e-4);
  for (const Grip& one : {a, b}) {
    // What the motor gives is what both fingers press with; the wrist bears the weight.
    EXPECT_NEAR(one.squeeze, 30, 0.05 * 30);
    EXPECT_NEAR(one.weight, 0.3 * 9.81, 0.05 * 0.3 * 9.81);
    EXPECT_LT(one.slip, 0.001);
  }
}

TEST_F(MeshRobotWorld, ABodyOfAMeshWeighsAsTheBoxDoes) {
  const robot::HandModel boxes = robot::read_hand_model("config/robots/sdh2.yaml");
  const robot::HandModel meshes = hand_of_meshes("schunk_sdh2.urdf", "sdh2.yaml");
  const auto bodies = [](const robot::HandModel& hand) {
    const Eigen::VectorXd all = hand.all_positions(hand.preshapes.front().open);
    return make_robot_bodies(hand.model, hand, "", RigidTransform::Identity(), all);
  };
  const RobotBodies a = bodies(boxes), b = bodies(meshes);
  ASSERT_EQ(a.bodies.size(), b.bodies.size());
  for (std::size_t i = 0; i < a.bodies.size(); ++i) {
    EXPECT_NEAR(a.bodies[i].mass, b.bodies[i].mass, 1e-6) << a.bodies[i].name;
    EXPECT_LT((a.bodies[i].moments - b.bodies[i].moments).norm(), 0.01 * a.bodies[i].moments.norm())
        << a.bodies[i].name;
    EXPECT_LT((a.bodies[i].X_WB.translation() - b.bodies[i].X_WB.translation()).norm(), 1e-6)
        << a.bodies[i].name;
  }
}

TEST_F(MeshRobotWorld, FingersOfMeshesStopOneAnother) {
  const robot::HandModel boxes = robot::read_hand_model("config/robots/sdh2.yaml");
  const robot::HandModel meshes = hand_of_meshes("schunk_sdh2.urdf", "sdh2.yaml");
  // Fingers 1 and 2 against each other, as far as they come: one of them further than its half.
  const auto closed = [](const robot::HandModel& hand) {
    RigidTransform X_WH = RigidTransform::Identity();
    X_WH.translation().z() = 1;
    RobotWorld world(hand, X_WH, "pinch");
    HandCommand close;
    close.position = hand.preshape("pinch").open;
    close.position[hand.actuated_index("finger_1_proximal")] = 0.8;
    close.position[hand.actuated_index("finger_2_proximal")] = 0.8;
    close.speed = 1;
    close.until_contact = true;
    close.effort = Eigen::VectorXd::Constant(hand.size(), 0.5);
    world.move_hand(close);
    for (int i = 0; i < 3000 && world.hand().moving(); ++i) world.step();
    EXPECT_TRUE(world.hand().blocked());
    bool fingers = false;
    for (const LinkContact& contact : world.link_contacts()) {
      fingers = fingers || contact.link == "finger_1_distal_link";
    }
    EXPECT_TRUE(fingers);
    return world.hand_positions();
  };
  const Eigen::VectorXd a = closed(boxes), b = closed(meshes);
  EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 0.03) << a.transpose() << "\n" << b.transpose();
}

TEST_F(MeshRobotWorld, FingersOfAnOpenHandOfMeshesPressOnNothing) {
  for (const auto& [urdf, file] :
       {std::pair{"schunk_sdh2.urdf", "sdh2.yaml"}, std::pair{"barrett_bh8.urdf", "bh8.yaml"}}) {
    const robot::HandModel hand = hand_of_meshes(urdf, file);
    for (const robot::Preshape& preshape : hand.preshapes) {
      RigidTransform X_WH = RigidTransform::Identity();
      X_WH.translation().z() = 1;
      RobotWorld world(hand, X_WH, preshape.name);
      for (int i = 0; i < 20; ++i) world.step();
      for (const LinkContact& contact : world.link_contacts()) {
        ADD_FAILURE() << file << " " << preshape.name << ": " << contact.link << " "
                      << contact.normal_force << " N";
      }
    }
  }
}

TEST_F(MeshRobotWorld, MeshesAreDrawn) {
  const robot::HandModel meshes = hand_of_meshes("pg70.urdf", "pg70.yaml");
  const RobotWorld world(meshes, RigidTransform::Identity());
  std::size_t shapes = 0;
  for (const robot::Link& link : meshes.model.links) shapes += link.shapes.size();
  ASSERT_GT(shapes, 0u);
  const std::vector<VisibleBody> bodies = world.visible_bodies();
  ASSERT_EQ(bodies.size(), shapes);
  for (const VisibleBody& body : bodies) {
    EXPECT_GT(geometry::mass_properties(*body.mesh_B).volume, 1e-7) << body.name;
  }
}

TEST_F(MeshRobotWorld, AForeignArmCarriesAHand) {
  const char* data = std::getenv("PREHEND_SHARED_DATA");
  const std::filesystem::path iiwa =
      std::filesystem::path(data ? data : "") / "robots/kuka_iiwa/model.urdf";
  if (!data || !std::filesystem::exists(iiwa)) {
    GTEST_SKIP() << "PREHEND_SHARED_DATA names no folder with robots/kuka_iiwa/model.urdf, a robot "
                    "that is not part of this project";
  }
  std::ofstream(folder_ / "iiwa_sdh.yaml")
      << "name: iiwa_sdh\narm: " << iiwa.string()
      << "\nbase: lbr_iiwa_link_0\nflange: lbr_iiwa_link_7\nhand: sdh2.yaml\n"
         "mount: {xyz: [0, 0, 0.06]}\nworld: {xyz: [-0.6, 0, 0]}\n"
         "homes: {home: {lbr_iiwa_joint_1: 0, lbr_iiwa_joint_2: 0.4, lbr_iiwa_joint_3: 0, "
         "lbr_iiwa_joint_4: -1.5, lbr_iiwa_joint_5: 0, lbr_iiwa_joint_6: 1.2, "
         "lbr_iiwa_joint_7: 0}}\n";
  const robot::Platform platform = robot::read_platform(folder_ / "iiwa_sdh.yaml");
  EXPECT_EQ(platform.model.remarks.size(), 8u) << "its meshes have cracks";
  RobotWorld world(platform, Scene{});
  const RigidTransform before = world.X_WH();
  for (int i = 0; i < 200; ++i) world.step();
  EXPECT_LT((world.X_WH().translation() - before.translation()).norm(), 1e-6);
  const auto arm_is_touched = [&] {
    for (const LinkContact& contact : world.link_contacts()) {
      for (const char* link : {"_1", "_2", "_3", "_4", "_5", "_6"}) {
        if (contact.link == "arm_lbr_iiwa_link" + std::string(link)) return true;
      }
    }
    return false;
  };
  EXPECT_FALSE(arm_is_touched());
  // What stands where the forearm is touches it.
  RigidTransform X_WE = RigidTransform::Identity();
  for (const VisibleBody& body : world.visible_bodies()) {
    if (body.name == "arm_lbr_iiwa_link_4") X_WE = body.X_WB;
  }
  world.add_object("plate", geometry::transformed(geometry::make_box({0.5, 0.5, 0.02}), X_WE), 1.0,
                   true);
  world.step();
  EXPECT_TRUE(arm_is_touched());
}

}  // namespace
}  // namespace prehend::simulation

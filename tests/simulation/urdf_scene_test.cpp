#include "prehend/simulation/engines/urdf_scene.h"

#include <cmath>
#include <cstdlib>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "prehend/simulation/engines/multibody_engine.h"

namespace prehend::simulation::engines {
namespace {

const char* const kInertial =
    "<inertial><mass value='0.05'/><inertia ixx='1e-5' ixy='0' ixz='0' iyy='2e-5' iyz='0' "
    "izz='1.5e-5'/></inertial>";

std::string link(const std::string& name, const std::string& inside = "") {
  return "<link name='" + name + "'>" + inside + "</link>";
}

std::string joint(const std::string& name, const std::string& type, const std::string& parent,
                  const std::string& child, const std::string& inside) {
  return "<joint name='" + name + "' type='" + type + "'><parent link='" + parent +
         "'/><child link='" + child + "'/>" + inside + "</joint>";
}

std::string robot(const std::string& inside) {
  return "<?xml version='1.0'?><robot name='r'>" + inside + "</robot>";
}

// A palm and two jaws, the second coupled to the first; a finger plate is fixed to each.
std::string gripper() {
  const std::string plate =
      "<inertial><origin xyz='0 0 0.02'/><mass value='0.03'/><inertia ixx='1e-6' ixy='0' ixz='0' "
      "iyy='1e-6' iyz='0' izz='1e-6'/></inertial><collision><origin xyz='0 0 0.02'/><geometry><box "
      "size='0.02 0.01 0.05'/></geometry></collision>";
  const std::string limits = "<limit lower='0' upper='0.03' effort='200' velocity='0.1'/>";
  return robot(link("palm") + link("left", kInertial) + link("right", kInertial) +
               link("left_plate", plate) + link("right_plate", plate) +
               joint("close", "prismatic", "palm", "left",
                     "<origin xyz='0 0.04 0.1'/><axis xyz='0 -1 0'/>" + limits) +
               joint("follow", "prismatic", "palm", "right",
                     "<origin xyz='0 -0.04 0.1'/><axis xyz='0 -1 0'/><mimic joint='close' "
                     "multiplier='-1'/>" +
                         limits) +
               joint("left_fix", "fixed", "left", "left_plate", "<origin xyz='0 0 0.01'/>") +
               joint("right_fix", "fixed", "right", "right_plate", "<origin xyz='0 0 0.01'/>"));
}

TEST(Urdf, AGripperBecomesBodiesAndJoints) {
  UrdfOptions options;
  options.X_WR.translation().z() = 1;
  const UrdfScene read = parse_urdf(gripper(), "gripper", options);
  ASSERT_EQ(read.scene.bodies.size(), 3u);
  ASSERT_EQ(read.joint_names, (std::vector<std::string>{"close", "follow"}));
  EXPECT_TRUE(read.scene.bodies[0].is_fixed);
  const EngineBody& left = read.scene.bodies[read.scene.joints[0].body];
  EXPECT_EQ(left.name, "left");
  EXPECT_NEAR(left.mass, 0.08, 1e-15);
  // Centre of mass: 0.03 kg at 0.03 m above the jaw's.
  const double centre = 0.03 * 0.03 / 0.08;
  EXPECT_NEAR((left.X_WB.translation() - Eigen::Vector3d(0, 0.04, 1.1 + centre)).norm(), 0, 1e-12);
  const double apart = 0.05 * centre * centre + 0.03 * std::pow(0.03 - centre, 2);
  Eigen::Matrix3d inertia =
      left.X_WB.linear() * left.moments.asDiagonal() * left.X_WB.linear().transpose();
  EXPECT_NEAR(inertia(0, 0), 1.1e-5 + apart, 1e-12);
  EXPECT_NEAR(inertia(1, 1), 2.1e-5 + apart, 1e-12);
  EXPECT_NEAR(inertia(2, 2), 1.6e-5, 1e-12);
  EXPECT_TRUE(left.collides);
  EXPECT_NEAR(((left.X_WB * left.X_BS).translation() - Eigen::Vector3d(0, 0.04, 1.13)).norm(), 0,
              1e-12);
  EXPECT_EQ(read.scene.joints[1].follows, 0);
  EXPECT_EQ(read.scene.joints[1].ratio, -1);
  EXPECT_EQ(read.remarks.size(), 2u) << "limits of both";

  EngineScene scene = read.scene;
  scene.gravity.setZero();
  MultibodyEngine engine;
  engine.load(scene);
  engine.set_joint_force(0, 0.16);
  for (int i = 0; i < 100; ++i) engine.step();
  EXPECT_NEAR(engine.joint_position(0), 0.005, 1e-4);
  EXPECT_NEAR(engine.body(1).X_WB.translation().y(), -engine.body(2).X_WB.translation().y(), 1e-12);
}

TEST(Urdf, SaysWhatItCannotDo) {
  const auto refused = [](const std::string& text, const std::string& name) {
    try {
      parse_urdf(text, "the file");
      FAIL() << name << " was accepted";
    } catch (const geometry::InputError& error) {
      const std::string what = error.what();
      EXPECT_NE(what.find(name), std::string::npos) << what;
      EXPECT_NE(what.find("the file"), std::string::npos) << what;
    }
  };
  const std::string ends = link("a") + link("b", kInertial);
  const std::string box = "<collision><geometry><box size='1 1 1'/></geometry></collision>";
  refused("", "the file");
  refused("<robot", "the file");
  refused(robot(""), "the file");
  refused(robot(ends + joint("j", "floating", "a", "b", "")), "joint 'j'");
  refused(robot(link("a") + link("b") + joint("j", "continuous", "a", "b", "")), "link 'b'");
  refused(robot(link("a", "<collision><geometry><mesh filename='x.stl'/></geometry></collision>")),
          "mesh");
  refused(robot(link("a", box + box)), "several");
  refused(robot(ends + joint("j", "continuous", "a", "b", "<mimic joint='other'/>")), "'other'");
  refused(robot(link("a") +
                link("b",
                     "<inertial><mass value='1'/><inertia ixx='0' ixy='0' ixz='0' "
                     "iyy='0' iyz='0' izz='0'/></inertial>") +
                joint("j", "continuous", "a", "b", "")),
          "link 'b'");
  EXPECT_THROW(load_urdf("/nowhere/robot.urdf"), geometry::InputError);
}

TEST(Urdf, AnArmFallsAndKeepsItsEnergy) {
  const char* data = std::getenv("PREHEND_SHARED_DATA");
  const std::filesystem::path file =
      std::filesystem::path(data ? data : "") / "robots/kuka_iiwa/model.urdf";
  if (!data || !std::filesystem::exists(file)) {
    GTEST_SKIP() << "PREHEND_SHARED_DATA names no folder with robots/kuka_iiwa/model.urdf, a robot "
                    "that is not part of this project; chains of our own are in multibody_test.cpp";
  }
  EXPECT_THROW(load_urdf(file), geometry::InputError) << "its geometry is meshes";
  UrdfOptions options;
  options.meshes_pass_through = true;
  const UrdfScene read = load_urdf(file, options);
  ASSERT_EQ(read.scene.joints.size(), 7u);
  EngineScene scene = read.scene;
  scene.solver = "second_order";
  MultibodyEngine engine;
  engine.load(scene);
  // Upright it stands in balance, nearly; a push on the fourth joint starts it.
  engine.set_joint_force(3, 5);
  for (int i = 0; i < 100; ++i) engine.step();
  engine.set_joint_force(3, 0);
  const double energy = engine.energy();
  double lowest = energy, highest = energy, fastest = 0;
  for (int i = 0; i < 600; ++i) {
    engine.step();
    lowest = std::min(lowest, engine.energy());
    highest = std::max(highest, engine.energy());
    fastest = std::max(fastest, engine.body(7).velocity.norm());
  }
  EXPECT_GT(fastest, 1) << "it falls";
  EXPECT_LT(highest - lowest, 0.05) << "of " << energy << " J";
}

}  // namespace
}  // namespace prehend::simulation::engines

#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "prehend/simulation/explain.h"
#include "prehend/simulation/robot_sensors.h"
#include "prehend/simulation/robot_world.h"

namespace prehend::simulation {

struct RobotWorld::Implementation {
  static constexpr double kStillTime = 0.25;  // s
  struct Thing {                              // an object
    BodyModel model;
    geometry::RigidTransform X_CB = geometry::RigidTransform::Identity();
    Eigen::Vector3d moments = Eigen::Vector3d::Ones();  // kg m^2
    double friction = 0;
    int body = -1;               // of the system; -1: not in it yet
    engines::BodyMotion motion;  // when the system was last built
    double still_time = 0;       // s
    bool asleep = false;
  };
  struct Path {  // of the carrier of a hand alone
    geometry::RigidTransform from, to;
    double time = 0, duration = 1;  // s
  };

  Implementation(const robot::RobotModel& model, const robot::HandModel& hand,
                 const std::string& prefix, const geometry::RigidTransform& X_WR,
                 std::optional<ArmDrive> arm, const RobotWorldOptions& options);

  void build();
  void add(BodyModel model, double friction, const geometry::RigidTransform& X_WB);
  void read_motions();
  void set_arm_positions();
  void move_carried();
  void prescribe_carried();
  void put_to_sleep();
  void step();
  ContactWrench contact_wrench() const;
  std::vector<double> pad_forces(std::size_t pad) const;  // N, of its texels
  double pad_normal_force(int body) const;                // N, of all pads on the body
  void read_sensors();
  Thing& thing(const std::string& name);
  RobotBodyReading reading(const Thing& thing) const;
  geometry::RigidTransform X_WL(int link) const {
    const std::size_t l = static_cast<std::size_t>(link);
    return state.X_WB[static_cast<std::size_t>(robot.body_of_link[l])] * robot.X_BL[l];
  }
  bool is_hands(int body) const;
  void explain_arm(Explanation& out) const;
  void explain_hand(Explanation& out) const;
  void explain_sensors(Explanation& out) const;
  void explain_objects(Explanation& out) const;

  RobotWorldOptions options;
  robot::HandModel hand_model;
  std::string prefix;  // of the hand's names
  std::optional<ArmDrive> arm;
  std::vector<int> arm_joints;  // of the model
  geometry::RigidTransform X_WR;
  Eigen::VectorXd all;  // of the model's joints; the hand's are 0
  RobotBodies robot;
  std::vector<std::string> motor_names;
  std::optional<HandDrive> hand;
  std::vector<Thing> things;
  std::unique_ptr<RobotTouch> touch;
  std::unique_ptr<engines::Multibody> system;
  engines::MultibodyState state, next;
  RobotSensors sensors;
  ContactWrench wrist;  // as its sensor shows it
  std::optional<Path> path;
  double contact_limit = 0;  // N, 0: none
  double contact_time = 0;   // s, that it has been exceeded
  bool contact = false;
  bool shows_robot = true;
  std::uint64_t generation = 0;
  std::vector<geometry::RigidTransform> link_poses;
};

}  // namespace prehend::simulation

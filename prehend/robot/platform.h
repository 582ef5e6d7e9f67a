#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "prehend/robot/hand_model.h"
#include "prehend/robot/kinematic_chain.h"

namespace prehend::robot {

/// By which topics and actions a hand is moved.
enum class HandPort {
  kJoints,   // /hand/move, by its joints
  kGripper,  // /gripper/*, by the opening and the motor's current, as drivers of grippers offer
};

/// An arm, or a stage of linear axes, that carries a hand, as one robot.
struct Platform {
  struct Home {
    std::string name;
    Positions arm;  // of arm_chain()'s joints
  };

  std::string name;
  HandModel hand;
  /// Arm and hand joined: links and joints of the arm are called arm_..., those of the hand
  /// hand_.... The first link is the arm's root.
  RobotModel model;
  std::string base;    // link of the arm's base B in `model`
  std::string flange;  // link of the flange F in `model`
  geometry::RigidTransform X_FH = geometry::RigidTransform::Identity();  // hand on the flange
  geometry::RigidTransform X_WB = geometry::RigidTransform::Identity();  // base in the world
  /// Optical frame of the (left) camera that the arm carries, on the flange; none: it carries none.
  std::optional<geometry::RigidTransform> X_FC;
  std::vector<Home> homes;  // as in the file; one is called home
  Positions acceleration;   // rad/s^2 or m/s^2, of arm_chain()'s joints in planned motions
  HandPort hand_port = HandPort::kJoints;

  /// From the base to the flange.
  KinematicChain arm_chain() const { return {model, base, flange}; }
  /// Frame G of a preshape's tool in the flange's.
  geometry::RigidTransform X_FG(const Preshape& preshape) const {
    return X_FH * hand.X_HP * preshape.X_PG;
  }
  /// Where the flange must be in the base's frame for the tool to be at X_WG.
  geometry::RigidTransform X_BF(const geometry::RigidTransform& X_WG,
                                const Preshape& preshape) const {
    return X_WB.inverse() * X_WG * X_FG(preshape).inverse();
  }
  /// Where the camera is that the arm carries, with the arm's joints at `arm` [rad or m].
  /// @pre X_FC
  geometry::RigidTransform X_WC(const Eigen::Ref<const Eigen::VectorXd>& arm) const {
    return X_WB * arm_chain().forward(arm) * *X_FC;
  }
  /// The direction in the world of a preshape's approach (z of its tool) where no joint of the arm
  /// can tilt it, exact where it is along an axis; none for an arm that can.
  std::optional<Eigen::Vector3d> fixed_approach(const Preshape& preshape) const;
  /// Takes this gripper, which a robot says it has, for the hand's: its pads, drive and opening;
  /// the links stay what the URDF has. @pre hand.gripper
  void set_gripper(const GripperModel& gripper);
  /// The joined robot with the hand's joints fixed at positions `all` (see HandModel): what a
  /// motion planner moves about. @throws std::invalid_argument when `all` has another size.
  RobotModel with_hand_at(const Eigen::Ref<const Eigen::VectorXd>& all) const;
  /// @throws geometry::InputError naming the nearest one there is.
  const Home& home(const std::string& home_name) const;
};

/// Reads a platform's YAML (config/robots/kr5_sdh_camera.yaml shows every key), the arm's URDF and
/// the hand's YAML it names beside it. @throws geometry::InputError "file:line: what is wrong" with
/// the nearest name and the mend.
Platform read_platform(const std::filesystem::path& path);

}  // namespace prehend::robot

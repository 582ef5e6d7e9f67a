#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/contact/pad_layout.h"
#include "prehend/robot/gripper_model.h"
#include "prehend/robot/robot_model.h"

namespace prehend::robot {

/// A chain of links from the palm to a fingertip.
struct Finger {
  std::string name;
  std::vector<int> links;  // of the model, from the palm to the tip
};

/// A tactile pad on a link. Its cells (texels) are a grid on a flat face, a grid laid on the link's
/// surface, or the vertices of a region of a mesh. Frame P of a grid: origin in its middle, for a
/// flat one on its undeformed face; z out of the face, y along the finger towards the tip (row 0 is
/// at +y), x across the finger. P of a region is the link's frame.
struct HandPad {
  std::string name;
  int link = -1;                                                         // of the model
  geometry::RigidTransform X_LP = geometry::RigidTransform::Identity();  // in the link's frame
  /// Foam, law and counts of a cell, and how many rows and columns its frames have: those of a
  /// region are one row, and have no pitch (0).
  TactilePadModel model;
  std::shared_ptr<const contact::PadLayout> layout;  // where the cells are, in P; never null

  /// A pad's extent along P's y [m].
  double length() const;
  /// Whether a surface whose outward normal is opposite to `normal_P` (unit) presses on a cell at
  /// p_P [m], within the grid's outline or a cell's size.
  bool covers(const Eigen::Vector3d& p_P, const Eigen::Vector3d& normal_P) const;
};

/// The flat grid of `model`.
HandPad flat_pad(std::string name, int link, const geometry::RigidTransform& X_LP,
                 const TactilePadModel& model);

/// A joint that follows another one until contact holds that one with more than `torque`: then the
/// motor turns this joint alone, `rate` times as fast as it turned the other.
struct Breakaway {
  int joint = -1;     // follows; its mimic names the leader and the ratio before breaking away
  int leader = -1;    // is held
  double torque = 0;  // N m at the leader, > 0
  double rate = 1;    // > 0
};

/// What moves an actuated joint, as the file says; who simulates it knows what may be said.
struct JointMotor {
  std::string actuator = "dc_motor";     // by name, see prehend/simulation/actuator_registry.h
  std::map<std::string, double> values;  // of its parameters, SI units
  std::string place;                     // "sdh2.yaml:12: hand.motor.pivot", for errors
};

/// How the open hand stands and how it closes.
struct Preshape {
  /// How one actuated joint moves while the hand closes.
  struct Closing {
    double rate = 0;  // of all joints' to one another, signed; 0: stays
    int with = -1;    // actuated joint with which it stops; -1: stops by itself
  };
  std::string name;
  Eigen::VectorXd open;          // rad or m, of the actuated joints
  std::vector<Closing> closing;  // of the actuated joints
  /// Frame G of the tool in the palm's: origin where the fingers close on a thing of middle size, z
  /// the approach direction, y the closing direction.
  geometry::RigidTransform X_PG = geometry::RigidTransform::Identity();
};

/// A hand: links and joints from a URDF, and what they mean. Positions `all` are of every joint of
/// the model, in its order (0 for fixed ones), as couplings that break away are not told by the
/// motors' positions alone. Poses are in the frame H of the root link.
struct HandModel {
  std::string name;
  RobotModel model;
  int palm = 0;               // link; no joint moves between the root and it
  std::vector<int> actuated;  // joints of the model, one for each motor, in the order of commands
  std::vector<Breakaway> breakaways;
  std::vector<Finger> fingers;
  std::vector<HandPad> pads;
  std::vector<Preshape> preshapes;  // at least one
  /// Of the actuated joints whose motor is known, by their index in `actuated`. The others are
  /// moved by ideal position loops.
  std::map<int, JointMotor> motors;
  double friction = 0.5;  // of the fingers, > 0
  /// A parallel gripper with pads: how these feel and press, for grasps planned by its pads. Its
  /// one motor moves half of the opening. None: a hand with fingers.
  std::optional<GripperModel> gripper;
  geometry::RigidTransform X_HP = geometry::RigidTransform::Identity();  // of the palm
  std::string closing;  // method of closing that the file names; empty: closing_method()'s default

  /// By which name a planner finds how this hand closes (prehend/grasp/closing).
  std::string closing_method() const {
    return !closing.empty() ? closing : gripper ? "pads" : "fingers";
  }
  int size() const { return static_cast<int>(actuated.size()); }
  double mass() const;  // kg, of all links
  std::vector<std::string> actuated_names() const;
  /// @throws geometry::InputError naming the nearest one there is.
  const Preshape& preshape(const std::string& preshape_name) const;
  /// Position in `actuated`. @throws geometry::InputError naming the nearest one there is.
  int actuated_index(const std::string& joint) const;

  /// Positions of all joints at those of the motors, couplings unbroken. @throws
  /// std::invalid_argument when `positions` has not size() entries.
  Eigen::VectorXd all_positions(const Eigen::Ref<const Eigen::VectorXd>& positions) const;
  /// Poses X_HL of all links; `poses` is resized. @pre `all` has an entry for each joint.
  void link_poses(const Eigen::Ref<const Eigen::VectorXd>& all,
                  std::vector<geometry::RigidTransform>& poses) const;
  /// "joint 'thumb_distal' at 95.0 deg is beyond 90.0 deg"; empty within the limits.
  std::string limit_problem(const Eigen::Ref<const Eigen::VectorXd>& all) const;
};

/// A parallel gripper alone, as a hand without shapes whose root is the gripper's frame G: for
/// planning by its pads. One preshape, "open".
HandModel parallel_hand(const GripperModel& gripper);

/// Reads a hand's YAML (config/robots/sdh2.yaml shows every key) and the URDF it names beside it.
/// Every key must be known, every name must be in the URDF, every joint that moves must be actuated
/// or mimic one that is, every preshape must be within the limits.
/// @throws geometry::InputError "file:line: what is wrong" with the nearest name and the mend.
HandModel read_hand_model(const std::filesystem::path& path);

}  // namespace prehend::robot

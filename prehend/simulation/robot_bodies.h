#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "prehend/robot/platform.h"
#include "prehend/simulation/engines/multibody.h"

namespace prehend::simulation {

/// A robot as bodies of a Multibody: links of the arm and the palm are moved along prescribed
/// paths, links of fingers are driven. Links joined by fixed joints are one body.
struct RobotBodies {
  struct Part {  // what can touch
    int body = 0;
    int link = 0;
    engines::EngineShape shape;
    geometry::RigidTransform X_BS = geometry::RigidTransform::Identity();
    /// Of a mesh: closed, in S; `shape` then means nothing.
    std::shared_ptr<const geometry::TriangleMesh> solid;
  };
  struct Pad {    // tactile
    int pad = 0;  // of the hand
    int body = 0;
    geometry::RigidTransform X_BP = geometry::RigidTransform::Identity();
  };
  struct Carried {  // a body on a prescribed path
    int body = 0;
    int link = 0;  // whose frame is the body's
  };
  /// One actuated joint of the hand with its motor: the motor's position is
  /// gear * (position of `joint` + share * position of `along`).
  struct Motor {
    std::string name;
    int model_joint = 0;  // in `model`
    int joint = 0;        // of the engine, that the drive acts on
    int along = -1;
    int coordinate = 0, along_coordinate = -1;  // of the two, in MultibodyState
    double share = 0, gear = 1;
    int inner = -1;   // joint of the engine that contact holds while the motor goes on
    int finger = -1;  // of the hand; -1: it moves several
    double max_velocity = 0, max_effort = 0;  // rad/s, N m; of one that slides m/s, N
    double lower = 0, upper = 0;              // rad or m
    bool slides = false;
    std::optional<robot::JointMotor> model;  // what the hand's file says of it
  };

  robot::RobotModel model;
  std::vector<engines::EngineBody> bodies;
  std::vector<engines::EngineJoint> joints;
  std::vector<int> engine_joint;  // of each joint of the model, -1: not the hand's, or fixed
  std::vector<int> coordinate;    // of each joint of the engine, in MultibodyState
  std::vector<engines::JointMechanics> mechanics;  // of the engine's joints
  std::vector<engines::JointCoupling> couplings;
  /// Boxes and meshes with a flat pad on a face begin behind its foam, `thickness` below the pad's
  /// face. Below other pads they stay whole, and who meets them minds the foam (RobotTouch).
  std::vector<Part> parts;
  std::vector<Pad> pads;
  std::vector<Carried> carried;
  std::vector<int> body_of_link;
  std::vector<geometry::RigidTransform> X_BL;  // link in its body
  std::vector<Motor> motors;
  std::vector<int> finger_of_body;  // of the hand; -1: none
  std::vector<int> rank_of_body;    // in its finger, from 0 at the palm
  int hand_root = 0;                // link of `model` that is the hand's root

  /// Poses of all links, the first at X_WR, joints of the model at `all` [rad or m].
  void link_poses(const geometry::RigidTransform& X_WR, const Eigen::VectorXd& all,
                  std::vector<geometry::RigidTransform>& X_WL) const;
};

struct HandMechanics {
  double rotor_inertia = 5e-4;  // kg m^2 at the joint, of motor and gear; estimate
  double damping = 0.02;        // N m s/rad; estimate
  double sliding_mass = 4;      // kg, of motor and gear at a joint that slides; a PG70's, estimate
  double sliding_damping = 20;  // N s/m; estimate
  double friction = 0;          // of the links, 0: as the hand's file says
};

/// `prefix` stands before the hand's names in `model` ("hand_" on a platform, none alone). The root
/// stands at X_WR, the arm's joints at `all`.
/// @throws geometry::InputError for a joint that mimics with an offset, or one that moves without a
/// velocity or effort limit, naming it.
RobotBodies make_robot_bodies(const robot::RobotModel& model, const robot::HandModel& hand,
                              const std::string& prefix, const geometry::RigidTransform& X_WR,
                              const Eigen::VectorXd& all, const HandMechanics& mechanics = {});

}  // namespace prehend::simulation

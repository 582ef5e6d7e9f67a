#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/triangle_mesh.h"
#include "prehend/simulation/robot_world.h"

namespace prehend::simulation {

/// A grasp by a hand with fingers, as a planner gives it.
struct HandGrasp {
  geometry::RigidTransform X_WG = geometry::RigidTransform::Identity();  // tool of the preshape
  std::string preshape;    // of the hand; empty: its first
  Eigen::VectorXd open;    // rad, of the motors; empty: the preshape's
  Eigen::VectorXd closed;  // rad, of the motors, where fingers were predicted to touch
  Eigen::Vector3d approach_direction{0, 0, -1};  // unit, world
  double pregrasp_distance = 0.10;               // m, >= 0
  std::vector<Eigen::Vector3d> contacts;         // m, world, as predicted; may be empty
};

struct HandGraspOptions {
  RobotWorldOptions world;
  double mass = 0.3;            // kg, > 0
  double friction = 0.7;        // of the object, >= 0; with the hand's the smaller counts
  double approach_speed = 0.1;  // m/s, > 0
  double closing_speed = 0.3;   // share of the joints' greatest, in (0, 1]
  /// Fingers first go to where they are predicted to be this much [rad] before they touch, >= 0,
  /// and close from there together: one that touches long before the others would push the object.
  double gather = 0.1;
  /// How far a motor goes on beyond `closed` where nothing is met [rad], >= 0, in its closing
  /// sense: a predicted object may be too large.
  double overrun = 0.5;
  double effort = 0.6;        // share of the joints' greatest that fingers press with, in (0, 1]
  double lift_height = 0.15;  // m, > 0
  double lift_time = 1.0;     // s, > 0
  double hold_time = 1.0;     // s, > 0, after the lift
};

struct HandGraspOutcome {
  bool held = false;
  std::string reason;  // in words: held, or what went wrong
  /// Of the object in the hand, from the end of closing to the end.
  double slip = 0;   // m
  double tilt = 0;   // rad
  double creep = 0;  // m, of the last half of hold_time: what goes on slipping
  double shift = 0;  // m, of the object's centre from its place by approach and closing
  /// Mean distance of the predicted contacts to the nearest true one, in the object's frame [m];
  /// NaN without either.
  double contact_error = 0;
  int fingers = 0;             // that touch the object after closing
  bool touched_early = false;  // while approaching
  double time = 0;             // s, simulated
};

/// Executes a grasp on the true object in physics, without an arm: the hand comes along the
/// approach as a kinematic carrier, open, gathers its fingers round it, closes until they press,
/// lifts, and holds.
/// @param mesh_W the true object as it stands on the table z = 0; @param obstacles meshes that do
/// not move. Deterministic. Cost: a tenth to a half of the simulated 5 s.
/// @throws geometry::InputError for a mesh that is not a solid or an unknown preshape,
/// std::invalid_argument for values out of range.
HandGraspOutcome execute_hand_grasp(const robot::HandModel& hand, const HandGrasp& grasp,
                                    const geometry::TriangleMesh& mesh_W,
                                    const HandGraspOptions& options = {},
                                    const std::vector<geometry::TriangleMesh>& obstacles = {});

}  // namespace prehend::simulation

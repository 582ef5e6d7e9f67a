#pragma once

#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "eval/grasp/grasp_case.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/grasp/planner.h"
#include "prehend/surface/object_model.h"

namespace prehend::eval {

/// A way to plan.
struct PlannerSetting {
  std::string name;
  PlannedOn planned_on = PlannedOn::kPredicted;
  /// What it changes of the hand's default options; empty: nothing.
  std::function<void(grasp::PlannerOptions* options)> change;
  int alternatives = 0;  // shapes besides the predicted one on which grasps are tried
};

/// The hand's default options with what the setting changes, on one thread: processes share the
/// cores, and times are of one.
grasp::PlannerOptions options_for(const robot::HandModel& hand, const PlannerSetting& setting);

/// An object as a hand meets it: in the world, on the table z = 0.
struct TrueObject {
  geometry::TriangleMesh mesh_W;
  double mass = 0;  // kg
  /// What it stands on, leans on, is hidden by. They do not move.
  std::vector<geometry::TriangleMesh> others_W;
};

/// What grasps are planned on.
struct Belief {
  surface::ObjectModel object;
  grasp::Obstacles obstacles;
};

/// What is believed of the object after a new look at it: what was at p_W is at X_moved * p_W now.
/// @throws geometry::InputError or std::exception in words when nothing is made of the view.
using BelieveAgain = std::function<Belief(const geometry::RigidTransform& X_moved)>;

/// A hand under test: plans on what is believed by `setting`, executes on what is there, and may
/// look again after a failed attempt.
struct HandUnderTest {
  std::string name;
  std::function<GraspTrial(const Belief& believed, const TrueObject& truth,
                           const PlannerSetting& setting, const BelieveAgain& believe_again)>
      grasp;
};

/// Mean distance of the points to the surface [m]. @pre there is a point.
double mean_distance(const std::vector<Eigen::Vector3d>& points_W,
                     const geometry::MeshQuery& surface_W);

}  // namespace prehend::eval

#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "eval/grasp/grasp_case.h"
#include "prehend/belief/attempt.h"
#include "prehend/fidelity/front.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/planning/platform_plan.h"
#include "prehend/shape/completed_shape.h"
#include "prehend/surface/object_model.h"

// What a trial of a platform starts from.
namespace prehend::eval {

/// What is changed of the platform's default options; empty: nothing.
using PlanChange = std::function<void(planning::PlatformPlanOptions* options)>;

/// What the setting of a front of chains chooses of it.
PlanChange change_by(const fidelity::Front& chains, const fidelity::Setting& setting);

/// A way to plan.
struct PlannerSetting {
  std::string name;
  PlannedOn planned_on = PlannedOn::kPredicted;
  PlanChange change;
  int alternatives = 0;     // shapes besides the predicted one on which grasps are tried
  bool is_executed = true;  // else it is only planned
};

/// An object as a hand meets it: in the world, on the table z = 0.
struct TrueObject {
  geometry::TriangleMesh mesh_W;
  double mass = 0;  // kg
  /// What it stands on, leans on, is hidden by. They do not move.
  std::vector<geometry::TriangleMesh> others_W;
  double friction = 0.7;  // dynamic, as simulation::SceneObject's
};

/// What grasps are planned on.
struct Belief {
  surface::ObjectModel object;
  planning::Neighbours others;
  std::optional<shape::CompletedShape> shape;  // of a predicted object, with other methods
  geometry::Plane support_W;                   // of that
};

/// Of bare meshes, as the truth and the Delaunay surface are: with their convex pieces, of one that
/// encloses nothing its hull.
Belief belief_of(const geometry::TriangleMesh& mesh_W,
                 const std::vector<geometry::TriangleMesh>& others_W);

/// What is believed of the object after an attempt and a new look at it: what was at p_W is at
/// X_moved * p_W now. @throws geometry::InputError or std::exception in words when nothing is made
/// of the view.
using BelieveAgain =
    std::function<Belief(const geometry::RigidTransform& X_moved, const belief::Attempt& attempt)>;

}  // namespace prehend::eval

#pragma once

#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/plane.h"
#include "prehend/grasp/closing.h"
#include "prehend/grasp/collision.h"
#include "prehend/grasp/generator.h"
#include "prehend/grasp/ledger.h"
#include "prehend/grasp/uncertainty.h"
#include "prehend/robot/gripper_model.h"
#include "prehend/surface/object_model.h"

namespace prehend::grasp {

struct ScoreWeights {
  double quality = 0.35;      // quality / (quality + 0.05)
  double centredness = 0.35;  // exp(-d / 20 mm), d from the centre of mass to the pads' line
  double area = 0.2;          // mean patch area / pad area
  double clearance = 0.1;     // min(1, fingertips' height over the table / 20 mm)
  /// The mean of the above is multiplied by 1 - guessed + guessed (share of the contact's force
  /// that is on surface that is there), by vertex_confidence, ...
  double guessed = 0.5;  // 0..1
  /// ... and by 1 - robust + robust Grasp.robustness.
  double robust = 0.9;  // 0..1
};

struct PlannerOptions {
  std::vector<std::string> generators{"circles", "boxes"};  // of generator_names(), at least one
  /// To try when nothing of those can be grasped: walls, rims and handles of what is too wide.
  std::vector<std::string> further_generators{"antipodal"};
  GeneratorOptions candidates;
  /// Poses to try instead of what the generators make, if there are any; "given" is their
  /// generator's name then.
  std::vector<Candidate> given_W;
  ClosingOptions closing;
  int cone_edges = 8;  // >= 3, of the linearised friction cones
  CollisionOptions collision;
  ScoreWeights weights;
  UncertaintyOptions uncertainty;
  double density = 800;              // kg/m^3, > 0, assumed of the unknown object
  double friction = 0.6;             // > 0, assumed; below the pads' mu_d to stay on the safe side
  double safety_factor = 2.5;        // >= 1, of the grasp force against slipping
  double lift_acceleration = 1.0;    // m/s^2, >= 0, upwards on top of gravity
  double least_force = 8;            // N, > 0, per pad: less is not controllable
  double largest_force = 0;          // N, per pad; 0: what the gripper's nominal current gives
  double pregrasp_distance = 0.08;   // m, > 0, back along the approach
  double opening_clearance = 0.005;  // m, >= 0, of each pad when a narrower opening must do
  /// m, >= 0: sections that are too wide by up to this much are listed too, with a remark: the
  /// prediction may be wider than the object. They come last: nothing of them is robust.
  double width_tolerance = 0.006;
  double largest_offset = 0.004;  // m, >= 0, of the grasped section from the hand's middle
  int largest_count = 32;         // > 0, of grasps in the result
  /// s of wall time, >= 0: candidates, spread over all of them, are tried until it is used up; 0:
  /// all are. With a budget the result depends on how fast the machine is.
  double budget = 0;
  int threads = 0;  // >= 0; 0: all cores. The result does not depend on it
  /// Whether the arm reaches a pose of the gripper; asked for the grasp and for the pregrasp, and
  /// for both turned by half about the approach, by several threads at once. Empty: it reaches all.
  /// Must give the same answer for the same pose.
  std::function<bool(const geometry::RigidTransform& X_WG)> reaches;

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// What the grasp should feel like if the prediction of the shape is right.
struct PredictedPercepts {
  double opening = 0;       // m, between the pads at the first touch of both
  double contact_area = 0;  // m^2, mean of both pads, at the grasp force
  double tactile_sum = 0;   // N, mean of both pads, at the grasp force
  double lifted_mass = 0;   // kg
};

struct Grasp {
  geometry::RigidTransform X_WG = geometry::RigidTransform::Identity();  // when it closes
  Eigen::Vector3d approach_W = -Eigen::Vector3d::UnitZ();                // unit
  double standoff = 0;           // m, from the fingertips to the centroid along the approach
  double roll = 0;               // rad, about the approach
  double pregrasp_opening = 0;   // m
  double pregrasp_distance = 0;  // m, back along the approach
  double grasp_force = 0;        // N, per pad
  double quality = 0;            // epsilon, see wrench_hull.h; torques over the object's radius
  double score = 0;              // what the list is ranked by, 0 to 1
  PredictedPercepts predicted;
  std::vector<Eigen::Vector3d> left_contacts_W;  // pressed texels [m]
  std::vector<Eigen::Vector3d> right_contacts_W;
  std::string generator;  // whose candidate it was
  double robustness =
      -1;  // share of UncertaintyOptions.samples in which it holds; -1: not assessed
  double guessed_contact = 0;  // share of the contact's force on surface that nobody saw
  std::string remark;          // what to know of it, in words; often empty
};

struct GraspPlanResult {
  std::vector<Grasp> grasps;          // best first
  std::vector<Rejection> rejections;  // where the other candidates fell, by reason and generator
  int candidates = 0;   // = grasps + all rejections (those ranked below the last are one reason)
  std::string problem;  // "cannot be grasped: ..." when there is no grasp, else empty
};

/// Plans grasps of one object with a parallel gripper: makes candidates, centres the hand on the
/// section between the pads, closes it on the predicted mesh, and keeps what reaches, does not
/// collide, holds the object by soft-finger force closure and carries its weight. The best are
/// closed again in disturbed poses, with other friction, and on `object.alternatives_W`: other
/// shapes that the object may have as well.
///
/// The grasp force follows from the mass m = volume * density (the hull's volume when the mesh is
/// not watertight): F = safety_factor * m (g + a) / (2 friction), raised where the centre of mass
/// is beside the pads' line so that the torque of the weight stays inside the elliptic limit
/// surface too, within [least_force, largest_force]. The score is the weighted mean named in
/// ScoreWeights. Same input, same result, bit by bit, unless there is a budget.
/// @throws geometry::InputError for a mesh without triangles or with NaN or bad indices;
///         std::invalid_argument for options out of range.
GraspPlanResult plan_grasps(const surface::ObjectModel& object, const geometry::Plane& table,
                            const Obstacles& obstacles, const robot::GripperModel& gripper,
                            const Reachability& reachability, const PlannerOptions& options = {});

}  // namespace prehend::grasp

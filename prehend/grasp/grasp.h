#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/rigid_transform.h"
#include "prehend/grasp/ledger.h"
#include "prehend/grasp/plan_outcome.h"
#include "prehend/grasp/wrench/force_closure.h"

namespace prehend::grasp {

/// What the grasp should feel like if the prediction of the shape is right.
struct PredictedPercepts {
  double opening = 0;       // m, between the pads of a parallel gripper at the first touch of both
  double contact_area = 0;  // m^2, mean of the pads that touch, when it is gripped; 0: not known
  double tactile_sum = 0;   // N, the same
  double lifted_mass = 0;   // kg
};

/// Where a hand touches the object.
struct GraspContact {
  /// Of fingers the mean of a patch, its normal into the object, with the hand's friction and the
  /// patch's radius; of pads a pressed texel.
  Contact contact_W;
  int link = -1;     // of the hand's model
  int finger = -1;   // of the hand's; -1: the palm, or a link of no finger
  int pad = -1;      // of the hand's, when it is on its face; -1: beside the pads
  double force = 0;  // N, of a texel at the grasp force; 0: not known
};

/// A grasp of any hand. The hand's motors are those of HandModel::actuated, in their order.
struct Grasp {
  geometry::RigidTransform X_WG = geometry::RigidTransform::Identity();  // tool when it closes
  geometry::RigidTransform X_WH = geometry::RigidTransform::Identity();  // root when it closes
  Eigen::Vector3d approach_W = -Eigen::Vector3d::UnitZ();                // unit
  double standoff = 0;           // m, from the fingertips to the centroid along the approach
  double roll = 0;               // rad, about the approach
  double pregrasp_distance = 0;  // m, back along the approach
  std::string preshape;          // of the hand, by its name
  Eigen::VectorXd open;          // rad or m, of the motors before it closes
  Eigen::VectorXd closed;        // rad or m, of the motors where it touches
  Eigen::VectorXd closed_all;    // the same of all joints of the hand's model
  double force = 0;              // N, per pad, that it is held with; 0: the motors' limits set it
  Eigen::VectorXd torques;       // N m or N, of the motors, that hold the load with the safety
                                 // factor; empty: not known
  double effort = 0;             // share of what the hand can, with the safety factor
  double quality = 0;            // epsilon, see wrench_hull.h; torques over the object's radius
  double volume = 0;             // of the wrench space, see wrench_volume(); 0 unless asked for
  double margin = 0;             // N, see disturbance_margin(); torques over the object's radius
  double score = 0;              // what the list is ranked by, 0 to 1
  double robustness =
      -1;  // share of UncertaintyOptions.samples in which it holds; -1: not assessed
  /// The same on each shape that the object may have, the predicted one first; robustness is their
  /// mean by the shapes' weights. NaN: it had no sample. Empty: not assessed.
  std::vector<double> held_on_shapes;
  /// rad or m, where the motors stop when it is executed on each of these shapes; a shape's are
  /// empty where the hand meets nothing. Empty: not asked for, or the hand's closing cannot tell.
  std::vector<Eigen::VectorXd> stops_on_shapes;
  double guessed_contact = 0;  // share of the contact's force on surface that nobody saw
  PredictedPercepts predicted;
  std::vector<GraspContact> contacts;
  std::string generator;  // whose candidate it was
  std::string remark;     // what to know of it, in words; often empty
};

struct GraspPlan : PlanAnswer {
  std::vector<Grasp> grasps;  // best first; after all others what is too wide by the prediction
  std::vector<Rejection> rejections;  // where the other candidates fell, by reason and generator
  int candidates = 0;  // = grasps + all rejections (those ranked below the last are one reason)
};

/// m, between the pads of a parallel gripper before it closes: its motor moves half of it.
inline double pregrasp_opening(const Grasp& grasp) { return 2 * grasp.open[0]; }
/// m, world.
std::vector<Eigen::Vector3d> contact_points(const Grasp& grasp);

}  // namespace prehend::grasp

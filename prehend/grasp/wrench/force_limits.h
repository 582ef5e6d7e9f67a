#pragma once

#include <vector>

#include <Eigen/Core>

#include "prehend/grasp/closing/close_fingers.h"
#include "prehend/grasp/wrench/wrench_hull.h"

namespace prehend::grasp {

/// What a hand can do at its contacts: the primitive forces it can add up, and what each costs its
/// motors. Wrenches are force over torque about `center` divided by `length`, as of
/// primitive_wrenches(): the sums of columns with weights >= 0 [N] are what the contacts can exert
/// on the object.
struct HandForces {
  Wrenches wrenches;        // 6 x n, of unit normal force
  Eigen::MatrixXd torques;  // motors x n, N m (N of a prismatic joint) for each
  Eigen::VectorXd limits;   // of the motors, > 0, N m or N
};

/// Forces of a closed hand. A motor carries what its joints carry, coupled ones by their ratio (the
/// principle of virtual work); where an outer joint has broken away it is alone on its motor, and
/// the inner one is held by its gear. @pre `closed` is close_fingers()'s answer for the hand at
/// X_WH.
HandForces hand_forces(const robot::HandModel& hand, const geometry::RigidTransform& X_WH,
                       const ClosedFingers& closed, const Eigen::Vector3d& center_W, double length,
                       int cone_edges);

/// How a hand holds a load.
struct Holding {
  bool possible = false;  // with motors of any strength
  /// Of the limit of the motor that needs most; infinite when not possible. At most 1: it can.
  double share = 0;
  Eigen::VectorXd torques;  // of the motors, N m or N; empty when not possible
};

/// The least share of their limits with which the motors hold the object against the wrench `load`
/// (force [N] over torque about the centre divided by the length): a linear programme,
///   min z   subject to   W x = -load,  -z limits <= T x <= z limits,  x >= 0.
/// @throws std::invalid_argument for a limit that is not positive, or sizes that do not fit.
Holding hold(const HandForces& forces, const Vector6& load);

/// The largest r [N, and N times the length] such that the motors, within their limits, hold `load`
/// and besides any one of the twelve wrenches +-r e_k: twelve linear programmes
///   max r   subject to   W x + r d = -load,  |T x| <= limits,  x >= 0.
/// Any disturbance of norm up to r / sqrt(6) is then resisted too, as what can be resisted is
/// convex. 0 when the load alone cannot be held; at most 10 kN. @throws as hold().
double disturbance_margin(const HandForces& forces, const Vector6& load);

}  // namespace prehend::grasp

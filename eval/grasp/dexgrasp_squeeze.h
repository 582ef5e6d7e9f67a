#pragma once

#include <Eigen/Core>

#include "eval/grasp/dexgrasp_hand.h"
#include "prehend/grasp/grasp.h"

namespace prehend::eval {

/// Efforts [N m, N of what slides] of all joints of the hand's model that squeeze the object
/// without moving it: the mean of those that hold it with the least share of the motors' limits
/// against a force of `load` [N] along each axis to and fro, whose loads cancel each other, so
/// `safety` times that leaves each contact its part. No joint beyond its limit. As BODex squeezes
/// with the forces of its quadratic programme. Empty where the contacts cannot bear a pair of
/// loads.
/// @param center_W m, of mass; @param radius m, of the object.
Eigen::VectorXd balanced_squeeze(const DexHand& hand, const grasp::Grasp& grasp,
                                 const Eigen::Vector3d& center_W, double radius, double load,
                                 double safety);

}  // namespace prehend::eval

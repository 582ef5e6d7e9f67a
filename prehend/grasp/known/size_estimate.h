#pragma once

#include <string>

#include <Eigen/Core>

#include "prehend/grasp/known/registration.h"

namespace prehend::grasp {

/// How large the seen object is beside a model that was laid over it, along the model's principal
/// axes (of its surface, the longest first).
struct SizeEstimate {
  Eigen::Matrix3d axes_O = Eigen::Matrix3d::Identity();  // columns, unit
  Eigen::Vector3d extent = Eigen::Vector3d::Zero();      // m, of the model along each
  /// By how much the seen object is longer than the model along each [m]; 0 for what was seen tells
  /// nothing about.
  Eigen::Vector3d difference = Eigen::Vector3d::Zero();
  Eigen::Vector3d deviation = Eigen::Vector3d::Zero();  // m, standard, of the difference
  double noise = 0;  // m, of the points about the stretched model
};

/// Lays the model over the seen points once more, from X_OS on, with three more degrees of freedom:
/// it may be stretched along each of its principal axes about their middle. Point-to-plane least
/// squares as refined_pose(), so a size that the seen side does not show (the depth of a box seen
/// from its front) stays as it is, with a large deviation. The deviation is the estimate's own
/// standard one, from the points' distances to the stretched model, which are taken to be alike
/// within `correlation` [m]: errors of stereo and structured light are not independent.
/// Costs about as much as refined_pose() with as many points. @pre as refined_pose().
SizeEstimate estimated_size(const OrientedPoints& seen_S, const RegisteredModel& model,
                            const geometry::RigidTransform& X_OS, double tolerance, double spacing,
                            double correlation);

}  // namespace prehend::grasp

#pragma once

#include <vector>

#include <Eigen/Core>

#include "prehend/belief/evidence.h"
#include "prehend/belief/shape_hypothesis.h"

namespace prehend::belief {

/// A point of a hypothesis was found displaced.
struct Observation {
  int point = 0;            // of the hypothesis
  double displacement = 0;  // m, along its normal
  double deviation = 0;     // m, standard, of the measurement, > 0
  int act = 0;              // after which it was found so: after as many Motions
};

/// What observations say of a hypothesis' displacements and of the object's motions.
///
/// With the n observations y of the points p_1 ... p_n, after the acts a_1 ... a_n,
///
///     C = A A^T + K + P + R,   log p(y) = -(y^T C^-1 y + log |C| + n log 2 pi) / 2,
///
/// A the displacement of the observed points along their normals for each theta of the hypothesis,
/// K the covariance of its e, R the measurements' variances, and P what the object's motions along
/// the support, independent of each other, add: an act's motion is in all observations after it
/// (Rasmussen and Williams 2006, equations 2.22 to 2.30).
class Displacement {
 public:
  /// Conditions on the observations. References are kept. O(n^3).
  /// @throws std::invalid_argument for an observation out of range.
  Displacement(const ShapeHypothesis& hypothesis, const geometry::Plane& table_W,
               const std::vector<Motion>& motions, std::vector<Observation> observations);

  double log_likelihood() const { return log_likelihood_; }
  /// Mean of y^T C^-1 y over the number of observations: about 1 where all is as it was thought.
  double misfit() const { return misfit_; }
  /// One per observation: the square of how far it is from what all others make expected, in
  /// standard deviations (Rasmussen and Williams 2006, equations 5.10 to 5.12). O(n^3).
  Eigen::VectorXd left_out_misfits() const;
  const Eigen::VectorXd& theta() const { return theta_; }
  /// Of the object by an act, in W: along the support [m], and about its normal through the middle
  /// of the hypothesis [rad].
  struct Moved {
    Eigen::Vector3d along_W = Eigen::Vector3d::Zero();
    double turn = 0;
  };
  const std::vector<Moved>& moved() const { return moved_; }
  /// Where the object's point that was felt at p_W after so many acts was when it was first seen.
  Eigen::Vector3d before_motions(const Eigen::Vector3d& p_W, int act) const;

  /// Where these points of the hypothesis are now thought to be, with the object where it was
  /// first seen [m]. O(points x observations).
  std::vector<Eigen::Vector3f> places(const std::vector<int>& points) const;
  /// The variance of their displacement along the normal [m^2]. O(points x observations^2).
  Eigen::VectorXd variances(const std::vector<int>& points) const;
  /// Covariances of the displacements of `points` with that of one more point, given what was
  /// observed [m^2].
  Eigen::VectorXd covariances(const std::vector<int>& points, int with) const;

 private:
  /// A, K of (points, observed points), without what observations add.
  Eigen::MatrixXd prior_covariance(const std::vector<int>& points,
                                   const std::vector<int>& others) const;
  Eigen::MatrixXd residual_covariance(const std::vector<int>& points,
                                      const std::vector<int>& others) const;
  Eigen::MatrixXd rows(const std::vector<int>& points) const;  // A

  const ShapeHypothesis& hypothesis_;
  Eigen::Vector3d up_W_, center_W_ = Eigen::Vector3d::Zero();
  std::vector<Observation> observations_;
  std::vector<int> observed_;
  Eigen::LLT<Eigen::MatrixXd> solver_;
  Eigen::VectorXd weights_;  // C^-1 y
  Eigen::VectorXd theta_;
  std::vector<Moved> moved_;
  double log_likelihood_ = 0, misfit_ = 0;
};

}  // namespace prehend::belief

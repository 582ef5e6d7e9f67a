#include "prehend/grasp/wrench/force_limits.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "prehend/grasp/wrench/dense_programme.h"
#include "prehend/robot/drive_ratios.h"

namespace prehend::grasp {
namespace {

using Eigen::Vector3d;

constexpr double kLargestMargin = 1e4;  // N

void check(const HandForces& forces) {
  if (forces.torques.cols() != forces.wrenches.cols() ||
      forces.torques.rows() != forces.limits.size()) {
    throw std::invalid_argument("HandForces: sizes do not fit");
  }
  if (!(forces.limits.array() > 0).all() || !forces.limits.allFinite()) {
    throw std::invalid_argument("HandForces: a motor's limit must be positive and finite");
  }
}

/// Torques over limits, and their negatives.
Eigen::MatrixXd shares(const HandForces& forces) {
  const Eigen::MatrixXd up = forces.limits.cwiseInverse().asDiagonal() * forces.torques;
  Eigen::MatrixXd both(2 * up.rows(), up.cols());
  both << up, -up;
  return both;
}

/// A column of the programmes beside those of the forces.
Eigen::MatrixXd with_column(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& column) {
  Eigen::MatrixXd wider(matrix.rows(), matrix.cols() + 1);
  wider << matrix, column;
  return wider;
}

}  // namespace

HandForces hand_forces(const robot::HandModel& hand, const geometry::RigidTransform& X_WH,
                       const ClosedFingers& closed, const Vector3d& center_W, double length,
                       int cone_edges) {
  std::vector<geometry::RigidTransform> poses;
  hand.link_poses(closed.all, poses);
  auto [motor, ratio] = robot::DriveRatios(hand);
  for (std::size_t b = 0; b < hand.breakaways.size(); ++b) {
    if (closed.broken_away[b] == 0) continue;
    ratio[static_cast<std::size_t>(hand.breakaways[b].leader)] = 0;
    ratio[static_cast<std::size_t>(hand.breakaways[b].joint)] = hand.breakaways[b].rate;
  }
  HandForces result;
  std::vector<Wrenches> blocks;
  std::vector<const GraspContact*> of;
  for (const GraspContact& contact : closed.contacts) {
    blocks.push_back(primitive_wrenches({contact.contact_W}, center_W, length, cone_edges));
    for (Eigen::Index i = 0; i < blocks.back().cols(); ++i) of.push_back(&contact);
  }
  result.wrenches.resize(6, static_cast<Eigen::Index>(of.size()));
  Eigen::Index column = 0;
  for (const Wrenches& block : blocks) {
    result.wrenches.middleCols(column, block.cols()) = block;
    column += block.cols();
  }
  result.limits.resize(hand.size());
  for (int m = 0; m < hand.size(); ++m) {
    result.limits[m] =
        hand.model.joints[static_cast<std::size_t>(hand.actuated[static_cast<std::size_t>(m)])]
            .max_effort;
  }
  result.torques.setZero(hand.size(), result.wrenches.cols());
  for (Eigen::Index i = 0; i < result.wrenches.cols(); ++i) {
    const Vector3d force = result.wrenches.col(i).head<3>();
    const Vector3d torque = length * result.wrenches.col(i).tail<3>();  // about the centre
    for (int link = of[static_cast<std::size_t>(i)]->link;
         const auto above = hand.model.joint_above(link);) {
      const robot::Joint& joint = hand.model.joints[static_cast<std::size_t>(*above)];
      const auto j = static_cast<std::size_t>(*above);
      link = joint.parent;
      if (motor[j] < 0) continue;
      const geometry::RigidTransform X_WJ = X_WH * poses[static_cast<std::size_t>(joint.child)];
      const Vector3d axis = X_WJ.linear() * joint.axis_J;
      const double load = joint.kind == robot::Joint::Kind::kRevolute
                              ? axis.dot(torque + (center_W - X_WJ.translation()).cross(force))
                              : axis.dot(force);
      result.torques(motor[j], i) += ratio[j] * load;
    }
  }
  return result;
}

Holding hold(const HandForces& forces, const Vector6& load) {
  check(forces);
  const Eigen::Index n = forces.wrenches.cols();
  Holding result;
  result.share = std::numeric_limits<double>::infinity();
  if (n == 0) return result;
  DenseProgramme programme;
  programme.objective = -Eigen::VectorXd::Unit(n + 1, n);
  programme.equal = with_column(forces.wrenches, Eigen::VectorXd::Zero(6));
  programme.right = -load;
  const Eigen::MatrixXd both = shares(forces);
  programme.below = with_column(both, -Eigen::VectorXd::Ones(both.rows()));
  programme.most = Eigen::VectorXd::Zero(both.rows());
  const auto x = programme.maximise();
  if (!x) return result;
  result.possible = true;
  result.share = (*x)[n];
  result.torques = forces.torques * x->head(n);
  return result;
}

double disturbance_margin(const HandForces& forces, const Vector6& load) {
  check(forces);
  const Eigen::Index n = forces.wrenches.cols();
  if (n == 0) return 0;
  DenseProgramme programme;
  programme.objective = Eigen::VectorXd::Unit(n + 1, n);
  programme.right = -load;
  const Eigen::MatrixXd both = shares(forces);
  // What no motor holds (the palm does) has no limit: r is bounded for the simplex method's sake.
  const Eigen::Index rows = both.rows();
  programme.below = Eigen::MatrixXd::Zero(rows + 1, n + 1);
  programme.below.topLeftCorner(rows, n) = both;
  programme.below(rows, n) = 1;
  programme.most = Eigen::VectorXd::Ones(rows + 1);
  programme.most[rows] = kLargestMargin;
  double margin = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 12; ++k) {
    programme.equal = with_column(forces.wrenches, (k % 2 == 0 ? 1 : -1) * Vector6::Unit(k / 2));
    const auto x = programme.maximise();
    margin = std::min(margin, x ? (*x)[n] : 0.0);
  }
  return margin;
}

}  // namespace prehend::grasp

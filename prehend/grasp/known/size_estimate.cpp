#include "prehend/grasp/known/size_estimate.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Dense>

namespace prehend::grasp {
namespace {

using geometry::RigidTransform;
using NormalMatrix =
    Eigen::Matrix<double, 9, 9>;  // of the pose's six and the stretches' three unknowns
using Unknowns = Eigen::Matrix<double, 9, 1>;

constexpr double kPrior = 0.3;  // standard deviation of the logarithm of a stretch, without points

/// The model's frame P: origin in the middle of its bounds, axes the principal ones.
struct Principal {
  Eigen::Matrix3d axes_O;  // columns
  Eigen::Vector3d middle_O, extent;
};

Principal principal_frame(const DescribedPoints& samples_O) {
  const double count = static_cast<double>(samples_O.points.size());
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : samples_O.points) mean += p / count;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : samples_O.points) {
    covariance += (p - mean) * (p - mean).transpose() / count;
  }
  Principal frame;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  frame.axes_O << solver.eigenvectors().col(2), solver.eigenvectors().col(1),
      solver.eigenvectors().col(2).cross(solver.eigenvectors().col(1));
  Eigen::AlignedBox3d box_P;
  for (const Eigen::Vector3d& p : samples_O.points) box_P.extend(frame.axes_O.transpose() * p);
  frame.middle_O = frame.axes_O * box_P.center();
  frame.extent = box_P.sizes();
  return frame;
}

/// Normal equations of one step.
struct Equations {
  NormalMatrix A = NormalMatrix::Zero();
  Unknowns b = Unknowns::Zero();
  double squares = 0;  // m^2, of the distances
  int count = 0;
};

/// Seen points and normals in P, held against the model stretched by `stretch`.
Equations equations(const OrientedPoints& seen_S, const geometry::MeshQuery& surface_O,
                    const Principal& frame, const RigidTransform& X_PS,
                    const Eigen::Vector3d& stretch, double bound) {
  constexpr double kLeastCosine = 0.5;  // between seen and true normal, as in refined_pose()
  const auto& mesh = surface_O.mesh();
  Equations result;
  for (std::size_t i = 0; i < seen_S.points.size(); ++i) {
    const Eigen::Vector3d p = X_PS * seen_S.points[i];
    // Nearest on the model as it is, of the point where the stretch would have it.
    const Eigen::Vector3d p_O = frame.middle_O + frame.axes_O * p.cwiseQuotient(stretch);
    const auto nearest = surface_O.nearest(p_O, bound);
    if (!nearest) continue;
    const auto& corners = mesh.triangles[static_cast<std::size_t>(nearest->triangle)];
    const auto corner = [&](int k) { return mesh.vertices[static_cast<std::size_t>(corners[k])]; };
    const Eigen::Vector3d normal_O = (corner(1) - corner(0)).cross(corner(2) - corner(0));
    const Eigen::Vector3d normal =
        (frame.axes_O.transpose() * normal_O).cwiseQuotient(stretch).normalized();
    if (!(normal.dot(X_PS.linear() * seen_S.normals[i]) > kLeastCosine)) continue;
    const Eigen::Vector3d q =
        stretch.cwiseProduct(frame.axes_O.transpose() * (nearest->point - frame.middle_O));
    const double distance = normal.dot(p - q);
    Unknowns row;
    row << p.cross(normal), normal, -normal.cwiseProduct(q);
    result.A += row * row.transpose();
    result.b -= row * distance;
    result.squares += distance * distance;
    ++result.count;
  }
  return result;
}

}  // namespace

SizeEstimate estimated_size(const OrientedPoints& seen_S, const RegisteredModel& model,
                            const RigidTransform& X_OS, double tolerance, double spacing,
                            double correlation) {
  constexpr int kSteps = 20;
  constexpr double kStill = 1e-4;  // of a step that ends it
  const Principal frame = principal_frame(model.samples_O);
  RigidTransform X_PS = RigidTransform::Identity();
  X_PS.linear() = frame.axes_O.transpose() * X_OS.linear();
  X_PS.translation() = frame.axes_O.transpose() * (X_OS.translation() - frame.middle_O);
  Eigen::Vector3d log_stretch = Eigen::Vector3d::Zero();
  const double bound = 2 * tolerance;
  // A prior with the weight of one point at the tolerance keeps what the points do not tell.
  const double prior = std::pow(tolerance / kPrior, 2);
  const auto solvable = [&](Equations e) {
    e.A.topLeftCorner<6, 6>().diagonal().array() +=
        1e-9 + 1e-6 * e.A.topLeftCorner<6, 6>().diagonal().mean();
    e.A.bottomRightCorner<3, 3>().diagonal().array() += prior;
    e.b.tail<3>() -= prior * log_stretch;
    return e;
  };
  for (int step = 0; step < kSteps; ++step) {
    const Equations e = solvable(
        equations(seen_S, model.surface_O, frame, X_PS, log_stretch.array().exp().matrix(), bound));
    const Unknowns x = e.A.ldlt().solve(e.b);
    if (!x.allFinite()) break;
    const Eigen::Vector3d turn = x.head<3>();
    RigidTransform step_P = RigidTransform::Identity();
    if (turn.norm() > 0) {
      step_P.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
    }
    step_P.translation() = x.segment<3>(3);
    X_PS = step_P * X_PS;
    log_stretch = (log_stretch + x.tail<3>()).cwiseMax(-0.7).cwiseMin(0.7);
    if (x.norm() < kStill) break;
  }
  SizeEstimate estimate;
  estimate.axes_O = frame.axes_O;
  estimate.extent = frame.extent;
  const Equations last =
      equations(seen_S, model.surface_O, frame, X_PS, log_stretch.array().exp().matrix(), bound);
  if (last.count < 10) {
    estimate.deviation.setConstant(std::numeric_limits<double>::infinity());
    return estimate;
  }
  estimate.noise = std::sqrt(last.squares / (last.count - 9));
  estimate.difference = frame.extent.cwiseProduct((log_stretch.array().exp() - 1).matrix());
  // So many points, one every `spacing`, have one error between them.
  const double alike = std::max(1.0, std::pow(correlation / spacing, 2));
  const NormalMatrix covariance = solvable(last).A.inverse();
  for (int axis = 0; axis < 3; ++axis) {
    estimate.deviation(axis) = frame.extent(axis) * std::exp(log_stretch(axis)) * estimate.noise *
                               std::sqrt(alike * std::max(0.0, covariance(6 + axis, 6 + axis)));
  }
  return estimate;
}

}  // namespace prehend::grasp

#include "eval/superquadric.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "eval/implicit_mesh.h"
#include "prehend/geometry/errors.h"

namespace prehend::eval {
namespace {

using Eigen::Vector3d;

constexpr int kParameters = 11;
constexpr std::size_t kMostPoints = 1000;
constexpr double kLeastSide = 0.005, kMostSide = 0.6;  // half a side over the points' diagonal

// Of a point in the solid's frame, raised to e1: 1 on the surface, quadratic along a ray.
template <class T>
T inside_outside(const T* p_S, const T* half_sizes, const T& e1, const T& e2) {
  using std::pow;
  // The square's root has no derivative at 0, where the function is flat.
  const auto part = [](const T& x, const T& a, const T& exponent) {
    return pow(x * x / (a * a) + T(1e-12), T(1) / exponent);
  };
  const T across = part(p_S[0], half_sizes[0], e2) + part(p_S[1], half_sizes[1], e2);
  return pow(pow(across, e2 / e1) + part(p_S[2], half_sizes[2], e1), e1);
}

// Parameters: half sizes (3), e1, e2, rotation vector from the start (3), translation (3); lengths
// over the points' diagonal.
struct PointOffSurface {
  Eigen::Matrix3d R_SP;  // from the points' axes to those of the start
  Vector3d p;

  template <class T>
  bool operator()(const T* x, T* residual) const {
    const T from_middle[3] = {T(p.x()) - x[8], T(p.y()) - x[9], T(p.z()) - x[10]};
    T started[3];
    for (int k = 0; k < 3; ++k) {
      started[k] =
          R_SP(k, 0) * from_middle[0] + R_SP(k, 1) * from_middle[1] + R_SP(k, 2) * from_middle[2];
    }
    const T back[3] = {-x[5], -x[6], -x[7]};
    T p_S[3];
    ceres::AngleAxisRotatePoint(back, started, p_S);
    using std::sqrt;
    residual[0] = sqrt(x[0] * x[1] * x[2]) * (inside_outside(p_S, x, x[3], x[4]) - T(1));
    return true;
  }
};

struct Fit {
  Superquadric solid;  // lengths over the diagonal
  double cost = std::numeric_limits<double>::infinity();
};

// From the box along the columns of R, `middle` and `half_sizes`.
Fit fit_from(const std::vector<Vector3d>& points, const Eigen::Matrix3d& R, const Vector3d& middle,
             const Vector3d& half_sizes) {
  std::array<double, kParameters> x{};
  ceres::Problem problem;
  for (const Vector3d& p : points) {
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<PointOffSurface, 1, kParameters>(
                                 new PointOffSurface{R.transpose(), p}),
                             nullptr, x.data());
  }
  const auto bounded = [&](int k, double start, double low, double high) {
    x[static_cast<std::size_t>(k)] = std::clamp(start, low, high);
    problem.SetParameterLowerBound(x.data(), k, low);
    problem.SetParameterUpperBound(x.data(), k, high);
  };
  for (int k = 0; k < 3; ++k) {
    bounded(k, half_sizes[k], kLeastSide, kMostSide);
    x[static_cast<std::size_t>(8 + k)] = middle[k];
  }
  for (int k = 3; k < 5; ++k) {
    bounded(k, 1, Superquadric::kLeastExponent, Superquadric::kMostExponent);
  }
  ceres::Solver::Options how;
  how.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  how.max_num_iterations = 100;
  how.function_tolerance = 1e-7;
  how.logging_type = ceres::SILENT;
  how.num_threads = 1;
  ceres::Solver::Summary summary;
  ceres::Solve(how, &problem, &summary);

  Fit fit;
  fit.cost = summary.final_cost;
  Eigen::Matrix3d turn;
  ceres::AngleAxisToRotationMatrix(&x[5], turn.data());  // column-major, as Eigen's
  fit.solid.X_WS.linear() = R * turn;
  fit.solid.X_WS.translation() = Vector3d(x[8], x[9], x[10]);
  fit.solid.half_sizes = {x[0], x[1], x[2]};
  fit.solid.e1 = x[3];
  fit.solid.e2 = x[4];
  return fit;
}

}  // namespace

double Superquadric::radial_distance(const Vector3d& p_W) const {
  const Vector3d p_S = X_WS.inverse() * p_W;
  const double power = inside_outside(p_S.data(), half_sizes.data(), e1, e2);
  // The middle has no direction.
  if (!(power > 1e-9)) return -half_sizes.minCoeff();
  return p_S.norm() * (1 - 1 / std::sqrt(power));
}

Superquadric fit_superquadric(const std::vector<Vector3d>& points_W) {
  Eigen::AlignedBox3d box;
  for (const Vector3d& p : points_W) {
    if (!p.allFinite()) {
      throw geometry::InputError("A point to fit a superquadric to is not finite",
                                 "Leave such points out");
    }
    box.extend(p);
  }
  const double diagonal = box.isEmpty() ? 0 : box.diagonal().norm();
  if (points_W.size() < kParameters || !(diagonal > 0)) {
    throw geometry::InputError("A superquadric of 11 parameters is to fit " +
                                   std::to_string(points_W.size()) + " points " +
                                   std::to_string(diagonal) + " m across",
                               "Give at least 11 points of a body that is larger than 0");
  }
  const Vector3d origin = box.center();
  const std::size_t step = 1 + (points_W.size() - 1) / kMostPoints;
  std::vector<Vector3d> points;
  Vector3d mean = Vector3d::Zero();
  for (std::size_t i = 0; i < points_W.size(); i += step) {
    points.push_back((points_W[i] - origin) / diagonal);
    mean += points.back();
  }
  mean /= static_cast<double>(points.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Vector3d& p : points) covariance += (p - mean) * (p - mean).transpose();
  const Eigen::Matrix3d axes =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvectors();

  Fit best;
  for (int z = 0; z < 3; ++z) {
    Eigen::Matrix3d R;
    R.col(2) = axes.col(z);
    R.col(0) = axes.col((z + 1) % 3);
    R.col(1) = R.col(2).cross(R.col(0));
    Eigen::AlignedBox3d along;
    for (const Vector3d& p : points) along.extend(Vector3d(R.transpose() * p));
    const Fit fit = fit_from(points, R, R * along.center(), 0.5 * along.sizes());
    if (fit.cost < best.cost) best = fit;
  }
  best.solid.half_sizes *= diagonal;
  best.solid.X_WS.translation() = origin + diagonal * best.solid.X_WS.translation();
  return best.solid;
}

geometry::TriangleMesh mesh_of(const Superquadric& solid, const geometry::Plane& table_W) {
  constexpr double kCells = 64;
  const double cell = 2 * solid.half_sizes.maxCoeff() / kCells;
  const Vector3d reach =
      solid.X_WS.linear().cwiseAbs() * solid.half_sizes + Vector3d::Constant(2 * cell);
  const Vector3d middle = solid.X_WS.translation();
  return mesh_of(
      [&](const Vector3d& p) {
        return std::max(solid.radial_distance(p), -table_W.signed_distance(p));
      },
      {middle - reach, middle + reach}, cell);
}

}  // namespace prehend::eval

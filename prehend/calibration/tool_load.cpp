#include "prehend/calibration/tool_load.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "prehend/calibration/degenerate_data.h"
#include "prehend/geometry/gravity.h"

namespace prehend::calibration {
namespace {

constexpr std::size_t kLeastPoses = 6;
constexpr double kLeastTilt = 0.17;      // rad between two poses' gravity
constexpr double kLeastSideways = 0.06;  // standard deviation of gravity's second direction
constexpr double kAgreement = 4;         // robust standard deviations
constexpr double kFromMiddle = 1.4826;   // of a normal distribution's absolute values' median

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d matrix;
  matrix << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return matrix;
}

Eigen::Vector3d gravity_in(const StillWrench& pose) {
  return -geometry::kGravity * pose.R_WS.transpose().col(2);
}

void check(const std::vector<StillWrench>& poses) {
  for (const StillWrench& pose : poses) {
    if (!pose.R_WS.allFinite() || !pose.force_S.allFinite() || !pose.torque_S.allFinite()) {
      throw std::invalid_argument("a wrench or orientation is not finite");
    }
    if (!(pose.R_WS * pose.R_WS.transpose()).isIdentity(1e-6) || pose.R_WS.determinant() < 0) {
      throw std::invalid_argument("an orientation is no rotation");
    }
  }
}

void require_tilt(const std::vector<StillWrench>& poses, const std::vector<std::size_t>& used) {
  if (used.size() < kLeastPoses) {
    throw DegenerateData("too few poses", fmt::format("{} of {}", used.size(), kLeastPoses),
                         "Hold the sensor still in 12 poses, tilted to all sides");
  }
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double most = 0;
  for (const std::size_t i : used) {
    const Eigen::Vector3d down = gravity_in(poses[i]).normalized();
    mean += down / static_cast<double>(used.size());
    for (const std::size_t k : used) {
      const Eigen::Vector3d other = gravity_in(poses[k]).normalized();
      most = std::max(most, std::atan2(down.cross(other).norm(), down.dot(other)));
    }
  }
  if (most < kLeastTilt) {
    throw DegenerateData("no tilt",
                         fmt::format("gravity's direction in the sensor changes by {:.1f} degrees "
                                     "at most",
                                     most * 180 / M_PI),
                         "Tilt the sensor by 45 degrees and more, to different sides");
  }
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const std::size_t i : used) {
    const Eigen::Vector3d away = gravity_in(poses[i]).normalized() - mean;
    scatter += away * away.transpose() / static_cast<double>(used.size());
  }
  const double second = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvalues()(1);
  if (std::sqrt(std::max(0.0, second)) < kLeastSideways) {
    throw DegenerateData("tilt to one side alone",
                         "along that side's way the centre of mass is not determined",
                         "Tilt the sensor to a second side as well");
  }
}

struct LeastSquares {
  Eigen::VectorXd x, deviations;
  double rms = 0;
};

LeastSquares least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  const Eigen::LDLT<Eigen::MatrixXd> normal(A.transpose() * A);
  LeastSquares solved;
  solved.x = normal.solve(A.transpose() * b);
  const double squares = (b - A * solved.x).squaredNorm();
  const auto rows = static_cast<double>(A.rows());
  const double variance = squares / (rows - static_cast<double>(A.cols()));
  solved.rms = std::sqrt(squares / rows);
  solved.deviations =
      (variance * normal.solve(Eigen::MatrixXd::Identity(A.cols(), A.cols())).diagonal())
          .cwiseMax(0)
          .cwiseSqrt();
  return solved;
}

double middle_of(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

void solve(const std::vector<StillWrench>& poses, const std::vector<std::size_t>& used,
           ToolLoadFit& fit) {
  const auto rows = static_cast<Eigen::Index>(3 * used.size());
  Eigen::MatrixXd of_force = Eigen::MatrixXd::Zero(rows, 4);
  Eigen::MatrixXd of_torque = Eigen::MatrixXd::Zero(rows, 6);
  Eigen::VectorXd force(rows), torque(rows);
  for (std::size_t n = 0; n < used.size(); ++n) {
    const StillWrench& pose = poses[used[n]];
    const auto row = static_cast<Eigen::Index>(3 * n);
    const Eigen::Vector3d g = gravity_in(pose);
    of_force.block<3, 3>(row, 0).setIdentity();
    of_force.block<3, 1>(row, 3) = g;
    of_torque.block<3, 3>(row, 0).setIdentity();
    of_torque.block<3, 3>(row, 3) = -cross_matrix(g);
    force.segment<3>(row) = pose.force_S;
    torque.segment<3>(row) = pose.torque_S;
  }
  const LeastSquares forces = least_squares(of_force, force),
                     torques = least_squares(of_torque, torque);
  fit.force_bias = forces.x.head<3>();
  fit.force_bias_deviation = forces.deviations.head<3>();
  fit.mass = forces.x(3);
  fit.mass_deviation = forces.deviations(3);
  fit.torque_bias = torques.x.head<3>();
  fit.torque_bias_deviation = torques.deviations.head<3>();
  fit.center_S = torques.x.tail<3>() / fit.mass;
  const double relative = fit.mass_deviation / fit.mass;
  fit.center_deviation = ((torques.deviations.tail<3>() / fit.mass).array().square() +
                          (relative * fit.center_S).array().square())
                             .sqrt();
  fit.force_rms = forces.rms;
  fit.torque_rms = torques.rms;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Eigen::Vector3d g = gravity_in(poses[i]);
    fit.poses[i].force_residual = poses[i].force_S - fit.force_bias - fit.mass * g;
    fit.poses[i].torque_residual =
        poses[i].torque_S - fit.torque_bias - (fit.mass * fit.center_S).cross(g);
  }
}

}  // namespace

ToolLoadFit calibrate_tool_load(const std::vector<StillWrench>& poses) {
  check(poses);
  ToolLoadFit fit;
  std::vector<std::size_t> used;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    fit.poses.push_back({poses[i].name, true});
    used.push_back(i);
  }
  require_tilt(poses, used);
  solve(poses, used, fit);
  // One after the other, the worst first: a few bad poses bend the fit of the others.
  while (true) {
    std::vector<double> forces, torques;
    for (const std::size_t i : used) {
      forces.push_back(fit.poses[i].force_residual.norm());
      torques.push_back(fit.poses[i].torque_residual.norm());
    }
    const double force_scale = std::max(kFromMiddle * middle_of(forces), 1e-9);
    const double torque_scale = std::max(kFromMiddle * middle_of(torques), 1e-9);
    double worst = 0;
    std::size_t at = 0;
    for (std::size_t n = 0; n < used.size(); ++n) {
      const double off = std::max(forces[n] / force_scale, torques[n] / torque_scale);
      if (off > worst) {
        worst = off;
        at = n;
      }
    }
    if (!(worst > kAgreement) || 2 * (used.size() - 1) < poses.size()) break;
    std::vector<std::size_t> fewer = used;
    fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(at));
    if (fewer.size() < kLeastPoses) break;
    fit.poses[used[at]].used = false;
    used = fewer;
    require_tilt(poses, used);
    solve(poses, used, fit);
  }
  if (fit.mass < -3 * fit.mass_deviation) {
    throw DegenerateData(
        "signs reversed", fmt::format("the mass comes out as {:.3g} kg", fit.mass),
        "Give the force on the sensor, not by it, and the sensor's orientation in a "
        "frame whose z is up, not its inverse");
  }
  if (!(fit.mass > 3 * fit.mass_deviation)) {
    throw DegenerateData("no load",
                         fmt::format("the mass is {:.3g} kg with a standard deviation of {:.2g} kg",
                                     fit.mass, fit.mass_deviation),
                         "Mount the tool; without one tare the sensor instead");
  }
  return fit;
}

}  // namespace prehend::calibration

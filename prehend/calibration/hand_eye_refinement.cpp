#include "prehend/calibration/hand_eye_refinement.h"

#include <cmath>
#include <memory>

#include "prehend/calibration/degenerate_data.h"
#include "prehend/calibration/hand_eye_residual.h"

namespace prehend::calibration {
namespace {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// The arm's pose is where it says, within its noise.
struct ArmPrior {
  const HandEyeOptions& options;
  template <class T>
  bool operator()(const T* error, T* residuals) const {
    for (int i = 0; i < 3; ++i) {
      residuals[i] = error[i] / options.rotation_noise;
      residuals[3 + i] = error[3 + i] / options.position_noise;
    }
    return true;
  }
};

geometry::RigidTransform moved(const geometry::RigidTransform& X, const std::vector<double>& x) {
  const PoseOf<double> small = PoseOf<double>::small(x.data());
  geometry::RigidTransform S = geometry::RigidTransform::Identity();
  S.linear() = small.R;
  S.translation() = small.t;
  return X * S;
}

double largest_deviation(const double* covariance, int first) {
  double most = 0;
  for (int i = first; i < first + 3; ++i) most = std::max(most, covariance[i * 6 + i]);
  return std::sqrt(most);
}

}  // namespace

geometry::RigidTransform HandEyeRefinement::flange(const HandEyePose& pose,
                                                   const robot::KinematicChain* chain) const {
  return chain ? chain->forward(pose.q + offsets) : pose.X_BF;
}

HandEyeRefinement refine_hand_eye(const std::vector<HandEyePose>& poses,
                                  const std::vector<int>& chosen, const HandEyeUnknowns& start,
                                  const CalibrationBoard& board,
                                  const perception::CameraCalibration& camera,
                                  const HandEyeOptions& options) {
  const int joints = options.chain ? options.chain->size() : 0;
  std::vector<double> x_C(6, 0.0), x_T(6, 0.0), offsets(static_cast<std::size_t>(joints), 0.0);
  std::vector<std::vector<double>> errors(chosen.size(), std::vector<double>(6, 0.0));
  ceres::Problem problem;
  int residuals = 0;
  for (std::size_t n = 0; n < chosen.size(); ++n) {
    const HandEyePose& pose = poses[static_cast<std::size_t>(chosen[n])];
    std::vector<double*> blocks{x_C.data(), x_T.data(), errors[n].data()};
    if (joints > 0) blocks.push_back(offsets.data());
    problem.AddResidualBlock(HandEyeResidual::make(pose, start, board, camera, options), nullptr,
                             blocks);
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<ArmPrior, 6, 6>(new ArmPrior{options}),
                             nullptr, errors[n].data());
    residuals += 2 * static_cast<int>(pose.view.ids.size());
  }
  if (joints > 0) {
    std::vector<int> fixed{0};
    if (joints > 1) fixed.push_back(joints - 1);
    if (static_cast<int>(fixed.size()) == joints) {
      problem.SetParameterBlockConstant(offsets.data());
    } else {
      problem.SetManifold(offsets.data(), new ceres::SubsetManifold(joints, fixed));
    }
  }
  ceres::Solver::Options solving;
  solving.linear_solver_type = ceres::DENSE_SCHUR;
  solving.max_num_iterations = 100;
  solving.function_tolerance = 1e-10;
  solving.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solving, &problem, &summary);

  HandEyeRefinement refined;
  refined.unknowns.X_PC = moved(start.X_PC, x_C);
  refined.unknowns.X_QT = moved(start.X_QT, x_T);
  refined.offsets = Eigen::Map<const Eigen::VectorXd>(offsets.data(), joints);
  refined.offset_deviations = Eigen::VectorXd::Zero(joints);
  const double unknowns = 12 + std::max(0, joints - 2);
  const double variance = std::max(1.0, 2 * summary.final_cost / (residuals - unknowns));
  ceres::Covariance::Options covariance_options;
  covariance_options.algorithm_type = ceres::DENSE_SVD;
  covariance_options.null_space_rank = 0;
  ceres::Covariance covariance(covariance_options);
  std::vector<std::pair<const double*, const double*>> blocks{{x_C.data(), x_C.data()}};
  if (joints > 0) blocks.emplace_back(offsets.data(), offsets.data());
  if (!covariance.Compute(blocks, &problem)) {
    throw DegenerateData(joints > 0 ? "joint offsets not determined" : "rotation axes parallel",
                         "the poses leave a direction of the unknowns open",
                         "Take more poses in which all joints differ much");
  }
  std::array<double, 36> of_camera{};
  covariance.GetCovarianceBlock(x_C.data(), x_C.data(), of_camera.data());
  refined.rotation_deviation = std::sqrt(variance) * largest_deviation(of_camera.data(), 0);
  refined.position_deviation = std::sqrt(variance) * largest_deviation(of_camera.data(), 3);
  if (joints > 0) {
    std::vector<double> of_offsets(static_cast<std::size_t>(joints * joints));
    covariance.GetCovarianceBlock(offsets.data(), offsets.data(), of_offsets.data());
    for (int j = 0; j < joints; ++j) {
      refined.offset_deviations[j] =
          std::sqrt(variance * of_offsets[static_cast<std::size_t>(j * joints + j)]);
    }
  }
  return refined;
}

Eigen::MatrixXd pose_information(const HandEyePose& pose, const HandEyeUnknowns& guess,
                                 const CalibrationBoard& board,
                                 const perception::CameraCalibration& camera,
                                 const HandEyeOptions& options) {
  const std::unique_ptr<ceres::CostFunction> function(
      HandEyeResidual::make(pose, guess, board, camera, options));
  const int rows = function->num_residuals();
  const int joints = options.chain ? options.chain->size() : 0;
  const int offsets = std::max(0, joints - 2);
  const std::vector<double> zeros(static_cast<std::size_t>(std::max(6, joints)), 0.0);
  std::vector<const double*> values(function->parameter_block_sizes().size(), zeros.data());
  std::vector<RowMatrix> jacobians;
  std::vector<double*> pointers;
  for (const int size : function->parameter_block_sizes()) jacobians.emplace_back(rows, size);
  for (RowMatrix& jacobian : jacobians) pointers.push_back(jacobian.data());
  std::vector<double> residuals(static_cast<std::size_t>(rows));
  Eigen::MatrixXd J(rows, 12 + offsets);
  if (!function->Evaluate(values.data(), residuals.data(), pointers.data())) {
    return Eigen::MatrixXd::Zero(12 + offsets, 12 + offsets);  // behind the camera
  }
  J.leftCols<6>() = jacobians[0];
  J.middleCols<6>(6) = jacobians[1];
  if (offsets > 0) J.rightCols(offsets) = jacobians[3].middleCols(1, offsets);
  // Residuals are in units of the pixels' noise: S is the unit matrix, E = G G^T; by Woodbury.
  Eigen::MatrixXd G = jacobians[2];
  G.leftCols<3>() *= options.rotation_noise;
  G.rightCols<3>() *= options.position_noise;
  const Eigen::Matrix<double, 6, 6> inner =
      Eigen::Matrix<double, 6, 6>::Identity() + G.transpose() * G;
  const Eigen::MatrixXd across = G.transpose() * J;
  return J.transpose() * J - across.transpose() * inner.llt().solve(across);
}

}  // namespace prehend::calibration

#include "prehend/calibration/hand_eye_solvers.h"

#include <algorithm>
#include <stdexcept>

#include <Eigen/SVD>
#include <opencv2/calib3d.hpp>

#include "prehend/calibration/opencv_values.h"

namespace prehend::calibration {
namespace {

// With A = X_BF on the hand, its inverse in the world: A X_PC X_CT = X_QT for all poses.
geometry::RigidTransform arm_of(CameraMount mount, const geometry::RigidTransform& X_BF) {
  return mount == CameraMount::kHand ? X_BF : X_BF.inverse();
}

cv::Mat column_of(const Eigen::Vector3d& t) {
  return (cv::Mat_<double>(3, 1) << t.x(), t.y(), t.z());
}

geometry::RigidTransform pose_of(const cv::Mat& R, const cv::Mat& t) {
  geometry::RigidTransform X = geometry::RigidTransform::Identity();
  if (R.rows != 3 || R.cols != 3 || t.total() != 3) {
    X.linear().setConstant(std::nan(""));
    return X;
  }
  X.linear() = eigen_of(R);
  const std::vector<double> numbers = numbers_of(t.clone());
  X.translation() = Eigen::Vector3d(numbers[0], numbers[1], numbers[2]);
  return X;
}

// The rotation nearest to it (some solvers' are not quite one); false where it is none.
bool make_rotation(geometry::RigidTransform& X) {
  if (!X.matrix().allFinite()) return false;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(X.linear(),
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d R = svd.matrixU() * svd.matrixV().transpose();
  if (R.determinant() < 0 || svd.singularValues()(2) < 0.2) return false;
  X.linear() = R;
  return true;
}

geometry::RigidTransform mean_board(CameraMount mount, const geometry::RigidTransform& X_PC,
                                    const std::vector<PosePair>& pairs) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
  for (const PosePair& pair : pairs) {
    const geometry::RigidTransform X_QT = arm_of(mount, pair.X_BF) * X_PC * pair.X_CT;
    sum += X_QT.linear();
    t += X_QT.translation() / static_cast<double>(pairs.size());
  }
  geometry::RigidTransform X_QT = geometry::RigidTransform::Identity();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant());
  X_QT.linear() = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  X_QT.translation() = t;
  return X_QT;
}

}  // namespace

const std::vector<std::string>& hand_eye_solvers() {
  static const std::vector<std::string> kNames{"tsai",       "park", "horaud", "andreff",
                                               "daniilidis", "shah", "li"};
  return kNames;
}

std::optional<HandEyeUnknowns> solve_hand_eye(const std::string& solver, CameraMount mount,
                                              const std::vector<PosePair>& pairs) {
  const auto& names = hand_eye_solvers();
  const auto found = std::find(names.begin(), names.end(), solver);
  if (found == names.end()) throw std::invalid_argument("there is no solver '" + solver + "'");
  const auto index = static_cast<int>(found - names.begin());
  std::vector<cv::Mat> R_arm, t_arm, R_board, t_board;
  for (const PosePair& pair : pairs) {
    // calibrateHandEye takes A, calibrateRobotWorldHandEye its inverse.
    const geometry::RigidTransform A = arm_of(mount, pair.X_BF);
    const geometry::RigidTransform arm = index < 5 ? A : A.inverse();
    R_arm.push_back(matrix_of(arm.linear()));
    t_arm.push_back(column_of(arm.translation()));
    R_board.push_back(matrix_of(pair.X_CT.linear()));
    t_board.push_back(column_of(pair.X_CT.translation()));
  }
  HandEyeUnknowns unknowns;
  try {
    cv::Mat R, t;
    if (index < 5) {
      cv::calibrateHandEye(R_arm, t_arm, R_board, t_board, R, t,
                           static_cast<cv::HandEyeCalibrationMethod>(index));
      unknowns.X_PC = pose_of(R, t);
      if (!make_rotation(unknowns.X_PC)) return std::nullopt;
      unknowns.X_QT = mean_board(mount, unknowns.X_PC, pairs);
    } else {
      cv::Mat R_base, t_base;  // "base to world": X_TQ; "gripper to camera": X_CP
      cv::calibrateRobotWorldHandEye(
          R_board, t_board, R_arm, t_arm, R_base, t_base, R, t,
          static_cast<cv::RobotWorldHandEyeCalibrationMethod>(index - 5));
      geometry::RigidTransform X_CP = pose_of(R, t), X_TQ = pose_of(R_base, t_base);
      if (!make_rotation(X_CP) || !make_rotation(X_TQ)) return std::nullopt;
      unknowns.X_PC = X_CP.inverse();
      unknowns.X_QT = X_TQ.inverse();
    }
  } catch (const cv::Exception&) {
    return std::nullopt;  // says in its own words that the poses are degenerate
  }
  if (!unknowns.X_PC.matrix().allFinite() || !unknowns.X_QT.matrix().allFinite()) {
    return std::nullopt;
  }
  return unknowns;
}

}  // namespace prehend::calibration

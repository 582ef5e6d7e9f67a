#pragma once

#include <array>
#include <vector>

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include "prehend/calibration/hand_eye.h"

// What a camera, a board and an arm must agree on, for automatic derivatives.
namespace prehend::calibration {

/// A pose of numbers with derivatives.
template <class T>
struct PoseOf {
  Eigen::Matrix<T, 3, 3> R = Eigen::Matrix<T, 3, 3>::Identity();
  Eigen::Matrix<T, 3, 1> t = Eigen::Matrix<T, 3, 1>::Zero();

  PoseOf() = default;
  explicit PoseOf(const geometry::RigidTransform& X)
      : R(X.linear().cast<T>()), t(X.translation().cast<T>()) {}
  /// Turned by the rotation vector in small[0..2] [rad], moved by small[3..5] [m].
  static PoseOf small(const T* small) {
    PoseOf pose;
    ceres::AngleAxisToRotationMatrix(small, pose.R.data());
    pose.t = Eigen::Matrix<T, 3, 1>(small[3], small[4], small[5]);
    return pose;
  }
  PoseOf operator*(const PoseOf& other) const {
    PoseOf product;
    product.R = R * other.R;
    product.t = R * other.t + t;
    return product;
  }
  PoseOf inverse() const {
    PoseOf inverse;
    inverse.R = R.transpose();
    inverse.t = -(inverse.R * t);
    return inverse;
  }
};

/// Corners of one pose: (predicted - seen) / pixel_noise, two for each. Parameter blocks: x_C (6)
/// of X_PC = guess * small(x_C), x_T (6) of X_QT = guess * small(x_T), the arm's error e (6) of
/// X_BF * small(e), and, where there is a chain, an offset for each of its joints.
class HandEyeResidual {
 public:
  HandEyeResidual(const HandEyePose& pose, const HandEyeUnknowns& guess,
                  const CalibrationBoard& board, const perception::CameraCalibration& camera,
                  const HandEyeOptions& options)
      : pose_(pose), guess_(guess), options_(options), camera_(camera) {
    for (const int id : pose.view.ids) points_.push_back(board.corner_T(id));
    std::copy(camera.distortion.begin(), camera.distortion.end(), lens_.begin());
  }

  template <class T>
  bool operator()(T const* const* blocks, T* residuals) const {
    using Point = Eigen::Matrix<T, 3, 1>;
    PoseOf<T> X_BF(pose_.X_BF);
    if (options_.chain) X_BF = forward<T>(blocks[3]);
    X_BF = X_BF * PoseOf<T>::small(blocks[2]);
    const PoseOf<T> X_PC = PoseOf<T>(guess_.X_PC) * PoseOf<T>::small(blocks[0]);
    const PoseOf<T> X_QT = PoseOf<T>(guess_.X_QT) * PoseOf<T>::small(blocks[1]);
    const PoseOf<T> X_CT =
        X_PC.inverse() * (options_.mount == CameraMount::kHand ? X_BF.inverse() : X_BF) * X_QT;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Point p = X_CT.R * points_[i].cast<T>() + X_CT.t;
      if (!(p.z() > T(1e-6))) return false;
      const T x = p.x() / p.z(), y = p.y() / p.z(), r2 = x * x + y * y;
      // OpenCV's model: k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4.
      const auto& k = lens_;
      const T radial = (1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))) /
                       (1.0 + r2 * (k[5] + r2 * (k[6] + r2 * k[7])));
      const T u =
          x * radial + 2.0 * k[2] * x * y + k[3] * (r2 + 2.0 * x * x) + r2 * (k[8] + r2 * k[9]);
      const T v =
          y * radial + k[2] * (r2 + 2.0 * y * y) + 2.0 * k[3] * x * y + r2 * (k[10] + r2 * k[11]);
      residuals[2 * i] =
          (camera_.K(0, 0) * u + camera_.K(0, 2) - pose_.view.pixels[i].x()) / options_.pixel_noise;
      residuals[2 * i + 1] =
          (camera_.K(1, 1) * v + camera_.K(1, 2) - pose_.view.pixels[i].y()) / options_.pixel_noise;
    }
    return true;
  }

  /// For Ceres, which owns it.
  static ceres::CostFunction* make(const HandEyePose& pose, const HandEyeUnknowns& guess,
                                   const CalibrationBoard& board,
                                   const perception::CameraCalibration& camera,
                                   const HandEyeOptions& options) {
    auto* function = new ceres::DynamicAutoDiffCostFunction<HandEyeResidual, 6>(
        new HandEyeResidual(pose, guess, board, camera, options));
    for (int block = 0; block < 3; ++block) function->AddParameterBlock(6);
    if (options.chain) function->AddParameterBlock(options.chain->size());
    function->SetNumResiduals(2 * static_cast<int>(pose.view.ids.size()));
    return function;
  }

 private:
  template <class T>
  PoseOf<T> forward(const T* offsets) const {
    PoseOf<T> X;
    const auto& joints = options_.chain->joints();
    for (std::size_t j = 0; j < joints.size(); ++j) {
      const T position = offsets[j] + pose_.q[static_cast<Eigen::Index>(j)];
      const Eigen::Matrix<T, 3, 1> way = joints[j].axis_J.cast<T>() * position;
      const T zero(0);
      const std::array<T, 6> moved =
          joints[j].is_revolute ? std::array<T, 6>{way.x(), way.y(), way.z(), zero, zero, zero}
                                : std::array<T, 6>{zero, zero, zero, way.x(), way.y(), way.z()};
      X = X * PoseOf<T>(joints[j].X_PJ) * PoseOf<T>::small(moved.data());
    }
    return X * PoseOf<T>(options_.chain->X_JT());
  }

  const HandEyePose pose_;
  const HandEyeUnknowns guess_;
  const HandEyeOptions options_;
  const perception::CameraCalibration camera_;
  std::vector<Eigen::Vector3d> points_;
  std::array<double, 12> lens_{};
};

}  // namespace prehend::calibration

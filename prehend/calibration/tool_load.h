#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace prehend::calibration {

/// What a force-torque sensor said while the arm stood still. Frame S of the sensor, W with z up.
struct StillWrench {
  std::string name;
  Eigen::Matrix3d R_WS = Eigen::Matrix3d::Identity();
  Eigen::Vector3d force_S = Eigen::Vector3d::Zero();   // N, on the sensor
  Eigen::Vector3d torque_S = Eigen::Vector3d::Zero();  // N m, about the sensor's origin
};

struct ToolLoadPose {
  std::string name;
  bool used = false;  // false: it does not agree with the others
  Eigen::Vector3d force_residual = Eigen::Vector3d::Zero();   // N, measured - predicted
  Eigen::Vector3d torque_residual = Eigen::Vector3d::Zero();  // N m
};

/// force = force_bias + mass * g, torque = torque_bias + center x (mass * g), g [m/s^2] the gravity
/// in S.
struct ToolLoadFit {
  Eigen::Vector3d force_bias = Eigen::Vector3d::Zero();   // N
  Eigen::Vector3d torque_bias = Eigen::Vector3d::Zero();  // N m
  double mass = 0;                                        // kg, of what hangs on the sensor
  Eigen::Vector3d center_S = Eigen::Vector3d::Zero();     // m, its centre of mass
  double mass_deviation = 0;                              // standard deviations
  Eigen::Vector3d force_bias_deviation = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque_bias_deviation = Eigen::Vector3d::Zero();
  Eigen::Vector3d center_deviation = Eigen::Vector3d::Zero();
  double force_rms = 0, torque_rms = 0;  // N, N m, of the used poses' residuals, each axis
  std::vector<ToolLoadPose> poses;
};

/// A sensor's bias and the tool's load by poses at rest: least squares, linear in bias, mass and
/// mass * center (D. Kubus, T. Kroeger, F. Wahl, "On-line estimation of inertial parameters using a
/// recursive total least-squares approach", IROS 2008, without its accelerations), again without
/// the poses that are more than four robust standard deviations off (a touched tool).
/// @throws DegenerateData "too few poses" (fewer than six), "no tilt" (gravity comes from one side
/// in all of them, and nothing parts weight from bias), "tilt to one side alone" (then the centre
/// along that side's way is open), "no load" (the mass is not above its deviation), "signs
/// reversed" (the mass is negative); std::invalid_argument for values that are not finite or a
/// matrix that is no rotation.
ToolLoadFit calibrate_tool_load(const std::vector<StillWrench>& poses);

}  // namespace prehend::calibration

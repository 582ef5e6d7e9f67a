#include "prehend/robot/formats/extension_rounding.h"

#include <algorithm>
#include <cmath>

namespace prehend::robot::formats {
namespace {

using geometry::RigidTransform;

bool is_near(const RigidTransform& one, const RigidTransform& other) {
  constexpr double kRounding = 1e-11;
  const double size = std::max(1.0, other.translation().cwiseAbs().maxCoeff());
  return (one.matrix() - other.matrix()).cwiseAbs().maxCoeff() <= kRounding * size;
}

/// A joint's frame as far as it matters: turned as the child is, or at the child.
JointDescription as_it_moves(JointDescription joint) {
  using Kind = JointDescription::Kind;
  const bool has_place = joint.kind != Kind::kFixed && joint.kind != Kind::kFloating;
  const RigidTransform X_JK =
      has_place ? geometry::make_transform(Eigen::Quaterniond(joint.X_JC.linear()),
                                           Eigen::Vector3d::Zero())
                : joint.X_JC;
  joint.X_PJ = joint.X_PJ * X_JK;
  joint.X_JC = X_JK.inverse() * joint.X_JC;
  joint.axis_J = X_JK.linear().transpose() * joint.axis_J;
  return joint;
}

}  // namespace

void take_rounded(Shape& plain, const Shape& robot) {
  if (is_near(plain.X_LS, robot.X_LS)) plain.X_LS = robot.X_LS;
  if (!plain.color || !robot.color) return;
  constexpr double kOfFloats = 1e-6;
  double most = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    most = std::max(most, std::abs((*plain.color)[i] - (*robot.color)[i]));
  }
  if (most <= kOfFloats) plain.color = robot.color;
}

void take_rounded(std::optional<Inertial>& plain, const std::optional<Inertial>& robot) {
  if (!plain || !robot) return;
  const auto in_link = [](const Inertial& one) -> Eigen::Matrix3d {
    return one.X_LI.linear() * one.inertia * one.X_LI.linear().transpose();
  };
  constexpr double kRounding = 1e-9, kPlace = 1e-12;
  const Eigen::Matrix3d its = in_link(*robot);
  const bool is_same = std::abs(plain->mass - robot->mass) <= kPlace * robot->mass &&
                       (plain->X_LI.translation() - robot->X_LI.translation()).norm() <= kPlace &&
                       (in_link(*plain) - its).norm() <= kRounding * its.norm();
  if (is_same) plain = robot;
}

void take_rounded(JointDescription& plain, const JointDescription& robot) {
  using Kind = JointDescription::Kind;
  const bool has_axis =
      robot.kind != Kind::kFixed && robot.kind != Kind::kFloating && robot.kind != Kind::kBall;
  const JointDescription one = as_it_moves(plain), other = as_it_moves(robot);
  constexpr double kRounding = 1e-11;
  const bool is_same_axis =
      !has_axis || (one.axis_J - other.axis_J).cwiseAbs().maxCoeff() <= kRounding;
  if (plain.kind == robot.kind && is_same_axis && is_near(one.X_PJ, other.X_PJ) &&
      is_near(one.X_JC, other.X_JC)) {
    plain.X_PJ = robot.X_PJ;
    plain.X_JC = robot.X_JC;
    plain.axis_J = robot.axis_J;
    return;
  }
  if (is_near(plain.X_PJ, robot.X_PJ)) plain.X_PJ = robot.X_PJ;
  if (is_near(plain.X_JC, robot.X_JC)) plain.X_JC = robot.X_JC;
  if (!has_axis || (plain.axis_J - robot.axis_J).cwiseAbs().maxCoeff() <= kRounding) {
    plain.axis_J = robot.axis_J;
  }
}

void take_rounded(Loop& plain, const Loop& robot) {
  if (is_near(plain.X_FirstLoop, robot.X_FirstLoop)) plain.X_FirstLoop = robot.X_FirstLoop;
}
void take_rounded(Sensor& plain, const Sensor& robot) {
  if (is_near(plain.X_LS, robot.X_LS)) plain.X_LS = robot.X_LS;
}
void take_rounded(Actuator&, const Actuator&) {}
void take_rounded(Manipulator& plain, const Manipulator& robot) {
  if (is_near(plain.X_TipTool, robot.X_TipTool)) plain.X_TipTool = robot.X_TipTool;
}
void take_rounded(Posture&, const Posture&) {}

}  // namespace prehend::robot::formats

// Three axes that slide and one that turns.

#include <cmath>
#include <cstdio>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "prehend/robot/inverse_collector.h"

namespace prehend::robot {
namespace {

constexpr double kFlat = 1e-3;  // volume of three unit vectors that span no space
constexpr double kTilt = 1e-6;  // rad, by which a pose may be turned otherwise: rounding

}  // namespace

bool InverseKinematics::has_three_slides() const {
  if (chain_.size() != 4) return false;
  const bool turns_first = chain_.joints()[0].is_revolute;
  Eigen::Matrix3d slides;
  for (std::size_t i = 0; i < 4; ++i) {
    const bool turns = i == (turns_first ? 0u : 3u);
    if (chain_.joints()[i].is_revolute != turns) return false;
    if (!turns) slides.col(static_cast<Eigen::Index>(i) - (turns_first ? 1 : 0)) = axis_[i];
  }
  return std::abs(slides.determinant()) > kFlat;
}

// The motion of the tip from position 0 is a turn about the one axis, by which the pose must be
// turned as well, and slides along the others, which that turn carries along when it comes first.
void InverseKinematics::three_slides(const geometry::RigidTransform& X_BT, Collector& found) const {
  const geometry::RigidTransform motion = X_BT * X_TB_;
  const bool turns_first = chain_.joints()[0].is_revolute;
  const Eigen::Index turning = turns_first ? 0 : 3, first_slide = turns_first ? 1 : 0;
  const Eigen::Vector3d& axis = axis_[static_cast<std::size_t>(turning)];
  const Eigen::Vector3d& point = point_[static_cast<std::size_t>(turning)];
  const Eigen::Vector3d across = axis.unitOrthogonal();
  const Eigen::Vector3d turned = motion.linear() * across;
  Positions q(4);
  q[turning] = std::atan2(axis.dot(across.cross(turned)), across.dot(turned));
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(q[turning], axis).toRotationMatrix();
  const double tilt =
      Eigen::AngleAxisd(Eigen::Matrix3d(turn.transpose() * motion.linear())).angle();
  if (!(tilt <= kTilt)) {
    found.out_of_reach = tilt;
    if (!found.in_words) return;
    char text[160];
    std::snprintf(text, sizeof text,
                  "out of reach: tilted by %.2f deg, and only joint '%.60s' turns the tool",
                  tilt * 57.29577951308232,
                  chain_.joints()[static_cast<std::size_t>(turning)].name.c_str());
    found.unreachable = text;
    return;
  }
  Eigen::Matrix3d slides;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const Eigen::Vector3d& along = axis_[static_cast<std::size_t>(first_slide + i)];
    slides.col(i) = turns_first ? Eigen::Vector3d(turn * along) : along;
  }
  q.segment<3>(first_slide) = slides.inverse() * (motion.translation() - (point - turn * point));
  found.add(q);
}

}  // namespace prehend::robot

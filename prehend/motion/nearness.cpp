#include "prehend/motion/nearness.h"

#include <cmath>
#include <vector>

namespace prehend::motion {

Nearness nearness(const RobotInWorld& robot, const Eigen::Ref<const Eigen::VectorXd>& q) {
  thread_local std::vector<Eigen::Vector3d> centers;
  const RobotSpheres& spheres = robot.spheres();
  spheres.centers(robot.chain(), q, centers);
  // Balls without what they are larger than they need be: shapes are in them still.
  const auto radius = [&spheres](std::size_t ball) {
    const RobotSphere& sphere = spheres.spheres[ball];
    return sphere.radius - (sphere.link >= 0 ? kBallSpare : 0);
  };
  Nearness nearest;
  for (std::size_t i = 0; i < centers.size(); ++i) {
    // What stands with the base never moves.
    if (spheres.spheres[i].joint < 0) continue;
    std::string name;
    const double distance = robot.world().clearance(centers[i], radius(i), &name) - robot.margin();
    if (distance < nearest.distance) nearest = {distance, static_cast<int>(i), -1, name};
  }
  for (const auto& [a, b] : spheres.self_pairs) {
    const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
    const double reach = radius(i) + radius(j);
    // Most pairs are far apart: no root is taken of these.
    const double bound = nearest.distance + reach;
    const double square = (centers[i] - centers[j]).squaredNorm();
    if (bound > 0 && square < bound * bound) nearest = {std::sqrt(square) - reach, a, b, {}};
  }
  return nearest;
}

std::string pair_of(const RobotInWorld& robot, const Nearness& near) {
  const auto link = [&](int ball) -> std::string {
    const int joint = robot.spheres().spheres.at(static_cast<std::size_t>(ball)).joint;
    if (joint < 0) return "the base";
    return "the link of joint '" + robot.chain().joints()[static_cast<std::size_t>(joint)].name +
           "'";
  };
  return link(near.ball) + " and " +
         (near.other >= 0 ? link(near.other) : "'" + near.obstacle + "'");
}

}  // namespace prehend::motion

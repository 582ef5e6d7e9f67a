#include "prehend/motion/trajectory.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/robot/arms.h"

namespace prehend::motion {
namespace {

using robot::Positions;

Positions with(int joint, double value) {
  Positions q = Positions::Zero(6);
  q[joint] = value;
  return q;
}

TEST(Trajectory, OneJointFollowsTheTrapezoidsClosedForm) {
  const robot::KinematicChain arm = robot::kr5();
  const double v = arm.joints()[0].max_velocity, a = 10, way = 2.5;
  const Trajectory trajectory(arm, {with(0, 0), with(0, way)}, Eigen::VectorXd::Constant(6, a));
  EXPECT_NEAR(trajectory.duration(), way / v + v / a, 1e-12);
  EXPECT_NEAR(trajectory.at(v / a).position[0], v * v / (2 * a), 1e-12);
  EXPECT_NEAR(trajectory.at(trajectory.duration() / 2).position[0], way / 2, 1e-12);
  EXPECT_NEAR(trajectory.at(trajectory.duration() / 2).velocity[0], v, 1e-12);
  // Too short to reach the speed.
  const Trajectory small(arm, {with(0, 0), with(0, 0.1)}, Eigen::VectorXd::Constant(6, a));
  EXPECT_NEAR(small.duration(), 2 * std::sqrt(0.1 / a), 1e-12);
}

TEST(Trajectory, KeepsLimitsIsContinuousAndStopsAtWaypoints) {
  const robot::KinematicChain arm = robot::kr5();
  std::mt19937_64 random(1);
  std::vector<Positions> waypoints;
  for (int i = 0; i < 6; ++i) waypoints.push_back(robot::random_positions(arm, random));
  waypoints.push_back(waypoints.back());  // a line without length
  const Eigen::VectorXd most = Eigen::VectorXd::Constant(6, 8.0);
  const double factor = 0.7;
  const Trajectory trajectory(arm, waypoints, most, factor);
  const double h = 1e-4;
  TrajectoryPoint before = trajectory.at(0);
  EXPECT_EQ(before.position, waypoints.front());
  for (double t = h; t < trajectory.duration() + 0.1; t += h) {
    const TrajectoryPoint now = trajectory.at(t);
    for (int j = 0; j < 6; ++j) {
      const double limit = arm.joints()[static_cast<std::size_t>(j)].max_velocity;
      ASSERT_LE(std::abs(now.velocity[j]), factor * limit * (1 + 1e-12));
      ASSERT_LE(std::abs(now.acceleration[j]), most[j] * (1 + 1e-12));
    }
    // The trapezoid rule is exact but for the instants at which the acceleration jumps.
    ASSERT_LT((now.position - before.position - h / 2 * (now.velocity + before.velocity)).norm(),
              40 * h * h);
    before = now;
  }
  EXPECT_EQ(before.position, waypoints.back());
  EXPECT_EQ(before.velocity.norm(), 0);
}

TEST(Trajectory, RefusesWhatItCannotTime) {
  const robot::KinematicChain arm = robot::kr5();
  const Eigen::VectorXd most = Eigen::VectorXd::Constant(6, 8.0);
  EXPECT_THROW(Trajectory(arm, {}, most), std::invalid_argument);
  EXPECT_THROW(Trajectory(arm, {with(0, std::nan(""))}, most), std::invalid_argument);
  EXPECT_THROW(Trajectory(arm, {with(0, 1)}, most, 0), std::invalid_argument);
  EXPECT_THROW(Trajectory(arm, {with(0, 1)}, Eigen::VectorXd::Zero(6)), std::invalid_argument);
  EXPECT_THROW(Trajectory(arm, {Positions::Zero(5)}, most), std::invalid_argument);
  const Trajectory still(arm, {with(0, 1)}, most);
  EXPECT_EQ(still.duration(), 0);
  EXPECT_EQ(still.at(3).position[0], 1);
}

}  // namespace
}  // namespace prehend::motion

#include "prehend/motion/blended_trajectory.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "prehend/motion/rrt_connect.h"
#include "tests/motion/shelves.h"

namespace prehend::motion {
namespace {

using robot::Positions;

Positions posed(int joint, double value) {
  Positions q = Positions::Zero(6);
  q[joint] = value;
  return q;
}

std::vector<Positions> random_way(const robot::KinematicChain& arm, std::mt19937_64& random,
                                  int count) {
  std::vector<Positions> way;
  for (int i = 0; i < count; ++i) way.push_back(robot::random_positions(arm, random));
  return way;
}

/// Samples a trajectory and checks limits, and that velocity and acceleration are derivatives.
void expect_limits_kept(const robot::KinematicChain& arm, const BlendedTrajectory& trajectory,
                        const Eigen::VectorXd& most, double factor, int samples) {
  const double h = trajectory.duration() / samples;
  double fastest = 0, hardest = 0;
  for (int i = 0; i <= samples; ++i) {
    const TrajectoryPoint now = trajectory.at(h * i);
    for (int j = 0; j < arm.size(); ++j) {
      const double v = factor * arm.joints()[static_cast<std::size_t>(j)].max_velocity;
      fastest = std::max(fastest, std::abs(now.velocity[j]) / v);
      hardest = std::max(hardest, std::abs(now.acceleration[j]) / most[j]);
    }
  }
  EXPECT_LE(fastest, 1 + 1e-9);
  EXPECT_LE(hardest, 1 + 1e-9);
  EXPECT_GT(std::max(fastest, hardest), 0.98);  // and used
}

void expect_derivatives(const BlendedTrajectory& trajectory, int samples, double tolerance) {
  const double h = trajectory.duration() / samples;
  TrajectoryPoint before = trajectory.at(0);
  for (int i = 1; i <= samples; ++i) {
    const TrajectoryPoint now = trajectory.at(h * i);
    ASSERT_LT((now.position - before.position - h / 2 * (now.velocity + before.velocity)).norm(),
              tolerance * h * h);
    ASSERT_LT((now.velocity - before.velocity).norm(), tolerance * h);
    before = now;
  }
}

double distance_to_lines(const Positions& q, const std::vector<Positions>& way) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < way.size(); ++i) {
    const Positions line = way[i] - way[i - 1];
    const double part = std::clamp((q - way[i - 1]).dot(line) / line.squaredNorm(), 0.0, 1.0);
    least = std::min(least, (q - way[i - 1] - part * line).norm());
  }
  return least;
}

TEST(BlendedTrajectory, OneLineIsTheTrapezoid) {
  const robot::KinematicChain arm = robot::kr5();
  const double v = arm.joints()[0].max_velocity, a = 10;
  const Eigen::VectorXd most = Eigen::VectorXd::Constant(6, a);
  const BlendedTrajectory one(arm, BlendedPath({posed(0, 0), posed(0, 2.5)}, 0.1), most);
  EXPECT_NEAR(one.duration(), 2.5 / v + v / a, 1e-12);
  EXPECT_NEAR(one.at(v / a).position[0], v * v / (2 * a), 1e-12);
  const BlendedTrajectory small(arm, BlendedPath({posed(0, 0), posed(0, 0.1)}, 0.1), most);
  EXPECT_NEAR(small.duration(), 2 * std::sqrt(0.1 / a), 1e-12);
  // Any line, at any time: as the motion that stops at waypoints.
  std::mt19937_64 random(1);
  for (int n = 0; n < 50; ++n) {
    const auto way = random_way(arm, random, 2);
    const Trajectory simple(arm, way, most);
    const BlendedTrajectory blended(arm, BlendedPath(way, 0.1), most);
    EXPECT_NEAR(blended.duration(), simple.duration(), 1e-12);
    for (double t = -0.1; t < simple.duration() + 0.1; t += 0.01) {
      EXPECT_LT((blended.at(t).position - simple.at(t).position).norm(), 1e-9);
      EXPECT_LT((blended.at(t).velocity - simple.at(t).velocity).norm(), 1e-9);
    }
  }
}

TEST(BlendedTrajectory, WithoutDeviationStopsAtEveryWaypoint) {
  const robot::KinematicChain arm = robot::kr5();
  const Eigen::VectorXd most = Eigen::VectorXd::Constant(6, 8.0);
  std::mt19937_64 random(2);
  const auto way = random_way(arm, random, 7);
  const Trajectory simple(arm, way, most, 0.6);
  const BlendedPath path(way, 0);
  EXPECT_EQ(path.stops(), 5);
  const BlendedTrajectory blended(arm, path, most, 0.6);
  EXPECT_NEAR(blended.duration(), simple.duration(), 1e-9);
  for (double t = 0; t < simple.duration(); t += 0.003) {
    ASSERT_LT((blended.at(t).position - simple.at(t).position).norm(), 1e-8);
  }
}

TEST(BlendedTrajectory, KeepsLimitsAndDeviationAndIsFasterOnTheWhole) {
  std::mt19937_64 random(3);
  double blended = 0, stopping = 0;
  for (const robot::KinematicChain& arm : {robot::kr5(), robot::pa10()}) {
    for (int n = 0; n < 60; ++n) {
      const auto way = random_way(arm, random, 3 + n % 8);
      const double deviation = std::pow(10.0, -2 * robot::uniform(random));
      const double factor = 0.2 + 0.8 * robot::uniform(random);
      Eigen::VectorXd most(arm.size());
      for (int j = 0; j < arm.size(); ++j) {
        most[j] = 2 + 6 * robot::uniform(random);
      }
      const BlendedPath path(way, deviation);
      const BlendedTrajectory trajectory(arm, path, most, factor);
      expect_limits_kept(arm, trajectory, most, factor, 20000);
      blended += trajectory.duration();
      stopping += Trajectory(arm, way, most, factor).duration();
      EXPECT_EQ(trajectory.at(0).position, way.front());
      EXPECT_EQ(trajectory.at(trajectory.duration()).position, way.back());
      EXPECT_EQ(trajectory.at(trajectory.duration()).velocity.norm(), 0);
      EXPECT_LT((trajectory.at(trajectory.duration() - 1e-9).position - way.back()).norm(), 1e-6);
      for (int i = 0; i <= 500; ++i) {
        const Positions q = trajectory.at(trajectory.duration() * i / 500).position;
        ASSERT_LE(distance_to_lines(q, way), deviation + 1e-9);
      }
    }
  }
  EXPECT_LT(blended, 0.97 * stopping);
}

TEST(BlendedTrajectory, VelocityAndAccelerationAreDerivatives) {
  const robot::KinematicChain arm = robot::pa10();
  std::mt19937_64 random(4);
  const Eigen::VectorXd most = Eigen::VectorXd::Constant(7, 5.0);
  for (int n = 0; n < 10; ++n) {
    const BlendedPath path(random_way(arm, random, 6), 0.1);
    EXPECT_EQ(path.stops(), 0);
    expect_derivatives(BlendedTrajectory(arm, path, most), 20000, 40);
  }
}

TEST(BlendedTrajectory, IsNearlyTheFastestOnItsPath) {
  const robot::KinematicChain arm = robot::kr5();
  const Eigen::VectorXd most = Eigen::VectorXd::Constant(6, 8.0);
  std::mt19937_64 random(5);
  for (int n = 0; n < 20; ++n) {
    const BlendedPath path(random_way(arm, random, 6), 0.1);
    const double fine = BlendedTrajectory(arm, path, most, 1, 0.001).duration();
    const double usual = BlendedTrajectory(arm, path, most).duration();
    EXPECT_LT(usual, 1.005 * fine);
    EXPECT_GT(usual, 0.9999 * fine);
  }
}

TEST(BlendedTrajectory, ALongerArcIsNoSlower) {
  // A right angle of two joints: the more may be cut, the sooner it is done.
  const robot::KinematicChain arm = robot::kr5();
  const Eigen::VectorXd most = Eigen::VectorXd::Constant(6, 8.0);
  std::vector<Positions> way{posed(0, 0), posed(0, 1), posed(0, 1)};
  way.back()[1] = -1;
  double last = Trajectory(arm, way, most).duration() + 1e-9;
  for (const double deviation : {0.0, 0.001, 0.01, 0.03, 0.1, 0.3}) {
    const double now = BlendedTrajectory(arm, BlendedPath(way, deviation), most).duration();
    EXPECT_LE(now, last) << deviation;
    last = now;
  }
}

TEST(BlendedTrajectory, ExtremesAreTimed) {
  const robot::KinematicChain arm = robot::kr5();
  const Eigen::VectorXd most = Eigen::VectorXd::Constant(6, 8.0);
  // One waypoint; the same one again and again.
  const BlendedTrajectory still(arm, BlendedPath({posed(0, 1)}, 0.1), most);
  EXPECT_EQ(still.duration(), 0);
  EXPECT_EQ(still.at(3).position[0], 1);
  const BlendedTrajectory same(arm, BlendedPath({posed(0, 1), posed(0, 1), posed(0, 1)}, 0.1),
                               most);
  EXPECT_EQ(same.duration(), 0);
  // Repeated and collinear waypoints cost nothing; a reversal is a stop.
  const double v = arm.joints()[0].max_velocity;
  const std::vector<Positions> line{posed(0, 0),   posed(0, 0),   posed(0, 0.5), posed(0, 0.5),
                                    posed(0, 1.3), posed(0, 2.5), posed(0, 2.5)};
  EXPECT_NEAR(BlendedTrajectory(arm, BlendedPath(line, 0.1), most).duration(), 2.5 / v + v / 8,
              1e-9);
  const BlendedPath back({posed(0, 0), posed(0, 1), posed(0, 0.2)}, 0.1);
  EXPECT_EQ(back.stops(), 1);
  const BlendedTrajectory there(arm, back, most);
  EXPECT_NEAR(there.duration(),
              Trajectory(arm, {posed(0, 0), posed(0, 1), posed(0, 0.2)}, most).duration(), 1e-9);
  // From micro-radians at snail's pace to limits that never bind.
  std::mt19937_64 random(6);
  for (const double size : {1e-6, 1e-3, 1.0}) {
    std::vector<Positions> way = random_way(arm, random, 5);
    for (Positions& q : way) q = way.front() + size * (q - way.front());
    for (const double limit : {1e-6, 1.0, 1e6}) {
      const Eigen::VectorXd hardest = Eigen::VectorXd::Constant(6, limit);
      for (const double factor : {1e-4, 1.0}) {
        for (const double deviation : {1e-9, 0.1, 1e3}) {
          const BlendedTrajectory trajectory(arm, BlendedPath(way, deviation), hardest, factor);
          ASSERT_TRUE(std::isfinite(trajectory.duration()));
          EXPECT_GT(trajectory.duration(), 0);
          expect_limits_kept(arm, trajectory, hardest, factor, 2000);
        }
      }
    }
  }
}

TEST(BlendedPath, ArcsThatAreNotFreeAreMadeSmaller) {
  const Shelves shelves;
  RobotInWorld robot = shelves.in_world();
  // Round a ball that stands where a wide arc would pass.
  Positions a = Positions::Zero(7), corner = a, b = a;
  a << 0, 0.9, 0, 0.9, 0, 0, 0;
  robot.change_world([](CollisionWorld& world) { world = CollisionWorld(); });
  corner = a;
  corner[0] = 1.5;
  b = corner;
  b[1] = 0;
  b[3] = 0.3;
  const BlendedPath wide(robot, {a, corner, b}, 0.3);
  ASSERT_EQ(wide.pieces().size(), 3u);
  const Positions inside = wide.pieces()[1].position(wide.pieces()[1].length / 2);
  robot.change_world([&](CollisionWorld& world) {
    world.add_sphere("ball", robot.chain().forward(inside).translation(), 0.02);
  });
  ASSERT_FALSE(robot.is_free(inside));
  const BlendedPath blended(robot, {a, corner, b}, 0.3);
  ASSERT_EQ(blended.pieces().size(), 3u);
  EXPECT_LT(blended.pieces()[1].radius, wide.pieces()[1].radius);
  for (const BlendedPath::Piece& piece : blended.pieces()) {
    for (int i = 0; i <= 500; ++i)
      EXPECT_TRUE(robot.is_free(piece.position(piece.length * i / 500)));
  }
  // Where even the waypoint is not, the corner is left as it is.
  robot.change_world([&](CollisionWorld& world) {
    world.add_sphere("wall", robot.chain().forward(corner).translation(), 0.4);
  });
  EXPECT_EQ(BlendedPath(robot, {a, corner, b}, 0.3).stops(), 1);
}

TEST(BlendTrajectory, IsNeverSlowerThanStopping) {
  // Accelerations that differ a thousandfold, for which circles are the wrong shape.
  const Shelves shelves;
  RobotInWorld robot = shelves.in_world();
  robot.change_world([](CollisionWorld& world) { world = CollisionWorld(); });
  std::mt19937_64 random(7);
  int stopping = 0;
  for (int n = 0; n < 60; ++n) {
    const auto way = random_way(robot.chain(), random, 3 + n % 8);
    Eigen::VectorXd most(7);
    for (int j = 0; j < 7; ++j) most[j] = std::pow(10.0, -1 + 3 * robot::uniform(random));
    const BlendedTrajectory trajectory = blend_trajectory(
        robot, way, most, {.deviation = std::pow(10.0, -3 * robot::uniform(random))});
    expect_limits_kept(robot.chain(), trajectory, most, 1, 20000);
    EXPECT_LE(trajectory.duration(), Trajectory(robot.chain(), way, most).duration() + 1e-9);
    stopping += trajectory.path().stops() == static_cast<int>(way.size()) - 2;
  }
  EXPECT_LT(stopping, 55);  // the rule, not a way out
}

TEST(BlendedPath, ShelvesAreNotTouched) {
  const Shelves shelves;
  const RobotInWorld robot = shelves.in_world();
  const auto left = shelves.reach(robot, {0.65, 0.22, 0.5});
  const auto right = shelves.reach(robot, {0.65, -0.22, 0.5});
  ASSERT_FALSE(left.empty());
  const JointPath path = plan_path(robot, left.front(), right);
  ASSERT_TRUE(path.found());
  const BlendedTrajectory trajectory(robot.chain(), BlendedPath(robot, path.waypoints, 0.2),
                                     Eigen::VectorXd::Constant(7, 5.0));
  EXPECT_LT(
      trajectory.duration(),
      Trajectory(robot.chain(), path.waypoints, Eigen::VectorXd::Constant(7, 5.0)).duration());
  for (int i = 0; i <= 2000; ++i) {
    const Positions q = trajectory.at(trajectory.duration() * i / 2000).position;
    ASSERT_FALSE(shelves.oracle.collides(shelves.chain, q));
    ASSERT_TRUE(shelves.chain.within_limits(q));
  }
}

TEST(BlendedTrajectory, RefusesWhatItCannotTime) {
  const robot::KinematicChain arm = robot::kr5();
  const Eigen::VectorXd most = Eigen::VectorXd::Constant(6, 8.0);
  const BlendedPath path({posed(0, 0), posed(0, 1)}, 0.1);
  EXPECT_THROW(BlendedPath({}, 0.1), std::invalid_argument);
  EXPECT_THROW(BlendedPath({posed(0, 0)}, -1), std::invalid_argument);
  EXPECT_THROW(BlendedPath({posed(0, std::nan(""))}, 0.1), std::invalid_argument);
  EXPECT_THROW(BlendedPath({posed(0, 0), Positions::Zero(7)}, 0.1), std::invalid_argument);
  const Shelves shelves;
  const RobotInWorld seven = shelves.in_world();
  EXPECT_THROW(BlendedPath(seven, {posed(0, 0)}, 0.1), std::invalid_argument);
  EXPECT_THROW(BlendedPath(seven, {Positions::Zero(7)}, 0.1, 0), std::invalid_argument);
  EXPECT_THROW(BlendedTrajectory(robot::pa10(), path, Eigen::VectorXd::Constant(7, 1)),
               std::invalid_argument);
  EXPECT_THROW(BlendedTrajectory(arm, path, most, 0), std::invalid_argument);
  EXPECT_THROW(BlendedTrajectory(arm, path, most, 1, 0), std::invalid_argument);
  EXPECT_THROW(BlendedTrajectory(arm, path, Eigen::VectorXd::Zero(6)), std::invalid_argument);
  EXPECT_THROW(BlendedTrajectory(arm, path, Eigen::VectorXd::Constant(7, 1)),
               std::invalid_argument);
}

}  // namespace
}  // namespace prehend::motion

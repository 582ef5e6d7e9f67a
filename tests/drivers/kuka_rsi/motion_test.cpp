// What of trajectories becomes set points, and what is refused.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <stdexcept>

#include "tests/drivers/kuka_rsi/virtual_robot.h"

namespace prehend::drivers::kuka_rsi {
namespace {

using ::testing::HasSubstr;

constexpr double kCycle = 0.012;

std::string refusal(const simulation::ArmTrajectory& trajectory, const Axes& start,
                    const Limits& limits) {
  try {
    set_points_of(trajectory, start, home_of_kuka(), limits, kCycle);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "taken";
}

Axes with_a1(double a1) {
  Axes q = home_of_kuka();
  q[0] = a1;
  return q;
}

TEST(SetPoints, AreTheTrajectoryAtTheCycles) {
  const auto points = set_points_of(way(home_of_kuka(), with_a1(1), 1.2), home_of_kuka(),
                                    home_of_kuka(), limits_of_kuka(), kCycle);
  ASSERT_EQ(points.size(), 100u);
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double s = static_cast<double>(k + 1) / 100;
    EXPECT_NEAR(points[k][0], s * s * s * (10 + s * (-15 + 6 * s)), 1e-9);
  }
}

TEST(SetPoints, TakeUpWhatTheStartIsOffSmoothly) {
  Axes start = home_of_kuka();
  start[3] += 0.02;
  const auto points = set_points_of(way(home_of_kuka(), with_a1(0.002), 0.05), start,
                                    home_of_kuka(), limits_of_kuka(), kCycle);
  EXPECT_NEAR(points.front()[3], start[3], 1e-3);
  EXPECT_NEAR(points.back()[3], home_of_kuka()[3], 1e-12);
}

TEST(SetPoints, BeyondLimitsAreRefusedByName) {
  const Limits limits = limits_of_kuka();
  const Axes home = home_of_kuka();
  EXPECT_THAT(refusal(way(home, with_a1(3), 3), home, limits),
              AllOf(HasSubstr("axis_1"), HasSubstr("limit of position")));
  EXPECT_THAT(refusal(way(home, with_a1(2), 0.3), home, limits),
              AllOf(HasSubstr("axis_1"), HasSubstr("faster")));
  EXPECT_THAT(refusal(way(home, with_a1(0.5), 0.3), home, limits), HasSubstr("gains speed"));
  simulation::ArmTrajectory lines = way(home, with_a1(0.5), 2);
  lines.has_velocity = lines.has_acceleration = false;  // begins with a jerk
  EXPECT_THAT(refusal(lines, home, limits), HasSubstr("gains speed"));
  Limits::Options narrow = wide_limits();
  narrow.largest_correction = 0.3;
  EXPECT_THAT(refusal(way(home, with_a1(0.5), 2), home, limits_of_kuka(narrow)),
              HasSubstr("largest_correction"));
}

TEST(SetPoints, OutOfTheToolsBoxAreRefused) {
  Limits::Options options = wide_limits();
  const Eigen::Vector3d p_W = limits_of_kuka().tool_at(home_of_kuka());
  options.box = ToolBox{p_W - Eigen::Vector3d(0.3, 0.1, 0.3), p_W + Eigen::Vector3d(0.3, 0.1, 0.3)};
  const Limits limits = limits_of_kuka(options);
  EXPECT_THAT(refusal(way(home_of_kuka(), with_a1(0.5), 100), home_of_kuka(), limits),
              AllOf(HasSubstr("the tool at ("), HasSubstr("leaves its box")));
  EXPECT_EQ(refusal(way(home_of_kuka(), with_a1(0.1), 2), home_of_kuka(), limits), "taken");
}

// The set points stay inside, but two axes that hold each other's way up would brake apart: A1
// turns the tool to the side and back at once with A6 ... so each axis' own braking is looked at.
TEST(SetPoints, FromWhichTheToolCouldNotStopInsideAreRefused) {
  Limits::Options options = wide_limits();
  const Eigen::Vector3d p_W = limits_of_kuka().tool_at(home_of_kuka());
  // A2 leans forward while A3 draws back, both fast: the tool goes up and down by little.
  Axes to = home_of_kuka();
  to[1] += 0.6;
  to[2] -= 0.6;
  const simulation::ArmTrajectory both = way(home_of_kuka(), to, 0.62);
  double most = p_W.x(), least_z = p_W.z();
  for (const Axes& q :
       set_points_of(both, home_of_kuka(), home_of_kuka(), limits_of_kuka(options), kCycle)) {
    most = std::max(most, limits_of_kuka().tool_at(q).x());
    least_z = std::min(least_z, limits_of_kuka().tool_at(q).z());
  }
  const auto taken_with_room = [&](double room) {
    options.box = ToolBox{{-3, -3, -3}, {most + room, 3, 3}};
    return refusal(way(home_of_kuka(), to, 0.62), home_of_kuka(), limits_of_kuka(options));
  };
  EXPECT_EQ(taken_with_room(0.2), "taken");
  EXPECT_THAT(taken_with_room(-0.01), HasSubstr("box"));
}

TEST(Braking, NeverPassesALimitThatTheMotionKept) {
  const Limits limits = limits_of_kuka();
  std::mt19937 random(1);
  std::uniform_real_distribution<double> share(0, 1);
  for (int i = 0; i < 2000; ++i) {
    Axes q{}, v{};
    for (std::size_t k = 0; k < kAxes; ++k) {
      q[k] = limits.lower(k) + share(random) * (limits.upper(k) - limits.lower(k));
      const double most = std::sqrt(2 * 12 * (limits.upper(k) - q[k]));
      v[k] = std::min(most, limits.speed(k)) * share(random);
    }
    for (int step = 0; step < 200; ++step) {
      limits.brake(q, v, kCycle);
      for (std::size_t k = 0; k < kAxes; ++k) ASSERT_LE(q[k], limits.upper(k) + 1e-12);
    }
    for (const double left : v) ASSERT_EQ(left, 0);
  }
}

TEST(RsiLimits, OfAnotherArmAreRefused) {
  const robot::Platform stage = robot::read_platform("config/robots/stage_pg70.yaml");
  EXPECT_THROW(Limits(stage.arm_chain(), {}), std::invalid_argument);
  Limits::Options options;
  options.speed_share = 0;
  EXPECT_THROW(Limits(kuka().arm_chain(), options), std::invalid_argument);
  options = {};
  options.box = ToolBox{};
  EXPECT_THROW(Limits(kuka().arm_chain(), options), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::drivers::kuka_rsi

#include "prehend/control/joint_trajectory.h"

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

namespace prehend::control {
namespace {

// Two joints: one goes 0.3 rad in 0.4 s, smoothly, the other stays.
JointTrajectory quick_path() {
  JointTrajectory path;
  path.joints = {"a", "b"};
  constexpr double kWay = 0.3, kDuration = 0.4;
  for (int i = 0; i <= 20; ++i) {
    const double s = i / 20.0;
    path.points.push_back({s * kDuration,
                           {kWay * s * s * s * (10 + s * (6 * s - 15)), 1.0},
                           {kWay * 30 * s * s * (1 - s) * (1 - s) / kDuration, 0.0},
                           {kWay * 60 * s * (1 - s) * (1 - 2 * s) / (kDuration * kDuration), 0.0}});
  }
  return path;
}

double most(const JointTrajectory& path, std::vector<double> JointTrajectory::Point::*values,
            std::size_t k) {
  double result = 0;
  for (const auto& point : path.points) result = std::max(result, std::abs((point.*values)[k]));
  return result;
}

TEST(NearestOnPath, IsOnItsLinesOrBesideThem) {
  const JointTrajectory path{{"a", "b"},
                             {{0, {0, 0}, {}, {}}, {2, {1, 0}, {}, {}}, {4, {1, 2}, {}, {}}}};
  const PlaceOnPath first = nearest_on(path, {"a", "b"}, {0.5, 0.1});
  EXPECT_NEAR(first.share, 0.25, 1e-12);
  EXPECT_NEAR(first.off, 0.1, 1e-12);
  const PlaceOnPath second = nearest_on(path, {"b", "a"}, {1, 1});
  EXPECT_NEAR(second.share, 0.75, 1e-12);
  EXPECT_NEAR(second.off, 0, 1e-12);
  EXPECT_NEAR(nearest_on(path, {"a", "b"}, {1, 5}).share, 1, 1e-12);
  EXPECT_NEAR(nearest_on(path, {"a", "b"}, {1, 5}).off, 3, 1e-12);
  EXPECT_THROW(nearest_on(path, {"a"}, {1}), std::invalid_argument);
  EXPECT_THROW(nearest_on({}, {"a"}, {1}), std::invalid_argument);
}

TEST(WayOfPath, IsItsLengthsShare) {
  const JointTrajectory corner{{"a", "b"},
                               {{0, {0, 0}, {}, {}}, {2, {1, 0}, {}, {}}, {4, {1, 3}, {}, {}}}};
  EXPECT_NEAR(way_gone(corner, 0.25), 0.125, 1e-12);
  EXPECT_NEAR(way_gone(corner, 0.75), 0.625, 1e-12);
  EXPECT_NEAR(time_of_way(corner, 0.125), 0.25, 1e-12);
  EXPECT_NEAR(time_of_way(corner, 0.625), 0.75, 1e-12);
  for (const double end : {0.0, 1.0}) {
    EXPECT_EQ(way_gone(corner, end), end);
    EXPECT_EQ(time_of_way(corner, end), end);
  }
  const JointTrajectory smooth = quick_path();
  for (int i = 1; i < 20; ++i) {
    const double s = i / 20.0, way = s * s * s * (10 + s * (6 * s - 15));
    EXPECT_NEAR(way_gone(smooth, s), way, 1e-12);
    EXPECT_NEAR(time_of_way(smooth, way), s, 1e-12);
  }
  const JointTrajectory still{{"a"}, {{0, {1}, {}, {}}, {2, {1}, {}, {}}}};
  EXPECT_EQ(way_gone(still, 0.5), 1);
  EXPECT_EQ(time_of_way(still, 0.5), 0);
}

TEST(JoinedPath, FromWhereThePlanBeginsIsThePlan) {
  const JointTrajectory path = quick_path(), same = joined(path, {"b", "a"}, {1, 0}, 0.5);
  for (std::size_t i = 0; i < path.points.size(); ++i) {
    EXPECT_EQ(same.points[i].time, path.points[i].time);
    EXPECT_EQ(same.points[i].position, path.points[i].position);
    EXPECT_EQ(same.points[i].velocity, path.points[i].velocity);
  }
}

// An arm that contact had stopped was asked for ten times the speed of its plan, fell behind, and
// gave up ("joint 'arm_axis_2' is 0.0503 off the path").
TEST(JoinedPath, AsksNoJointForMoreThanThePlanOrALittle) {
  const JointTrajectory path = quick_path(), from = joined(path, {"a", "b"}, {-0.2, 1.25}, 0.5);
  EXPECT_EQ(from.points.front().position, (std::vector<double>{-0.2, 1.25}));
  EXPECT_NEAR(from.points.back().position[0], 0.3, 1e-12);
  EXPECT_NEAR(from.points.back().position[1], 1, 1e-12);
  const auto speed = &JointTrajectory::Point::velocity;
  const auto acceleration = &JointTrajectory::Point::acceleration;
  for (const std::size_t k : {0u, 1u}) {
    EXPECT_LE(most(from, speed, k), std::max(0.5, most(path, speed, k)) * (1 + 1e-9));
    EXPECT_LE(most(from, acceleration, k), std::max(2.5, most(path, acceleration, k)) * (1 + 1e-9));
  }
  EXPECT_GT(from.duration(), path.duration());
  // Velocities are those of the positions.
  for (std::size_t i = 1; i < from.points.size(); ++i) {
    const auto& p = from.points[i - 1];
    const auto& q = from.points[i];
    const double mean = 0.5 * (p.velocity[1] + q.velocity[1]);
    EXPECT_NEAR((q.position[1] - p.position[1]) / (q.time - p.time), mean, 0.02);
  }
}

TEST(DisplacedPath, IsAsFarBesideThePlanAllAlong) {
  const JointTrajectory path = quick_path(), beside = displaced(path, {"b", "a"}, {1.1, -0.2}, 0.5);
  ASSERT_EQ(beside.points.size(), path.points.size());
  for (std::size_t i = 0; i < path.points.size(); ++i) {
    EXPECT_EQ(beside.points[i].time, path.points[i].time);
    EXPECT_NEAR(beside.points[i].position[0], path.points[i].position[0] - 0.2, 1e-12);
    EXPECT_NEAR(beside.points[i].position[1], path.points[i].position[1] + 0.1, 1e-12);
    EXPECT_EQ(beside.points[i].velocity, path.points[i].velocity);
  }
  EXPECT_THROW(displaced(path, {"b", "a"}, {1, std::nan("")}, 0.5), std::invalid_argument);
}

TEST(JoinedPath, RefusesWhatIsFarOff) {
  EXPECT_THROW(joined(quick_path(), {"a", "b"}, {0.6, 1}, 0.5), std::invalid_argument);
  EXPECT_THROW(joined(quick_path(), {"a"}, {0}, 0.5), std::invalid_argument);
  EXPECT_THROW(joined({}, {"a"}, {0}, 0.5), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::control

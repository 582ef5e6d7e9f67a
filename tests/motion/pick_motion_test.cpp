#include "prehend/motion/pick_motion.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "tests/motion/pick_scene.h"

namespace prehend::motion {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;
using robot::Positions;
using ::testing::HasSubstr;

PickMotion plan(const PickScene& scene, const PickOptions& options = {}) {
  return plan_pick(scene.in_world(), scene.inverse(), scene.task, options);
}

const PickRejection* rejection(const PickMotion& motion, PickFilter filter) {
  const auto found = std::find_if(motion.rejections.begin(), motion.rejections.end(),
                                  [filter](const auto& r) { return r.filter == filter; });
  return found == motion.rejections.end() ? nullptr : &*found;
}

int count(const PickMotion& motion, PickFilter filter) {
  const PickRejection* found = rejection(motion, filter);
  return found ? found->count : 0;
}

/// Boxes to the left and right of the object, and one that the object has to be carried round.
PickScene cluttered(const std::string& arm) {
  PickScene scene(arm, {0.5, 0.2, 0});
  scene.add("left", at(0.5, 0.4, 0.1), {0.1, 0.1, 0.2});
  scene.add("right", at(0.5, -0.02, 0.15), {0.2, 0.05, 0.3});
  scene.task.X_BO_places = {at(0.45, -0.25, 0.081)};
  scene.grasps_from_above();
  scene.grasps_from_the_side(0);
  scene.task.start[0] = -1;
  return scene;
}

class PlanPick : public ::testing::TestWithParam<const char*> {};

TEST_P(PlanPick, PicksCarriesAndPlacesAmongObstacles) {
  const PickScene scene = cluttered(GetParam());
  PickOptions options;
  options.acceleration = Eigen::VectorXd::Constant(scene.chain.size(), 5.0);
  const PickMotion motion = plan(scene, options);
  ASSERT_TRUE(motion.found()) << motion.problem;
  std::vector<SegmentKind> kinds;
  for (const PickSegment& segment : motion.segments) kinds.push_back(segment.kind);
  using enum SegmentKind;
  EXPECT_THAT(kinds, testing::ElementsAre(kReach, kApproach, kLift, kCarry, kPlace, kRetreat));
  EXPECT_EQ(scene.problem(motion), "");
  EXPECT_GT(motion.goals, 1);
  // The tip goes where the grasp says, straight, up, and to the place.
  const PickGrasp& grasp = scene.task.grasps[static_cast<std::size_t>(motion.grasp)];
  const auto tip = [&](std::size_t segment, bool end) {
    const auto& way = motion.segments[segment].waypoints;
    return scene.chain.forward(end ? way.back() : way.front());
  };
  EXPECT_LT(robot::difference(tip(1, true), grasp.X_BT), 1e-6);
  EXPECT_LT(
      (tip(1, false).translation() + 0.15 * grasp.approach_direction_B - grasp.X_BT.translation())
          .norm(),
      1e-6);
  EXPECT_NEAR(tip(2, true).translation().z(), grasp.X_BT.translation().z() + 0.1, 1e-6);
  const RigidTransform X_BO = tip(4, true) * grasp.X_BT.inverse() * scene.task.object.X_BO;
  EXPECT_LT(robot::difference(X_BO, scene.task.X_BO_places[0]), 1e-6);
  for (const PickSegment& segment : motion.segments) {
    ASSERT_TRUE(segment.trajectory);
    EXPECT_EQ(segment.trajectory->at(0).position, segment.waypoints.front());
    EXPECT_EQ(segment.trajectory->at(1e9).position, segment.waypoints.back());
  }
  // Every grasp is accounted for, and the same again gives the same.
  const PickMotion again = plan(scene, options);
  EXPECT_EQ(again.grasp, motion.grasp);
  for (std::size_t i = 0; i < motion.segments.size(); ++i) {
    ASSERT_EQ(again.segments[i].waypoints.size(), motion.segments[i].waypoints.size());
    for (std::size_t k = 0; k < motion.segments[i].waypoints.size(); ++k) {
      EXPECT_EQ(again.segments[i].waypoints[k], motion.segments[i].waypoints[k]);
    }
  }
}

// Beside something as high as itself, and by what is predicted 4 mm into it: out of there at once
// is no way, and no reason to leave it.
TEST_P(PlanPick, WhatStandsBesideOthersIsLiftedOverThem) {
  const auto risen = [](double gap, const char* arm) {
    PickScene scene(arm, {0.5, 0.2, 0});
    scene.add("beside", at(0.5, 0.2 + 0.025 + gap + 0.025, 0.055), {0.05, 0.05, 0.11});
    scene.task.X_BO_places = {at(0.45, -0.25, 0.081)};
    scene.grasps_from_above();
    const PickMotion motion = plan(scene);
    EXPECT_TRUE(motion.found()) << gap << ": " << motion.problem;
    if (!motion.found()) return 0.0;
    const auto& lift = motion.segments[2].waypoints;
    return (scene.chain.forward(lift.back()).translation() -
            scene.chain.forward(lift.front()).translation())
        .z();
  };
  EXPECT_NEAR(risen(0.1, GetParam()), 0.1, 1e-6);
  EXPECT_NEAR(risen(-0.004, GetParam()), 0.15, 1e-6);
}

// An arm that put things down at 0.7 m/s pressed with 600 N before it stood.
TEST_P(PlanPick, StraightSegmentsKeepTheToolsSpeed) {
  const PickScene scene = cluttered(GetParam());
  PickOptions options;
  options.acceleration = Eigen::VectorXd::Constant(scene.chain.size(), 10);
  options.straight_speed = 0.1;
  const PickMotion motion = plan(scene, options);
  ASSERT_TRUE(motion.found()) << motion.problem;
  const auto fastest_of = [&](const PickSegment& segment) {  // m/s
    constexpr double kStep = 0.002;                          // s
    double fastest = 0;
    for (double time = 0; time < segment.trajectory->duration(); time += kStep) {
      const Eigen::Vector3d way =
          scene.chain.forward(segment.trajectory->at(time + kStep).position).translation() -
          scene.chain.forward(segment.trajectory->at(time).position).translation();
      fastest = std::max(fastest, way.norm() / kStep);
    }
    return fastest;
  };
  for (const PickSegment& segment : motion.segments) {
    const double fastest = fastest_of(segment);
    if (segment.kind == SegmentKind::kReach || segment.kind == SegmentKind::kCarry) {
      EXPECT_GT(fastest, 0.2) << to_string(segment.kind);
    } else {
      EXPECT_LT(fastest, 0.11) << to_string(segment.kind);
      EXPECT_GT(fastest, 0.05) << to_string(segment.kind);
    }
    EXPECT_EQ(segment.trajectory->at(1e9).position, segment.waypoints.back());
  }
  options.guarded_speed = 0.03;
  for (const PickSegment& segment : plan(scene, options).segments) {
    const bool is_guarded = segment.kind == SegmentKind::kApproach;
    if (is_guarded) EXPECT_LT(fastest_of(segment), 0.033) << to_string(segment.kind);
    if (!is_guarded) EXPECT_GT(fastest_of(segment), 0.05) << to_string(segment.kind);
  }
}

TEST_P(PlanPick, OtherSeedsTouchNothingEither) {
  const PickScene scene = cluttered(GetParam());
  PickOptions options;
  for (std::uint64_t seed = 2; seed < 8; ++seed) {
    options.path.seed = seed;
    const PickMotion motion = plan(scene, options);
    ASSERT_TRUE(motion.found()) << motion.problem;
    EXPECT_EQ(scene.problem(motion), "");
  }
}

// What a budget leaves is a whole motion that touches nothing, or none and the reason.
TEST_P(PlanPick, StoppedAtAnyMomentWhatItHasIsValid) {
  const PickScene scene = cluttered(GetParam());
  PickOptions options;
  options.acceleration = Eigen::VectorXd::Constant(scene.chain.size(), 5.0);
  int found = 0;
  for (const double budget : {1e-5, 1e-4, 3e-4, 1e-3, 3e-3, 0.01, 0.03, 0.1, 60.0}) {
    options.budget = budget;
    const PickMotion motion = plan(scene, options);
    EXPECT_EQ(scene.problem(motion), "") << budget;
    if (!motion.found()) {
      EXPECT_THAT(motion.problem, HasSubstr("budget")) << budget;
      int accounted = 0;
      for (const PickRejection& rejected : motion.rejections) accounted += rejected.count;
      EXPECT_EQ(accounted, 16) << budget;
      continue;
    }
    ++found;
    EXPECT_EQ(motion.segments.size(), 6u) << budget;
    for (const PickSegment& segment : motion.segments) EXPECT_TRUE(segment.trajectory) << budget;
  }
  EXPECT_GE(found, 1);
}

TEST_P(PlanPick, StandsBesideAnotherObjectAndOnATiltedTable) {
  PickScene scene(GetParam(), {0.5, 0.1, 0.04});
  scene.add("beside", at(0.5, 0.1 + 0.05 + 0.005, 0.12), {0.05, 0.05, 0.16});  // 5 mm away
  RigidTransform slope = at(0.5, 0.1, 0.02);
  slope.rotate(Eigen::AngleAxisd(0.1, Vector3d::UnitX()));
  scene.add("slope", slope, {0.3, 0.3, 0.035});
  scene.grasps_from_above();
  const PickMotion motion = plan(scene);
  ASSERT_TRUE(motion.found()) << motion.problem;
  EXPECT_EQ(motion.segments.size(), 3u);
  EXPECT_EQ(scene.problem(motion), "");
}

TEST_P(PlanPick, StartsAtALimit) {
  PickScene scene = cluttered(GetParam());
  scene.task.start[scene.chain.size() - 1] = scene.chain.joints().back().upper;
  const PickMotion motion = plan(scene);
  ASSERT_TRUE(motion.found()) << motion.problem;
  EXPECT_EQ(scene.problem(motion), "");
}

TEST_P(PlanPick, TheLedgerSaysWhereGraspsFell) {
  PickScene scene(GetParam(), {0.5, 0.1, 0});
  scene.grasps_from_above();
  const std::vector<PickGrasp> good = scene.task.grasps;
  // Out of reach, by 2 m and by less.
  for (const double x : {2.5, 1.6}) {
    PickGrasp far = good.front();
    far.X_BT.translation().x() = x;
    scene.task.grasps.push_back(far);
  }
  PickGrasp sunk = good.front();
  sunk.X_BT.translation().z() = 0.01;  // fingers in the table
  scene.task.grasps.push_back(sunk);
  PickOptions options;
  options.goals = 1000;
  const PickMotion motion = plan(scene, options);
  ASSERT_TRUE(motion.found()) << motion.problem;
  EXPECT_LT(motion.grasp, 8);
  EXPECT_EQ(count(motion, PickFilter::kOutOfReach), 2);
  EXPECT_THAT(rejection(motion, PickFilter::kOutOfReach)->nearest_miss, HasSubstr("out of reach"));
  EXPECT_EQ(count(motion, PickFilter::kGraspTouches), 1);
  EXPECT_THAT(rejection(motion, PickFilter::kGraspTouches)->nearest_miss, HasSubstr("'table'"));
  // The far ones alone: the nearer one is the nearest miss.
  scene.task.grasps.erase(scene.task.grasps.begin(), scene.task.grasps.begin() + 8);
  scene.task.grasps.pop_back();
  const PickMotion none = plan(scene, options);
  EXPECT_FALSE(none.found());
  EXPECT_EQ(none.grasp, -1);
  EXPECT_THAT(none.problem, HasSubstr("none of 2 grasps can be used: 2 out of reach"));
  scene.task.grasps.erase(scene.task.grasps.begin());
  EXPECT_EQ(plan(scene, options).rejections.front().nearest_miss,
            none.rejections.front().nearest_miss);
}

TEST_P(PlanPick, TheLedgerNamesWhatIsInTheWay) {
  PickScene roofed(GetParam(), {0.5, 0.1, 0});
  roofed.grasps_from_above();
  PickScene open = roofed;
  roofed.add("roof", at(0.5, 0.1, 0.55), {0.4, 0.4, 0.02});
  const PickMotion blocked = plan(roofed);
  EXPECT_FALSE(blocked.found());
  EXPECT_EQ(count(blocked, PickFilter::kApproach) + count(blocked, PickFilter::kGraspTouches) +
                count(blocked, PickFilter::kBeyondLimits) +
                count(blocked, PickFilter::kPregraspTouches),
            8);
  EXPECT_THAT(blocked.problem, HasSubstr("'roof'"));
  // The place in the table, and a place out of reach.
  open.task.X_BO_places = {at(0.5, -0.2, 0.03)};
  const PickMotion sunk = plan(open);
  EXPECT_EQ(count(sunk, PickFilter::kPlace), 8);
  EXPECT_THAT(sunk.problem, HasSubstr("the object would be"));
  open.task.X_BO_places = {at(3, 0, 0.1)};
  EXPECT_THAT(plan(open).problem, HasSubstr("cannot be placed (nearest: out of reach"));
  // A start among walls.
  open.task.X_BO_places.clear();
  PickOptions few;
  few.path.iterations = 1;
  PickScene walled = cluttered(GetParam());
  const PickMotion motion = plan(walled, few);
  if (!motion.found()) {
    EXPECT_GT(count(motion, PickFilter::kPath), 0);
    EXPECT_THAT(motion.problem, HasSubstr("no path"));
  }
}

// Regression: whichever grasp the search reached first was taken, however unlikely it was to hold.
TEST_P(PlanPick, TakesTheLikeliestGraspAndNotTheNearest) {
  PickScene scene(GetParam(), {0.5, 0.1, 0});
  scene.grasps_from_above();
  PickGrasp poor = scene.task.grasps.back(), good = scene.task.grasps.front();
  scene.task.grasps = {poor};
  const PickMotion there = plan(scene);
  ASSERT_TRUE(there.found()) << there.problem;
  // The arm stands where the approach of the poor one begins.
  scene.task.start = there.segments[0].waypoints.back();
  poor.expected_success = 0.07;
  good.expected_success = 0.75;
  scene.task.grasps = {poor, good};
  const PickMotion best = plan(scene);
  ASSERT_TRUE(best.found()) << best.problem;
  EXPECT_EQ(best.grasp, 1);
  EXPECT_EQ(scene.problem(best), "");
  EXPECT_EQ(count(best, PickFilter::kNotTried), 1);
  // Within the trade the path decides.
  PickOptions options;
  options.success_for_path = 0.7;
  EXPECT_EQ(plan(scene, options).grasp, 0);
  scene.task.grasps[0].expected_success = 0.71;
  EXPECT_EQ(plan(scene).grasp, 0);
  options.success_for_path = 0;
  EXPECT_EQ(plan(scene, options).grasp, 1);
  // The likeliest cannot be executed: the next one is.
  scene.task.grasps[0].expected_success = 0.07;
  PickGrasp far = good;
  far.X_BT.translation().x() = 2.5;
  far.expected_success = 1;
  scene.task.grasps.push_back(far);
  const PickMotion second = plan(scene);
  EXPECT_EQ(second.grasp, 1) << second.problem;
  EXPECT_EQ(count(second, PickFilter::kOutOfReach), 1);
  EXPECT_EQ(count(second, PickFilter::kNotTried), 1);
}

TEST_P(PlanPick, TheFirstPlaceThatIsReachedIsTaken) {
  PickScene scene = cluttered(GetParam());
  const geometry::RigidTransform good = scene.task.X_BO_places[0];
  scene.task.X_BO_places = {at(3, 0, 0.081), at(0.5, 0.4, 0.081), good, at(0.4, -0.3, 0.081)};
  const PickMotion motion = plan(scene);
  ASSERT_TRUE(motion.found()) << motion.problem;
  EXPECT_EQ(motion.place, 2) << "out of reach; in the box 'left'; free";
  EXPECT_EQ(scene.problem(motion), "");
  const PickGrasp& grasp = scene.task.grasps[static_cast<std::size_t>(motion.grasp)];
  const RigidTransform X_BO = scene.chain.forward(motion.segments[4].waypoints.back()) *
                              grasp.X_BT.inverse() * scene.task.object.X_BO;
  EXPECT_LT(robot::difference(X_BO, good), 1e-6);
}

TEST_P(PlanPick, AnswersBadTasksWithTheReason) {
  PickScene scene = cluttered(GetParam());
  PickScene none = scene;
  none.task.grasps.clear();
  EXPECT_EQ(plan(none).problem, "there are no grasps");
  PickScene inside = scene;
  inside.add("around", at(0, 0, 0.7), {1, 1, 1});
  EXPECT_THAT(plan(inside).problem, HasSubstr("at the start, "));
  PickScene beyond = scene;
  beyond.task.start[1] = 4;
  EXPECT_THAT(plan(beyond).problem, HasSubstr("is beyond"));
  // A budget that is over before it starts.
  PickOptions hurried;
  hurried.budget = 1e-9;
  const PickMotion late = plan(scene, hurried);
  EXPECT_FALSE(late.found());
  EXPECT_EQ(count(late, PickFilter::kNotTried), 16);
  EXPECT_THAT(late.problem, HasSubstr("budget"));
  const auto refused = [&](auto change) {
    PickScene other = scene;
    PickOptions options;
    change(other.task, options);
    EXPECT_THROW(plan(other, options), std::invalid_argument);
  };
  refused([](PickTask& task, PickOptions&) { task.start = Positions::Zero(3); });
  refused([](PickTask& task, PickOptions&) { task.start[0] = std::nan(""); });
  refused([](PickTask& task, PickOptions&) { task.up_B = {0, 0, 2}; });
  refused([](PickTask& task, PickOptions&) { task.grasps[0].approach_direction_B.setZero(); });
  refused([](PickTask& task, PickOptions&) { task.grasps[0].pregrasp_distance = 0; });
  refused([](PickTask& task, PickOptions&) { task.grasps[0].X_BT(0, 3) = std::nan(""); });
  refused([](PickTask& task, PickOptions&) { task.X_BO_places[0](0, 3) = std::nan(""); });
  refused([](PickTask& task, PickOptions&) { task.grasps[0].expected_success = 1.1; });
  refused([](PickTask&, PickOptions& options) { options.success_for_path = -0.1; });
  refused([](PickTask&, PickOptions& options) { options.lift_height = 0; });
  refused([](PickTask&, PickOptions& options) { options.goals = 0; });
  refused([](PickTask&, PickOptions& options) { options.budget = -1; });
  refused([](PickTask&, PickOptions& options) { options.acceleration = Eigen::VectorXd::Ones(2); });
}

INSTANTIATE_TEST_SUITE_P(Arms, PlanPick, ::testing::Values("kr5", "pa10"));

TEST(SuccessTiers, HoldWhatIsWithinTheWidthOfTheirBest) {
  using Tiers = std::vector<std::vector<std::size_t>>;
  EXPECT_EQ(success_tiers({}, 0.05), Tiers{});
  EXPECT_EQ(success_tiers({0.5, 0.5, 0.5}, 0), (Tiers{{0, 1, 2}}));
  EXPECT_EQ(success_tiers({0.07, 0.75, 0.71, 0.69}, 0.05), (Tiers{{1, 2}, {3}, {0}}));
  EXPECT_EQ(success_tiers({0.07, 0.75, 0.71, 0.69}, 1), (Tiers{{1, 2, 3, 0}}));
}

TEST(CoverConvexPieces, HoldsTheSurfaceAndSaysHowFarItReaches) {
  const geometry::TriangleMesh ball = geometry::make_sphere(0.05, 24);
  const Vector3d size(0.1, 0.02, 0.2);
  std::mt19937_64 random(1);
  for (const double resolution : {0.01, 0.03, 0.5}) {
    const BallCover box = cover_convex_pieces({geometry::make_box(size)}, resolution);
    EXPECT_LE(box.overshoot, 0.87 * resolution);
    const BallCover round = cover_convex_pieces({ball}, resolution);
    const auto held = [](const BallCover& cover, const Vector3d& p) {
      return std::any_of(cover.balls.begin(), cover.balls.end(), [&p](const Ball& b) {
        return (b.center - p).norm() <= b.radius + 1e-7;  // the hull is in single precision
      });
    };
    for (int n = 0; n < 3000; ++n) {
      Vector3d p(robot::uniform(random), robot::uniform(random), robot::uniform(random));
      p = (2 * p - Vector3d::Ones()) / 2;
      const int side = n % 3;
      p[side] = std::copysign(0.5, p[side]);
      ASSERT_TRUE(held(box, p.cwiseProduct(size)));
      const auto& t = ball.triangles[static_cast<std::size_t>(n) % ball.triangles.size()];
      const auto v = [&](int k) { return ball.vertices[static_cast<std::size_t>(t[k])]; };
      ASSERT_TRUE(held(round, (v(0) + v(1) + v(2)) / 3));
    }
    for (const Ball& b : box.balls) {
      const Vector3d beyond = b.center.cwiseAbs() - size / 2;
      const double distance = beyond.cwiseMax(0).norm() + std::min(0.0, beyond.maxCoeff());
      EXPECT_LE(distance + b.radius, box.overshoot + 1e-6);
    }
  }
  EXPECT_THROW(cover_convex_pieces({ball}, 0), std::invalid_argument);
  EXPECT_THROW(cover_convex_pieces({ball}, 1e-4), geometry::InputError);
  EXPECT_THROW(cover_convex_pieces({geometry::TriangleMesh{}}), geometry::InputError);
}

}  // namespace
}  // namespace prehend::motion

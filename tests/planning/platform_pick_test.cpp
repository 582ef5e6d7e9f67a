#include "prehend/planning/platform_pick.h"

#include <algorithm>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "prehend/robot/inverse_kinematics.h"
#include "prehend/robot/link_mesh.h"
#include "prehend/robot/placed_links.h"
#include "prehend/surface/model.h"

namespace prehend::planning {
namespace {

using geometry::RigidTransform;
using geometry::TriangleMesh;

TriangleMesh box_at(const Eigen::Vector3d& size, const Eigen::Vector3d& center) {
  return geometry::transformed(geometry::make_box(size),
                               geometry::make_transform(Eigen::Quaterniond::Identity(), center));
}

// From above, the hand closing along the world's y axis.
PlatformGrasp from_above(const robot::Platform& platform, const Eigen::Vector3d& p_WG) {
  PlatformGrasp grasp;
  grasp.X_WG.linear() << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  grasp.X_WG.linear().col(0) = grasp.X_WG.linear().col(1).cross(grasp.X_WG.linear().col(2));
  grasp.X_WG.translation() = p_WG;
  grasp.preshape = platform.hand.preshapes.front().name;
  return grasp;
}

class PlatformPickTest : public ::testing::TestWithParam<const char*> {
 protected:
  PlatformPickTest() : platform(robot::read_platform(std::string("config/robots/") + GetParam())) {
    scene.object_pieces_W = {box_at({0.04, 0.04, 0.16}, {0, 0, 0.08})};
  }
  robot::Positions home() const { return platform.home("home").arm; }

  robot::Platform platform;
  PlatformScene scene;
};

TEST_P(PlatformPickTest, ReachesLiftsAndPuts) {
  PlatformPickOptions options;
  options.moves_W = {{0, 0.15, 0}};
  const auto pick =
      plan_platform_pick(platform, home(), {from_above(platform, {0, 0, 0.14})}, scene, options);
  ASSERT_TRUE(pick.motion.found()) << pick.motion.problem;
  EXPECT_EQ(pick.grasp, 0);
  ASSERT_EQ(pick.motion.segments.size(), 6u);
  EXPECT_EQ(pick.motion.segments.front().waypoints.front(), home());
  // The tool is at the grasp when the approach ends, and where the object goes when it is placed.
  const robot::KinematicChain chain = platform.arm_chain();
  const auto& preshape = platform.hand.preshapes.front();
  const auto tool = [&](const motion::PickSegment& segment) {
    return platform.X_WB * chain.forward(segment.waypoints.back()) * platform.X_FG(preshape);
  };
  EXPECT_LT((tool(pick.motion.segments[1]).translation() - Eigen::Vector3d(0, 0, 0.14)).norm(),
            1e-4);
  EXPECT_LT((tool(pick.motion.segments[4]).translation() - Eigen::Vector3d(0, 0.15, 0.14)).norm(),
            1e-4);
}

/// A camera at one side of the table that looks at its middle.
ViewingCamera side_camera() {
  ViewingCamera viewing;
  viewing.camera = {640, 480, 550, 550, 319.5, 239.5};
  viewing.X_WC = geometry::look_at({0.75, -0.35, 0.6}, {0, 0, 0.15});
  return viewing;
}

/// The box of the tests, seen by that camera from where it stands.
HeldInspection inspection_of(const TriangleMesh& mesh_W, const ViewingCamera& viewing) {
  surface::ObjectModel object = surface::model_of_mesh(mesh_W);
  object.vertex_origin.assign(object.mesh_W.vertices.size(), surface::SurfaceOrigin::kPredicted);
  HeldInspection inspection{viewing, surface_patches(object), object.mesh_W, {}};
  for (SurfacePatch& patch : inspection.patches_W) {
    patch.seen = patch.normal_W.dot(viewing.X_WC.translation() - patch.p_W) > 0.2;
  }
  return inspection;
}

// What is lifted is turned so that the camera sees sides that it has not seen: the pose of the arm
// at a view's end brings such a side to face it, and the way there is free.
TEST_P(PlatformPickTest, TurnsWhatItHoldsBeforeACamera) {
  const TriangleMesh box = box_at({0.04, 0.04, 0.16}, {0, 0, 0.08});
  PlatformPickOptions options;
  options.inspection = inspection_of(box, side_camera());
  options.inspection->options.budget = 0;
  const auto pick =
      plan_platform_pick(platform, home(), {from_above(platform, {0, 0, 0.14})}, scene, options);
  ASSERT_TRUE(pick.motion.found()) << pick.motion.problem;
  const HeldViews& views = pick.views;
  const bool turns = !platform.fixed_approach(platform.hand.preshapes.front());
  if (!turns) {
    for (const HeldView& view : views.views) EXPECT_FALSE(view.trajectory.has_value());
    return;
  }
  ASSERT_GE(views.views.size(), 2U) << views.problem;
  EXPECT_GT(views.shown, views.seen + 0.15);
  double gained = views.seen;
  for (const HeldView& view : views.views) gained += view.gain;
  EXPECT_NEAR(gained, views.shown, 1e-9);
  EXPECT_LE(views.shown, 1);
  const robot::KinematicChain chain = platform.arm_chain();
  const auto& lift = pick.motion.segments[2];
  const RigidTransform X_BT = chain.forward(lift.waypoints.front());
  const RigidTransform X_CW = side_camera().X_WC.inverse();
  for (const HeldView& view : views.views) {
    EXPECT_EQ(view.way.front(), lift.waypoints.back());
    const RigidTransform X_moved =
        platform.X_WB * chain.forward(view.way.back()) * X_BT.inverse() * platform.X_WB.inverse();
    int shown = 0;
    for (const SurfacePatch& patch : options.inspection->patches_W) {
      const Eigen::Vector3d p_C = X_CW * X_moved * patch.p_W;
      const Eigen::Vector2d pixel = side_camera().camera.project(p_C);
      EXPECT_TRUE(pixel.x() > 0 && pixel.x() < 639 && pixel.y() > 0 && pixel.y() < 479);
      const Eigen::Vector3d normal_C = X_CW.linear() * X_moved.linear() * patch.normal_W;
      shown += !patch.seen && normal_C.dot(-p_C.normalized()) > 0.3;
    }
    if (view.trajectory) {
      EXPECT_GE(shown, view.gain * static_cast<double>(options.inspection->patches_W.size()) * 0.9);
    }
  }
}

TEST_P(PlatformPickTest, SaysWhyNothingIsTurnedBeforeACamera) {
  const TriangleMesh box = box_at({0.04, 0.04, 0.16}, {0, 0, 0.08});
  PlatformPickOptions options;
  ViewingCamera away = side_camera();
  away.X_WC = geometry::look_at({0.75, -0.35, 0.6}, {5, -0.35, 0.6});
  options.inspection = inspection_of(box, away);
  const auto pick =
      plan_platform_pick(platform, home(), {from_above(platform, {0, 0, 0.14})}, scene, options);
  ASSERT_TRUE(pick.motion.found()) << pick.motion.problem;
  EXPECT_TRUE(pick.views.views.empty());
  EXPECT_NE(pick.views.problem, "");
  // Nor is what is known all round.
  options.inspection = inspection_of(box, side_camera());
  for (SurfacePatch& patch : options.inspection->patches_W) patch.seen = true;
  const auto known =
      plan_platform_pick(platform, home(), {from_above(platform, {0, 0, 0.14})}, scene, options);
  EXPECT_TRUE(known.views.views.empty());
  EXPECT_EQ(known.views.problem, "all of it is known");
  options.inspection->camera.camera.fx = 0;
  EXPECT_THROW(
      plan_platform_pick(platform, home(), {from_above(platform, {0, 0, 0.14})}, scene, options),
      std::invalid_argument);
}

TEST_P(PlatformPickTest, ArmReachAgreesWithTheMotionsFilter) {
  const auto reaches = arm_reach(platform);
  const auto& preshape = platform.hand.preshapes.front();
  const auto root = [&](const PlatformGrasp& grasp) {
    return RigidTransform(grasp.X_WG * (platform.hand.X_HP * preshape.X_PG).inverse());
  };
  EXPECT_TRUE(reaches(root(from_above(platform, {0, 0, 0.14}))));
  EXPECT_TRUE(reaches(root(from_above(platform, {0, 0.15, 0.14}))));
  EXPECT_FALSE(reaches(root(from_above(platform, {4, 0, 0.14}))));
}

TEST_P(PlatformPickTest, SaysWhyNothingIsReached) {
  const auto far =
      plan_platform_pick(platform, home(), {from_above(platform, {4, 0, 0.14})}, scene);
  EXPECT_FALSE(far.motion.found());
  EXPECT_EQ(far.grasp, -1);
  ASSERT_FALSE(far.motion.rejections.empty());
  // Slides have no reach but their ways.
  const bool slides = !platform.arm_chain().joints().front().is_revolute;
  EXPECT_EQ(far.motion.rejections.front().filter,
            slides ? motion::PickFilter::kBeyondLimits : motion::PickFilter::kOutOfReach);
  EXPECT_FALSE(far.motion.problem.empty());
  // A grasp that is reached comes after one that is not.
  const auto second = plan_platform_pick(
      platform, home(), {from_above(platform, {4, 0, 0.14}), from_above(platform, {0, 0, 0.14})},
      scene);
  EXPECT_TRUE(second.motion.found()) << second.motion.problem;
  EXPECT_EQ(second.grasp, 1);
  const auto none = plan_platform_pick(platform, home(), {}, scene);
  EXPECT_FALSE(none.motion.found());
  EXPECT_EQ(none.motion.problem, "there are no grasps");
}

// Regression: the first preshape that had any grasp in reach was taken, here with 0.07.
TEST_P(PlatformPickTest, TheBestGraspComesBeforeThePreshapeOfTheFirst) {
  std::vector<PlatformGrasp> grasps{from_above(platform, {4, 0, 0.14}),
                                    from_above(platform, {0, 0, 0.14}),
                                    from_above(platform, {0, 0, 0.14})};
  grasps[0].expected_success = 0.8;  // out of reach
  grasps[1].expected_success = 0.07;
  grasps[2].expected_success = 0.71;
  grasps[2].preshape = platform.hand.preshapes.back().name;
  grasps[2].open = 0.9 * platform.hand.preshapes.back().open;
  const auto pick = plan_platform_pick(platform, home(), grasps, scene);
  ASSERT_TRUE(pick.motion.found()) << pick.motion.problem;
  EXPECT_EQ(pick.grasp, 2);
  int counted = 0;
  for (const auto& rejection : pick.motion.rejections) counted += rejection.count;
  EXPECT_EQ(counted, 2) << "one out of reach, one not tried";
}

// Regression: with a neighbour 15 cm along y an object could not be grasped.
TEST_P(PlatformPickTest, AFreePlaceIsFoundBesideANeighbour) {
  scene.obstacle_pieces_W = {box_at({0.06, 0.06, 0.12}, {0, 0.15, 0.06})};
  const FreePlaces places = free_places_for(platform, scene);
  ASSERT_TRUE(places.problem.empty()) << places.problem;
  PlatformPickOptions options;
  options.moves_W = places.moves_W;
  const auto pick =
      plan_platform_pick(platform, home(), {from_above(platform, {0, 0, 0.14})}, scene, options);
  ASSERT_TRUE(pick.motion.found()) << pick.motion.problem;
  const Eigen::Vector3d move = places.moves_W[static_cast<std::size_t>(pick.motion.place)];
  EXPECT_GE(move.norm(), 0.149);
  EXPECT_GT((move - Eigen::Vector3d(0, 0.15, 0)).head<2>().norm(), 0.05);
  // Beyond the table that motions are planned on.
  PlaceOptions far;
  far.given_W = Eigen::Vector2d(0, 0.9);
  EXPECT_NE(free_places_for(platform, scene, far).problem.find("cannot be reached: the table"),
            std::string::npos);
}

// What may be larger than its shape knocks nothing over on its way.
TEST_P(PlatformPickTest, IsCarriedOverAllWhereItIsGuarded) {
  scene.obstacle_pieces_W = {box_at({0.04, 0.04, 0.2}, {0.15, 0.1, 0.1})};
  PlatformPickOptions options;
  options.moves_W = {{0, 0.2, 0}};
  const robot::KinematicChain chain = platform.arm_chain();
  for (const bool over : {false, true}) {
    options.guarded = over;
    const auto pick =
        plan_platform_pick(platform, home(), {from_above(platform, {0, 0, 0.14})}, scene, options);
    ASSERT_TRUE(pick.motion.found()) << pick.motion.problem;
    const auto& lift = pick.motion.segments[2].waypoints;
    const auto& place = pick.motion.segments[4].waypoints;
    const auto height = [&](const robot::Positions& q) {
      return (platform.X_WB * chain.forward(q)).translation().z();
    };
    const double expected = over ? 0.25 : 0.15;
    EXPECT_NEAR(height(lift.back()) - height(lift.front()), expected, 1e-3);
    EXPECT_GT(height(place.front()) - height(place.back()), expected - 1e-3);
  }
}

// Regression: a can that had stood on a box was carried as high over the table as over the box, and
// into what stands about its place.
TEST_P(PlatformPickTest, WhatStoodHigherIsLetDownFromOverAllToo) {
  constexpr double kBox = 0.1;  // m, that it stands on
  for (TriangleMesh& piece : scene.object_pieces_W) {
    piece = geometry::transformed(
        piece, geometry::make_transform(Eigen::Quaterniond::Identity(), {0, 0, kBox}));
  }
  scene.obstacle_pieces_W = {box_at({0.1, 0.1, kBox}, {0, 0, kBox / 2}),
                             box_at({0.04, 0.04, 0.2}, {0.15, 0.1, 0.1})};
  PlatformPickOptions options;
  options.moves_W = {{0, 0.2, -kBox}};
  options.guarded = true;
  const auto pick = plan_platform_pick(platform, home(),
                                       {from_above(platform, {0, 0, 0.14 + kBox})}, scene, options);
  ASSERT_TRUE(pick.motion.found()) << pick.motion.problem;
  const robot::KinematicChain chain = platform.arm_chain();
  const auto height = [&](const robot::Positions& q) {
    return (platform.X_WB * chain.forward(q)).translation().z();
  };
  const auto& lift = pick.motion.segments[2].waypoints;
  const auto& place = pick.motion.segments[4].waypoints;
  EXPECT_NEAR(height(lift.back()) - height(lift.front()), 0.15, 1e-3);
  EXPECT_GT(height(place.front()), height(lift.front()) - kBox + 0.25 - 1e-3);
}

// Of the hand's links [m] over the table, closed so.
double lowest_of(const robot::Platform& platform, const RigidTransform& X_WG,
                 const std::string& preshape, const Eigen::VectorXd& all) {
  const RigidTransform X_GH =
      (platform.hand.X_HP * platform.hand.preshape(preshape).X_PG).inverse(Eigen::Isometry);
  double lowest = 10;
  for (const auto& link : robot::placed_hand_links(platform.hand, X_WG * X_GH, all)) {
    for (const auto& p_W : link.vertices) lowest = std::min(lowest, p_W.z());
  }
  return lowest;
}

// Regression: a can that had stood on a box was let go in the air, 25 cm over the table: what was
// predicted of it went down to the table, or did not.
TEST_P(PlatformPickTest, WhatMayEndHigherIsLoweredOn) {
  auto grasp = from_above(platform, {0, 0, 0.14});
  grasp.closed_all = platform.hand.all_positions(platform.hand.preshapes.front().open);
  PlatformPickOptions options;
  options.moves_W = {{0, 0.15, 0}};
  const robot::KinematicChain chain = platform.arm_chain();
  const auto& preshape = platform.hand.preshapes.front();
  const auto tool = [&](const robot::Positions& q) {
    return platform.X_WB * chain.forward(q) * platform.X_FG(preshape);
  };
  for (const bool guarded : {false, true}) {
    options.guarded = guarded;
    const auto pick = plan_platform_pick(platform, home(), {grasp}, scene, options);
    ASSERT_TRUE(pick.motion.found()) << pick.motion.problem;
    const motion::PickSegment& place = pick.motion.segments[4];
    const RigidTransform X_WG = tool(place.waypoints.back());
    const double lowest = lowest_of(platform, X_WG, grasp.preshape, grasp.closed_all);
    if (!guarded) {
      EXPECT_EQ(pick.motion.place_share, 1);
      EXPECT_NEAR(X_WG.translation().z(), 0.14, 1e-4);
      continue;
    }
    EXPECT_GT(lowest, 0.007) << "the hand stays over the table";
    EXPECT_LT(X_WG.translation().z(), 0.135);
    ASSERT_LT(pick.motion.place_share, 1);
    const auto at = place.trajectory->at(pick.motion.place_share * place.trajectory->duration());
    EXPECT_NEAR(tool(at.position).translation().z(), 0.14, 0.003)
        << "there it stands, as predicted";
    // It leaves from where it is predicted to stand.
    EXPECT_NEAR(tool(pick.motion.segments[5].waypoints.front()).translation().z(), 0.14, 1e-4);
  }
}

// What stood on another is put on the table, as far down as the hand gets.
TEST_P(PlatformPickTest, APlaceIsNoLowerThanTheHandGets) {
  scene.object_pieces_W = {box_at({0.04, 0.04, 0.1}, {0, 0, 0.17})};
  scene.obstacle_pieces_W = {box_at({0.2, 0.2, 0.12}, {0, 0, 0.06})};
  const FreePlaces places = free_places_for(platform, scene);
  ASSERT_FALSE(places.moves_W.empty());
  EXPECT_NEAR(places.moves_W.front().z(), -0.12, 1e-9);
  EXPECT_TRUE(places.moves_W.back().isZero()) << "where it stood it may stand again";
  auto grasp = from_above(platform, {0, 0, 0.2});
  grasp.closed_all = platform.hand.all_positions(platform.hand.preshapes.front().open);
  PlatformPickOptions options;
  options.moves_W = {places.moves_W.front()};
  const double room = lowest_of(platform, grasp.X_WG, grasp.preshape, grasp.closed_all) - 0.008;
  const auto pick = plan_platform_pick(platform, home(), {grasp}, scene, options);
  ASSERT_TRUE(pick.motion.found()) << pick.motion.problem;
  const robot::KinematicChain chain = platform.arm_chain();
  const RigidTransform X_WG = platform.X_WB *
                              chain.forward(pick.motion.segments[4].waypoints.back()) *
                              platform.X_FG(platform.hand.preshapes.front());
  EXPECT_NEAR(X_WG.translation().z(), 0.2 - std::min(0.12, room), 1e-4);
}

TEST_P(PlatformPickTest, ObstaclesRoundTheObjectAreKeptFrom) {
  scene.obstacle_pieces_W = {box_at({0.4, 0.4, 0.05}, {0, 0, 0.3})};  // a lid over it
  const auto pick =
      plan_platform_pick(platform, home(), {from_above(platform, {0, 0, 0.14})}, scene);
  EXPECT_FALSE(pick.motion.found());
}

TEST_P(PlatformPickTest, RefusesWhatIsNone) {
  auto grasp = from_above(platform, {0, 0, 0.14});
  grasp.preshape = "fist";
  EXPECT_THROW(plan_platform_pick(platform, home(), {grasp}, scene), geometry::InputError);
  scene.object_pieces_W.clear();
  EXPECT_THROW(plan_platform_pick(platform, home(), {}, scene), std::invalid_argument);
}

// Against the links' own shapes, with slack for the balls that stand for them.
TEST_P(PlatformPickTest, ReachesWhereTheArmIsClearOfTheTable) {
  const robot::KinematicChain chain = platform.arm_chain();
  const robot::InverseKinematics inverse(chain, robot::InverseOptions{.elbow_angles = 8});
  const auto by_arm = arm_reach(platform);
  const auto over_table = arm_reach_over_table(platform, scene, {});
  // How far the lowest point of the arm's links is over the table; the base and the last link
  // aside.
  const auto height = [&](const robot::Positions& q) {
    std::vector<RigidTransform> X_WL(platform.model.links.size(), platform.X_WB);
    std::vector<bool> counts(platform.model.links.size(), false);
    double least = 10;
    for (const robot::Joint& joint : platform.model.joints) {
      const auto at = std::ranges::find(chain.joints(), joint.name, &robot::ChainJoint::name);
      const auto parent = static_cast<std::size_t>(joint.parent),
                 child = static_cast<std::size_t>(joint.child);
      const auto index = at - chain.joints().begin();
      const bool is_of_chain = at != chain.joints().end();
      X_WL[child] = X_WL[parent] * joint.pose_at(is_of_chain ? q[index] : 0);
      counts[child] = is_of_chain ? index + 1 < chain.size() : counts[parent];
      if (!counts[child]) continue;
      const auto mesh = robot::link_mesh(platform.model.links[child]);
      for (const auto& p_L : mesh.vertices) least = std::min(least, (X_WL[child] * p_L).z());
    }
    return least;
  };
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  int refused = 0, taken = 0;
  for (int i = 0; i < 50000 && refused + taken < 400; ++i) {
    robot::Positions somewhere = chain.middle();
    for (int k = 0; k < chain.size(); ++k) {
      const robot::ChainJoint& joint = chain.joints()[static_cast<std::size_t>(k)];
      somewhere[k] += 0.5 * unit(random) * (joint.upper - joint.lower);
    }
    const RigidTransform X_WH = platform.X_WB * chain.forward(somewhere) * platform.X_FH;
    const Eigen::Vector3d p = X_WH.translation();
    if (p.head<2>().norm() > 0.4 || p.z() < 0 || p.z() > 0.4) continue;  // the table has an end
    const auto solutions =
        inverse.solve(platform.X_WB.inverse() * X_WH * platform.X_FH.inverse()).solutions;
    double best = -10;  // m
    for (const auto& q : solutions) best = std::max(best, height(q));
    ASSERT_EQ(by_arm(X_WH), !solutions.empty());
    if (over_table(X_WH)) {
      ++taken;
      EXPECT_GT(best, 0) << i;
    } else if (!solutions.empty()) {
      ++refused;
      EXPECT_LT(best, 0.1) << i;  // a margin and what balls of 40 mm are larger
    }
  }
  EXPECT_GT(taken, 0);
  EXPECT_GT(refused + taken, 50);
}

INSTANTIATE_TEST_SUITE_P(Platforms, PlatformPickTest,
                         ::testing::Values("kr5_pg70.yaml", "kr5_sdh.yaml", "pa10_barrett.yaml",
                                           "stage_pg70.yaml"),
                         [](const auto& test) {
                           const std::string name = test.param;
                           return name.substr(0, name.find('.'));
                         });

}  // namespace
}  // namespace prehend::planning

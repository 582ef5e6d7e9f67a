// Each rule that leaves something out, against the full model: the bounds that ModelRules states.

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

#include "grasping.h"
#include "prehend/contact/pad_depths.h"
#include "prehend/simulation/explain.h"
#include "trace.h"

namespace prehend::simulation {
namespace {

using testing::above;
using testing::grasp;
using testing::grasp_scene;
using testing::height_of;
using testing::kGraspHeight;
using testing::run;
using testing::trace;

// The box to grip, a bottle and a mug that are meshes, a ball that rolls, and one stacked on top.
Scene busy_scene() {
  Scene scene = grasp_scene(0.4);
  const auto add = [&](const char* shape, double x, double y) {
    SceneObject object;
    object.name = object.shape = shape;
    object.x = x;
    object.y = y;
    scene.objects.push_back(object);
  };
  add("bottle", 0.2, 0);
  add("mug", -0.2, 0.1);
  add("ball", 0, 0.25);
  return scene;
}

// Grips the box, drives it into the bottle, turns and comes down again.
std::string eventful_trace(const Scene& scene) {
  World world(scene);
  world.place_object("ball",
                     geometry::make_transform(Eigen::Quaterniond::Identity(), {0.01, 0.25, 0.02}));
  std::string seen;
  world.set_gripper_command(GripperMode::kVelocity, -0.04, 0.4);
  seen += trace(world, 0.8);
  world.set_gripper_command(GripperMode::kCurrent, -1);
  seen += trace(world, 0.3);
  world.move_carrier(scene.carrier.gripper_pose({0.12, 0.02, 0.08}, 0.5), 0.3);
  seen += trace(world, 0.8);
  world.set_gripper_command(GripperMode::kPosition, 0.069);
  seen += trace(world, 0.5);
  return seen;
}

TEST(ModelRules, RulesThatPromiseNoErrorAreBitwiseTheFullModel) {
  const Scene with = busy_scene();
  const std::string expected = eventful_trace(with);
  for (bool ModelRules::*rule : {&ModelRules::gate_texels, &ModelRules::remember_triangles,
                                 &ModelRules::skip_distant_pairs}) {
    Scene without = with;
    without.physics.rules.*rule = false;
    EXPECT_TRUE(eventful_trace(without) == expected);
  }
}

// The pads' rays themselves, over random poses near and far; see also FindDepths.* of contact.
TEST(ModelRules, PrimitivesAreTheirMeshesWithinTheFacets) {
  const contact::PadLayout pad = contact::PadLayout::flat({});
  const contact::PadReach reach(pad);
  contact::PadState exact(pad), faceted(pad);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (const std::string shape : {"box", "can", "ball"}) {
    Scene scene;
    SceneObject object;
    object.name = object.shape = shape;
    scene.objects.push_back(object);
    double bound = -1;
    for (const LeftOutPart& part : explain(scene).left_out) {
      if (part.rule == "primitives") bound = part.error;
    }
    ASSERT_GT(bound, 0) << shape;
    const FeltShape felt = primitive_shape(object).value();
    const contact::Shape mesh = contact::Shape::mesh(object_mesh(object));
    double worst = 0;
    int met = 0;
    for (int i = 0; i < 4000; ++i) {
      // A vertical pad that faces the object, turned by up to 17 degrees, pressed in by up to 3 mm.
      const double yaw = M_PI * unit(random), across = 0.004 * unit(random);
      const double half = shape == "box" ? 0.025 : 0.03;
      geometry::RigidTransform X_BP = geometry::RigidTransform::Identity();
      const double facing = shape == "box" ? 0.3 * unit(random) : yaw;
      const Eigen::AngleAxisd turn(facing, Eigen::Vector3d::UnitZ());
      const Eigen::AngleAxisd tip(0.1 * unit(random), Eigen::Vector3d::UnitY());
      // z of P towards the object's axis, y up.
      Eigen::Matrix3d R;
      R.col(2) = -Eigen::Vector3d::UnitX();
      R.col(1) = Eigen::Vector3d::UnitZ();
      R.col(0) = R.col(1).cross(R.col(2));
      X_BP.linear() = (turn * tip).toRotationMatrix() * R;
      const Eigen::Vector3d from(half - 0.0015 + 0.0015 * unit(random), across, 0);
      X_BP.translation() = turn * from + Eigen::Vector3d(0, 0, shape == "ball" ? 0.03 : 0.06);
      const geometry::RigidTransform X_PB = X_BP.inverse(Eigen::Isometry);
      contact::find_depths(pad, reach, felt.shape, X_PB * felt.X_BS, 0, exact);
      contact::find_depths(pad, reach, mesh, X_PB, 0, faceted);
      for (std::size_t k = 0; k < pad.size(); ++k) {
        const double a = exact.depth[k], b = faceted.depth[k];
        // Where one just misses, the other has at most the bound.
        if (a < 0 && b < 0) continue;
        met += a > 0 && b > 0;
        // Along the ray the distance between two surfaces is that across them over the cosine, at
        // least cos 42 degrees for the rays of a pad of 20 mm on a radius of 30 mm.
        const double difference = std::max(a, 0.0) - std::max(b, 0.0);
        worst = std::max(worst, std::abs(difference));
        ASSERT_LE(std::abs(difference), 1e-9 + bound / std::cos(0.73)) << shape << " " << i;
      }
    }
    EXPECT_GT(met, 20000) << shape;
    EXPECT_GT(worst, 0.2 * bound * (shape != "box")) << shape << ": the bound is far too wide";
    RecordProperty(shape + "_um", std::to_string(1e6 * worst));
  }
}

TEST(ModelRules, ABoxIsGraspedAlikeAsBoxAndAsMesh) {
  const auto lifted = [](bool primitives) {
    Scene scene = grasp_scene(0.35);
    scene.physics.rules.primitives = primitives;
    World world(scene);
    grasp(world, 1.0);
    world.move_carrier(above(world, kGraspHeight + 0.1), 0.1);
    run(world, 2);
    return std::pair(height_of(world), world.tactile_image(PadSide::kLeft).sum);
  };
  const auto box = lifted(true), mesh = lifted(false);
  EXPECT_NEAR(box.first, mesh.first, 1e-7);
  EXPECT_NEAR(box.second, mesh.second, 1e-4);
}

TEST(ModelRules, BoxesStandOnBoxesAlikeAsBoxesAndAsMeshes) {
  const auto stacked = [](bool primitives) {
    Scene scene = grasp_scene(0.35);
    scene.physics.rules.primitives = primitives;
    scene.objects.push_back(scene.objects[0]);
    scene.objects[1].name = "upper";
    scene.objects[1].size = {0.05, 0.06, 0.04};
    scene.objects[1].x = 0.3;
    World world(scene);
    world.place_object("upper", geometry::make_transform(Eigen::Quaterniond(Eigen::AngleAxisd(
                                                             0.3, Eigen::Vector3d::UnitZ())),
                                                         {0.003, 0.002, 0.1001}));
    run(world, 0.5);
    EXPECT_NEAR(world.body("upper").height, 0.1, 1e-4);
    return world.body("upper").X_WB;
  };
  EXPECT_LT((stacked(true).matrix() - stacked(false).matrix()).norm(), 1e-7);
}

// What sleepers would still have settled.
TEST(ModelRules, SleepersStandWhereTheyWouldStand) {
  const auto stood = [](bool sleep) {
    Scene scene = busy_scene();
    scene.physics.rules.sleep = sleep;
    World world(scene);
    run(world, 0.3);
    std::vector<geometry::RigidTransform> poses;
    run(world, 4);
    for (std::size_t i = 0; i < world.body_count(); ++i) poses.push_back(world.body(i).X_WB);
    EXPECT_EQ(world.body("box").asleep, sleep);
    return poses;
  };
  const auto with = stood(true), without = stood(false);
  double worst = 0;
  for (std::size_t i = 0; i < with.size(); ++i) {
    worst = std::max(worst, (with[i].translation() - without[i].translation()).norm());
  }
  EXPECT_LT(worst, 2e-5);
  RecordProperty("worst_um", std::to_string(1e6 * worst));
}

TEST(ModelRules, PushedSleepersGoWhereTheyWouldGo) {
  const auto pushed = [](bool sleep) {
    Scene scene = grasp_scene(0.5);
    scene.objects[0].x = 0.2;
    scene.carrier.start = {0, 0, 0.05};
    scene.start_opening = 0;
    scene.physics.rules.sleep = sleep;
    World world(scene);
    run(world, 1);
    EXPECT_EQ(world.body("box").asleep, sleep);
    world.move_carrier(scene.carrier.gripper_pose({0.25, 0, 0.05}, 0), 0.2);
    run(world, 2.5);
    return world.body("box").X_WB.translation();
  };
  const Eigen::Vector3d with = pushed(true), without = pushed(false);
  EXPECT_GT(with.x(), 0.28);
  EXPECT_LT((with - without).norm(), 1e-4);
}

// Beyond the carrier's limits, which end at x = 0.6 m.
Scene far_scene(bool rule) {
  Scene scene = busy_scene();
  for (std::size_t i = 1; i < scene.objects.size(); ++i) scene.objects[i].x = 0.9;
  scene.physics.rules.out_of_reach = rule;
  return scene;
}

TEST(ModelRules, WhatIsOutOfReachSleepsFromTheStartWithinItsBound) {
  World with(far_scene(true)), without(far_scene(false));
  EXPECT_TRUE(with.body("bottle").asleep && with.body("mug").asleep);
  EXPECT_FALSE(with.body("box").asleep) << "in reach";
  EXPECT_FALSE(with.body("ball").asleep) << "a ball does not stand by itself";
  EXPECT_FALSE(without.body("bottle").asleep);
  const Explanation explanation = with.explained();
  run(with, 2);
  run(without, 2);
  int judged = 0;
  for (const LeftOutPart& part : explanation.left_out) {
    if (part.rule != "out_of_reach") continue;
    const std::string name = part.what.substr(std::string("motion of ").size());
    const double error =
        (with.body(name).X_WB.translation() - without.body(name).X_WB.translation()).norm();
    EXPECT_LT(error, 1.1 * part.error) << name;
    EXPECT_GT(error, 0.1 * part.error) << name << ": the bound is far too wide";
    ++judged;
  }
  EXPECT_EQ(judged, 2);
  EXPECT_EQ(with.body("box").X_WB.matrix(), without.body("box").X_WB.matrix());
}

TEST(ModelRules, WhatIsOutOfReachWakesWhenHit) {
  World world(far_scene(true));
  geometry::RigidTransform above_mug = world.body("mug").X_WB;
  above_mug.translation().z() += 0.25;
  world.place_object("ball", above_mug);
  EXPECT_TRUE(world.body("mug").asleep);
  run(world, 0.4);
  EXPECT_FALSE(world.body("mug").asleep);
  EXPECT_GT((world.body("mug").velocity).norm() + world.body("mug").angular_velocity.norm(), 0);
}

TEST(ModelRules, WhatDoesNotStandIsNotLeftOut) {
  World world(far_scene(true));
  world.place_object(
      "bottle",
      geometry::make_transform(Eigen::Quaterniond(Eigen::AngleAxisd(0.8, Eigen::Vector3d::UnitX())),
                               {0.9, 0, 0.02}));
  EXPECT_FALSE(world.body("bottle").asleep);
  run(world, 1);
  EXPECT_LT(world.body("bottle").X_WB.linear()(2, 2), 0.3) << "it fell over";
}

TEST(ModelRules, RigidPadsHoldAlikeWithinWhatFoamGives) {
  const auto lifted = [](bool rigid) {
    Scene scene = grasp_scene(0.35);
    scene.start_opening = 0.05;
    scene.physics.rules.rigid_pads = rigid;
    World world(scene);
    EXPECT_EQ(world.has_touch(), !rigid);
    testing::grasp_slowly(world, 1.0, 1);
    world.move_carrier(above(world, kGraspHeight + 0.1), 0.1);
    run(world, 2);
    const BodyReading box = world.body("box");
    EXPECT_TRUE(box.touches_left_pad && box.touches_right_pad);
    EXPECT_NEAR(world.wrist_wrench().force.z(), 0.35 * 9.81, 1e-3);
    return std::pair(box.height, world.gripper().opening);
  };
  const auto soft = lifted(false), stiff = lifted(true);
  EXPECT_NEAR(soft.first, stiff.first, 0.26e-3);
  // The jaws stand further apart by what both pads gave way: 2 F / (N k), F about 20 N.
  EXPECT_NEAR(stiff.second - soft.second, 2 * 20.0 / 84e3, 0.1e-3);
  Scene scene = grasp_scene(0.35);
  scene.physics.rules.rigid_pads = true;
  World world(scene);
  EXPECT_THROW(world.tactile_image(PadSide::kLeft), std::logic_error);
}

TEST(ModelRules, NoneIsTheFullModel) {
  Scene scene = busy_scene();
  scene.physics.rules = ModelRules::none();
  const Explanation full = explain(scene);
  for (const LeftOutPart& part : full.left_out) EXPECT_EQ(part.rule, "") << part.what;
  EXPECT_EQ(full.rules_off.size(), 7u);
  World world(scene);
  grasp(world, 1.0);
  EXPECT_TRUE(world.body("box").touches_left_pad);
}

}  // namespace
}  // namespace prehend::simulation

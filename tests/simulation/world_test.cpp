#include "prehend/simulation/world.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

#include "grasping.h"
#include "prehend/geometry/errors.h"
#include "prehend/simulation/shapes.h"

namespace prehend::simulation {
namespace {

using testing::grasp;
using testing::grasp_scene;
using testing::run;

Scene lonely(const std::string& shape, double mass = 0.3) {
  Scene scene;
  SceneObject object;
  object.name = "thing";
  object.shape = shape;
  object.mass = mass;
  scene.objects.push_back(object);
  return scene;
}

geometry::RigidTransform at(double x, double y, double z, double tilt = 0) {
  return geometry::make_transform(
      Eigen::Quaterniond(Eigen::AngleAxisd(tilt, Eigen::Vector3d(1, 0.4, 0).normalized())),
      {x, y, z});
}

TEST(World, ObjectsAtRestNeitherCreepNorSink) {
  for (const std::string shape : {"box", "can", "bottle", "mug", "ball"}) {
    for (const double mass : {0.05, 3.0}) {
      World world(lonely(shape, mass));
      run(world, 0.2);
      const geometry::RigidTransform start = world.body("thing").X_WB;
      run(world, 5);
      const BodyReading body = world.body("thing");
      EXPECT_LT((body.X_WB.translation() - start.translation()).norm(), 2e-5) << shape << mass;
      EXPECT_NEAR(body.height, 0, 1.1 * mass * 9.81 / 1e5) << shape << mass;
      EXPECT_TRUE(body.touches_table);
    }
  }
}

TEST(World, FallsAsGalileoSays) {
  Scene scene = lonely("ball");
  World world(scene);
  world.place_object("thing", at(0, 0, 0.5));
  run(world, 0.2);
  EXPECT_NEAR(world.body("thing").velocity.z(), -9.81 * 0.2, 1e-9);
  EXPECT_NEAR(world.body("thing").X_WB.translation().z(), 0.5 - 0.5 * 9.81 * 0.04, 0.0011);
}

TEST(World, EnergyNeverGrowsInABounce) {
  for (const double step : {1e-4, 1e-3, 1e-2}) {
    for (const std::string shape : {"box", "ball", "bottle", "spray_bottle"}) {
      Scene scene = lonely(shape, 1.0);
      scene.objects[0].size = {0.06, 0.05, 0.15};
      scene.step = step;
      World world(scene);
      world.place_object("thing", at(0, 0, 0.25, 0.5));
      double energy = world.energy();
      const double start = energy;
      for (int i = 0; i * step < 2; ++i) {
        world.step();
        // Bristle springs are not in energy(), and contacts do not see the body turn within a step
        // (second order in the step): what these give back is below this.
        const double slack = (step > 1e-3 ? 1e-2 : 2e-4) * start;
        EXPECT_LT(world.energy(), energy + slack) << shape << " " << step << " at " << i;
        energy = std::min(energy, world.energy());
      }
      EXPECT_LT(energy, 0.9 * start);
    }
  }
}

TEST(World, SlidesOnARampBeyondTheFrictionAngleOnly) {
  Scene scene = lonely("box", 0.5);
  scene.objects[0].size = {0.1, 0.1, 0.02};
  // Speed gained from 0.2 to 0.5 s, when the drop on the ramp is over [m/s].
  const auto gained_speed = [&](double angle) {
    World world(scene);
    const geometry::RigidTransform X = geometry::make_transform(
        Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY())), {0, 0, 0.3});
    const geometry::TriangleMesh ramp = geometry::make_box({0.6, 0.4, 0.02});
    world.add_object("ramp", geometry::transformed(ramp, X), 1, true, 0.7);
    geometry::RigidTransform X_box = X;
    X_box.translation() += X.linear() * Eigen::Vector3d(0, 0, 0.0101);
    world.place_object("thing", X_box);
    run(world, 0.2);
    const double before = world.body("thing").velocity.norm();
    run(world, 0.3);
    return world.body("thing").velocity.norm() - before;
  };
  // Objects against objects have friction 0.3: the friction angle is 0.2915 rad.
  EXPECT_NEAR(gained_speed(0.25), 0, 1e-4);
  for (const double angle : {0.35, 0.45}) {
    const double expected = 9.81 * (std::sin(angle) - 0.3 * std::cos(angle)) * 0.3;
    EXPECT_NEAR(gained_speed(angle), expected, 0.01 * expected) << angle;
  }
}

TEST(World, StacksStand) {
  Scene scene = lonely("box", 1.0);
  scene.objects[0].size = {0.08, 0.08, 0.05};
  scene.objects.push_back(scene.objects[0]);
  scene.objects[1].name = "upper";
  scene.objects[1].x = 0.3;
  scene.objects[1].size = {0.06, 0.06, 0.05};
  World world(scene);
  world.place_object("upper", at(0, 0, 0.0502));
  run(world, 2);
  EXPECT_NEAR(world.body("upper").height, 0.05, 3e-4);
  EXPECT_NEAR(world.body("upper").X_WB.translation().head<2>().norm(), 0, 5e-4);
}

TEST(World, SameCallsGiveBitwiseSameStates) {
  const auto final_pose = [] {
    World world(grasp_scene(0.5));
    grasp(world, 1.0);
    world.move_carrier(testing::above(world, 0.15), 0.2);
    run(world, 1);
    return world.body("box").X_WB;
  };
  EXPECT_EQ(final_pose().matrix(), final_pose().matrix());
}

TEST(World, RestoredStateContinuesBitwise) {
  World world(grasp_scene(0.5));
  grasp(world, 1.0);
  world.move_carrier(testing::above(world, 0.15), 0.2);
  run(world, 0.3);
  const auto state = world.save();
  run(world, 0.5);
  const Eigen::Matrix4d first = world.body("box").X_WB.matrix();
  const double sum = world.tactile_image(PadSide::kLeft).sum;
  world.restore(*state);
  run(world, 0.5);
  EXPECT_EQ(world.body("box").X_WB.matrix(), first);
  EXPECT_EQ(world.tactile_image(PadSide::kLeft).sum, sum);
  world.remove_object("box");
  EXPECT_THROW(world.restore(*state), std::invalid_argument);
}

// The rule that leaves resting bodies out must not change what happens to the others.
TEST(World, SleepingBodiesWakeWhenPushed) {
  Scene scene = grasp_scene(0.5);
  scene.objects[0].x = 0.2;
  scene.carrier.start = {0, 0, 0.05};
  scene.start_opening = 0;
  World world(scene);
  run(world, 2);
  world.move_carrier(world.scene().carrier.gripper_pose({0.25, 0, 0.05}, 0), 0.2);
  run(world, 3);
  // Fingers 24 mm wide, closed, push the 70 mm long box ahead.
  EXPECT_NEAR(world.body("box").X_WB.translation().x(), 0.25 + 0.012 + 0.035, 0.006);
  EXPECT_LT(world.wrist_wrench().force.norm(), 10);
}

TEST(World, FarObjectsCostAlmostNothing) {
  Scene scene = grasp_scene(0.5);
  World world(scene);
  grasp(world, 1.0);
  const Eigen::Matrix4d alone = world.body("box").X_WB.matrix();
  for (int i = 0; i < 4; ++i) {
    SceneObject other = scene.objects[0];
    other.name = "far" + std::to_string(i);
    other.y = 0.3 + 0.1 * i;
    scene.objects.push_back(other);
  }
  World crowded(scene);
  grasp(crowded, 1.0);
  EXPECT_EQ(crowded.body("box").X_WB.matrix(), alone);
}

TEST(World, ObjectsAreAddedReplacedAndRemoved) {
  World world(Scene{});
  EXPECT_EQ(world.body_count(), 0u);
  EXPECT_FALSE(world.remove_object("x"));
  EXPECT_THROW(world.body("x"), std::invalid_argument);
  const std::uint64_t before = world.scene_generation();
  world.add_object("x", geometry::make_box({0.05, 0.05, 0.05}), 0.2);
  world.add_object("x", geometry::make_box({0.04, 0.05, 0.05}), 0.4);
  EXPECT_EQ(world.body_count(), 1u);
  EXPECT_DOUBLE_EQ(world.body("x").mass, 0.4);
  EXPECT_NEAR(world.body("x").height, 0, 1e-9) << "raised out of the table";
  EXPECT_EQ(world.scene_generation(), before + 2);
  run(world, 0.1);
  EXPECT_TRUE(world.remove_object("x"));
  run(world, 0.1);
}

TEST(World, RefusesBadObjects) {
  World world(Scene{});
  const geometry::TriangleMesh box = geometry::make_box({0.05, 0.05, 0.05});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(world.add_object("x", box, 0), std::invalid_argument);
  EXPECT_THROW(world.add_object("x", box, -1), std::invalid_argument);
  EXPECT_THROW(world.add_object("x", box, nan), std::invalid_argument);
  EXPECT_THROW(world.add_object("", box, 1), std::invalid_argument);
  EXPECT_THROW(world.add_object("x", box, 1, false, nan), std::invalid_argument);
  EXPECT_THROW(world.add_object("x", {}, 1), geometry::InputError);
  geometry::TriangleMesh bad = box;
  bad.vertices[0].x() = nan;
  EXPECT_THROW(world.add_object("x", bad, 1), geometry::InputError);
  bad = box;
  for (auto& t : bad.triangles) std::swap(t[0], t[1]);
  EXPECT_THROW(world.add_object("x", bad, 1), geometry::InputError) << "inside out";
  bad = box;
  for (auto& v : bad.vertices) v *= 1000;
  EXPECT_THROW(world.add_object("x", bad, 1), geometry::InputError) << "millimetres";
  bad = box;
  for (auto& v : bad.vertices) v.z() = 0;
  EXPECT_THROW(world.add_object("x", bad, 1), geometry::InputError) << "flat";
  EXPECT_EQ(world.body_count(), 0u);

  Scene scene = lonely("box");
  scene.objects[0].mass = 0;
  EXPECT_THROW(World{scene}, std::invalid_argument);
  scene = lonely("box");
  scene.step = nan;
  EXPECT_THROW(World{scene}, std::invalid_argument);
}

// A point beside the edge of a lower face, level with that face, is not within the body: things of
// meshes that stand beside each other on the table lie still.
TEST(World, MeshesBesideEachOtherDoNotTouch) {
  for (int k = 0; k < 24; ++k) {
    const double yaw = 0.13 * k;
    World world{Scene{}};
    const auto put = [&](const std::string& name, const geometry::TriangleMesh& mesh, double x) {
      geometry::RigidTransform X = geometry::RigidTransform::Identity();
      X.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
      X.translation() = X.linear() * Eigen::Vector3d(x, 0.004 * k, 0);
      world.add_object(name, geometry::transformed(mesh, X), 0.2);
    };
    put("book", make_standing_box({0.12, 0.08, 0.02}), 0);
    put("can", make_can(0.033, 0.1), 0.06 + 0.033 + 0.0008);
    for (int step = 0; step < 20; ++step) {
      world.step();
      for (const char* name : {"book", "can"}) {
        EXPECT_LT(world.body(name).velocity.norm(), 0.02) << name << " at " << yaw << " rad";
      }
    }
  }
}

}  // namespace
}  // namespace prehend::simulation

// The same world on every plug-in engine that is installed: `physics: {engine: NAME}`.

#include <algorithm>

#include <gtest/gtest.h>

#include "grasping.h"
#include "prehend/geometry/errors.h"
#include "prehend/simulation/engines/registry.h"
#include "prehend/simulation/explain.h"
#include "prehend/simulation/shapes.h"
#include "prehend/simulation/world_engine.h"

namespace prehend::simulation {
namespace {

using testing::above;
using testing::grasp;
using testing::grasp_scene;
using testing::height_of;
using testing::kGraspHeight;
using testing::run;

std::vector<std::string> plug_ins() {
  std::vector<std::string> names = engines::EngineRegistry().names();
  std::erase(names, "native");
  return names;
}

class WorldOn : public ::testing::TestWithParam<std::string> {
 protected:
  // Debian's Bullet is built for single precision.
  bool single() const { return GetParam() == "bullet"; }
  Scene scene(double mass) const {
    Scene scene = grasp_scene(mass);
    scene.physics.engine = GetParam();
    return scene;
  }
};
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(WorldOn);

TEST_P(WorldOn, GraspsLiftsHoldsAndPutsDown) {
  for (const double mass : {0.05, 0.35, 1.0}) {
    SCOPED_TRACE(mass);
    World world(scene(mass));
    Scene own = world.scene();
    own.physics.engine = "native";
    World native(own);
    for (World* each : {&world, &native}) {
      grasp(*each, 1.5);
      EXPECT_TRUE(each->body("box").touches_left_pad && each->body("box").touches_right_pad);
      each->move_carrier(above(*each, kGraspHeight + 0.1), 0.1);
      run(*each, 2);
    }
    EXPECT_FALSE(world.body("box").touches_table);
    const double lifted = height_of(world);
    EXPECT_NEAR(lifted, height_of(native), 5e-4);
    run(world, 2);
    EXPECT_NEAR(height_of(world), lifted, 2e-4) << "slips while held";
    EXPECT_NEAR(world.wrist_wrench().force.z(), mass * 9.81,
                (single() ? 0.02 : 1e-3) * mass * 9.81);
    const TactileImage left = world.tactile_image(PadSide::kLeft);
    const TactileImage right = world.tactile_image(PadSide::kRight);
    const double expected = native.tactile_image(PadSide::kLeft).sum;
    EXPECT_NEAR(left.sum, expected, 0.02 * expected);
    EXPECT_NEAR(left.sum, right.sum, 0.01 * expected);
    world.move_carrier(above(world, kGraspHeight + 0.001), 0.1);
    run(world, 1.5);
    world.set_gripper_command(GripperMode::kPosition, 0.069);
    run(world, 1.5);
    const BodyReading box = world.body("box");
    EXPECT_NEAR(box.height, 0, 1e-3);
    EXPECT_TRUE(box.touches_table);
    EXPECT_FALSE(box.touches_left_pad || box.touches_right_pad);
    EXPECT_GT(box.X_WB.linear()(2, 2), 0.9999) << "stands upright";
  }
}

TEST_P(WorldOn, PlacedAddedAndRemovedObjectsAreItsOwn) {
  World world(scene(0.3));
  world.place_object("box",
                     geometry::make_transform(Eigen::Quaterniond::Identity(), {0.3, 0, 0.1}));
  run(world, 0.1);
  EXPECT_NEAR(world.body("box").velocity.z(), -0.981, 1e-3) << "falls";
  EXPECT_NEAR(world.body("box").X_WB.translation().x(), 0.3, 1e-6);
  EXPECT_THROW(world.add_object("mug", make_mug(0.04, 0.09, 0.004), 0.2), geometry::InputError);
  EXPECT_EQ(world.body_count(), 1u) << "and nothing was changed";
  EXPECT_NEAR(world.body("box").velocity.z(), -0.981, 1e-3);
  EXPECT_TRUE(world.remove_object("box"));
  run(world, 0.01);
  EXPECT_EQ(world.body_count(), 0u);
}

TEST_P(WorldOn, SameCallsGiveTheSameStates) {
  const auto end = [&] {
    World world(scene(0.3));
    grasp(world, 1.0);
    world.move_carrier(above(world, kGraspHeight + 0.02), 0.1);
    run(world, 0.5);
    return world.body("box").X_WB.matrix().eval();
  };
  EXPECT_EQ(end(), end());
}

TEST_P(WorldOn, RefusesWhatItCannotDoByName) {
  Scene second = scene(0.3);
  second.physics.integration = contact::Integration::kSecondOrder;
  EXPECT_THROW(World{second}, std::invalid_argument);
  Scene meshes = scene(0.3);
  meshes.physics.rules.primitives = false;
  EXPECT_THROW(World{meshes}, std::invalid_argument);
  Scene mug = scene(0.3);
  mug.objects[0].shape = "mug";
  EXPECT_THROW(World{mug}, std::invalid_argument);
  Scene solver = scene(0.3);
  solver.physics.solver = "none_such";
  EXPECT_THROW(World{solver}, geometry::InputError);
  World world(scene(0.3));
  EXPECT_THROW(world.save(), std::logic_error);
  EXPECT_THROW(world.save_bytes(), std::logic_error);
  try {
    world.restore_bytes("", "x");
    FAIL();
  } catch (const std::logic_error& error) {
    EXPECT_NE(std::string(error.what()).find(GetParam()), std::string::npos) << error.what();
  }
}

TEST_P(WorldOn, IsExplained) {
  const Explanation explanation = explain(scene(0.3));
  const auto& engine = explanation.modelled.front();
  EXPECT_EQ(engine.what, "engine");
  EXPECT_EQ(engine.how.find(GetParam()), 0u) << engine.how;
}

INSTANTIATE_TEST_SUITE_P(Engines, WorldOn, ::testing::ValuesIn(plug_ins()),
                         [](const auto& engine) { return engine.param; });

TEST(WorldEngineName, UnknownAndMissingOnesSayWhatMends) {
  Scene scene = grasp_scene(0.3);
  scene.physics.engine = "mujocco";
  try {
    World world(scene);
    FAIL();
  } catch (const std::invalid_argument& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find("physics.engine"), std::string::npos) << what;
    EXPECT_NE(what.find("'mujoco'"), std::string::npos) << what;
  }
  scene.physics.engine = "native";
  scene.physics.solver = "noslip";
  EXPECT_THROW(World{scene}, std::invalid_argument);
  ASSERT_EQ(setenv("PREHEND_ENGINES", "/nowhere", 1), 0);
  const auto missing = engine_trouble("dart");
  unsetenv("PREHEND_ENGINES");
  ASSERT_TRUE(missing);
  EXPECT_NE(missing->wrong.find("not installed"), std::string::npos);
  EXPECT_NE(missing->mend.find("libdart-dev"), std::string::npos);
  EXPECT_EQ(explain(grasp_scene(0.3)).modelled.front().what, "engine");
}

}  // namespace
}  // namespace prehend::simulation

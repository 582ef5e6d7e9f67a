// The same world on every plug-in engine that is installed: `physics: {engine: NAME}`.

#include <algorithm>
#include <cstdlib>
#include <filesystem>

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

// As a box and as the mesh of that box.
TEST_P(WorldOn, GraspsLiftsHoldsAndPutsDown) {
  for (const auto& [mass, primitives] :
       {std::pair{0.05, true}, {0.35, true}, {1.0, true}, {0.05, false}, {1.0, false}}) {
    SCOPED_TRACE(mass);
    SCOPED_TRACE(primitives ? "a box" : "a mesh");
    Scene given = scene(mass);
    given.physics.rules.primitives = primitives;
    World world(given);
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
  EXPECT_THROW(world.add_object("box", geometry::TriangleMesh{}, 0.2), geometry::InputError);
  geometry::TriangleMesh flat = geometry::make_box({0.1, 0.1, 1e-9});
  EXPECT_THROW(world.add_object("box", flat, 0.2), geometry::InputError);
  geometry::TriangleMesh wild = geometry::make_box({0.1, 0.1, 0.1});
  wild.triangles[3].y() = 1000;
  EXPECT_THROW(world.add_object("box", wild, 0.2), geometry::InputError);
  wild = geometry::make_box({0.1, 0.1, 0.1});
  wild.vertices[0].z() = std::nan("");
  EXPECT_THROW(world.add_object("box", wild, 0.2), geometry::InputError);
  EXPECT_EQ(world.body_count(), 1u) << "and nothing was changed";
  EXPECT_NEAR(world.body("box").velocity.z(), -0.981, 1e-3);
  world.add_object("mug", make_mug(0.04, 0.09, 0.004), 0.2);
  EXPECT_EQ(world.body_count(), 2u);
  EXPECT_TRUE(world.remove_object("box"));
  run(world, 0.01);
  EXPECT_EQ(world.body_count(), 1u);
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

// A mesh with one hole where a camera did not see, as scans have them, is still a solid.
TEST_P(WorldOn, AMeshWithACrackStands) {
  geometry::TriangleMesh cracked = geometry::make_box({0.06, 0.06, 0.08});
  for (auto& v : cracked.vertices) v.z() += 0.04;
  cracked.triangles.pop_back();
  World world(scene(0.3));
  world.remove_object("box");
  world.add_object("cracked", cracked, 0.2);
  run(world, 1);
  EXPECT_NEAR(world.body("cracked").height, 0, 1e-3);
  EXPECT_TRUE(world.body("cracked").touches_table);
}

// Shapes that are no primitives stand, fall and rest as in the native world, which meets the mesh.
TEST_P(WorldOn, MeshesStandAndFallAsTheyDoNatively) {
  Scene scene_of_meshes = scene(0.3);
  scene_of_meshes.objects.clear();
  for (const char* shape : {"mug", "bottle", "spray_bottle"}) {
    SceneObject object;
    object.name = object.shape = shape;
    object.x = 0.2 * static_cast<double>(scene_of_meshes.objects.size());
    object.y = 0.2;
    object.size = {0.08, 0.05, 0.2};
    scene_of_meshes.objects.push_back(object);
  }
  Scene own = scene_of_meshes;
  own.physics.engine = "native";
  World world(scene_of_meshes), native(own);
  for (World* each : {&world, &native}) {
    run(*each, 1);
    each->place_object("bottle",
                       geometry::make_transform(Eigen::Quaterniond(Eigen::AngleAxisd(
                                                    1.0, Eigen::Vector3d(1, 1, 0).normalized())),
                                                {0.2, 0.2, 0.04}));
    run(*each, 2.5);
  }
  for (const char* name : {"mug", "spray_bottle"}) {
    const geometry::RigidTransform X = world.body(name).X_WB, expected = native.body(name).X_WB;
    EXPECT_LT((X.translation() - expected.translation()).norm(), 2e-3) << name;
    EXPECT_GT((X.linear() * expected.linear().transpose()).trace(), 3 - 1e-4) << name;
    EXPECT_TRUE(world.body(name).touches_table) << name;
  }
  // The bottle fell over and lies on its side, where it may have rolled.
  for (const World* each : {&world, &native}) {
    EXPECT_NEAR(each->body("bottle").X_WB.linear()(2, 2), 0, 0.15);
    EXPECT_NEAR(each->body("bottle").height, 0, 1.5e-3);
  }
}

// Scans as they are, with what decomposition makes of them.
TEST_P(WorldOn, ScannedMeshesComeToRest) {
  const char* data = std::getenv("PREHEND_SHARED_DATA");
  const std::filesystem::path folder = std::filesystem::path(data ? data : "") / "meshes/ycb";
  if (!data || !std::filesystem::exists(folder)) {
    GTEST_SKIP() << "PREHEND_SHARED_DATA names no folder with meshes/ycb, scanned objects that are "
                    "not part of this project";
  }
  Scene scans = scene(0.3);
  scans.objects.clear();
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    SceneObject object;
    object.name = entry.path().stem();
    object.shape = "mesh";
    object.file = entry.path();
    object.x = 0.3 * static_cast<double>(scans.objects.size() % 4);
    object.y = 0.3 * static_cast<double>(scans.objects.size() / 4);
    scans.objects.push_back(object);
  }
  World world(scans);
  run(world, 2);
  for (std::size_t i = 0; i < world.body_count(); ++i) {
    const BodyReading body = world.body(i);
    EXPECT_NEAR(body.height, 0, 1e-3) << body.name;
    EXPECT_TRUE(body.touches_table) << body.name;
    // What is round, a ball, a bottle on its side, goes on rolling.
    EXPECT_LT(body.velocity.norm(), 0.2) << body.name;
  }
}

TEST_P(WorldOn, IsExplained) {
  Scene explained = scene(0.3);
  SceneObject mug;
  mug.name = mug.shape = "mug";
  mug.x = 0.3;
  explained.objects.push_back(mug);
  const Explanation explanation = explain(explained);
  const auto& engine = explanation.modelled.front();
  EXPECT_EQ(engine.what, "engine");
  EXPECT_EQ(engine.how.find(GetParam()), 0u) << engine.how;
  const auto of = [&](const std::string& what) {
    return std::find_if(explanation.modelled.begin(), explanation.modelled.end(),
                        [&](const ModelledPart& part) { return part.what == what; });
  };
  EXPECT_EQ(of("box in " + GetParam()), explanation.modelled.end()) << "a primitive";
  ASSERT_NE(of("mug in " + GetParam()), explanation.modelled.end());
  EXPECT_NE(of("mug in " + GetParam())->how.find("convex pieces"), std::string::npos);
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
  const engines::EngineRegistry none(std::vector<std::filesystem::path>{"/nowhere"});
  const auto missing = engine_trouble("dart", none);
  ASSERT_TRUE(missing);
  EXPECT_NE(missing->wrong.find("not installed"), std::string::npos);
  EXPECT_NE(missing->mend.find("libdart-dev"), std::string::npos);
  EXPECT_EQ(explain(grasp_scene(0.3)).modelled.front().what, "engine");
}

// An engine of another project (engines/example) beside those that ship, by the environment.
class AnotherProjectsEngine : public ::testing::Test {
 protected:
  AnotherProjectsEngine() { setenv("PREHEND_ENGINES", PREHEND_ENGINE_EXAMPLE, 1); }
  ~AnotherProjectsEngine() override { unsetenv("PREHEND_ENGINES"); }
};

TEST_F(AnotherProjectsEngine, IsAddedToThoseThatShip) {
  std::vector<std::string> expected = plug_ins();
  EXPECT_EQ(std::count(expected.begin(), expected.end(), "lone_body"), 1);
  std::erase(expected, "lone_body");
  unsetenv("PREHEND_ENGINES");
  EXPECT_EQ(plug_ins(), expected);
}

TEST_F(AnotherProjectsEngine, HasTheObjectOfAWorldThatIsGrasped) {
  for (const bool primitives : {true, false}) {
    Scene scene = grasp_scene(0.3);
    scene.physics.engine = "lone_body";
    scene.physics.rules.primitives = primitives;
    World world(scene);
    run(world, 0.5);
    EXPECT_NEAR(height_of(world), 0, 2e-4);
    grasp(world, 1.5);
    world.move_carrier(above(world, kGraspHeight + 0.1), 0.1);
    run(world, 2);
    const double lifted = height_of(world);
    EXPECT_NEAR(lifted, 0.1, 2e-3);
    run(world, 1);
    EXPECT_NEAR(height_of(world), lifted, 2e-4) << "slips while held";
    EXPECT_THROW(world.add_object("other", make_standing_box({0.05, 0.05, 0.05}), 0.1),
                 geometry::InputError);
    EXPECT_EQ(world.body_count(), 1u) << "and goes on without it";
    run(world, 0.1);
    EXPECT_NEAR(height_of(world), lifted, 2e-4);
    world.add_object("box", make_standing_box({0.05, 0.05, 0.05}), 0.1);  // in its place
    run(world, 0.1);
    EXPECT_NEAR(height_of(world), 0, 2e-4);
  }
}

}  // namespace
}  // namespace prehend::simulation

// Saved states and recorded commands: what is continued or repeated is bitwise the same.

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>

#include <gtest/gtest.h>
#include <unistd.h>

#include "grasping.h"
#include "prehend/geometry/errors.h"
#include "prehend/simulation/world_commands.h"
#include "trace.h"

namespace prehend::simulation {
namespace {

using testing::grasp;
using testing::grasp_scene;
using testing::run;
using testing::trace;

// Everything has a memory: foam, noisy pads and wrist, a can felt as a cylinder, a bottle as a
// mesh.
Scene rich_scene(contact::Integration integration = contact::Integration::kFirstOrder) {
  Scene scene = grasp_scene(0.5);
  scene.physics.integration = integration;
  scene.tactile.sensor = TactileSensorOptions::realistic();
  scene.tactile.foam = contact::FoamMemory::realistic();
  scene.wrench.emplace();
  scene.wrench->force_noise = 0.1;
  for (const char* shape : {"can", "bottle"}) {
    SceneObject object;
    object.name = object.shape = shape;
    object.y = shape[0] == 'c' ? 0.2 : -0.2;
    scene.objects.push_back(object);
  }
  return scene;
}

// Gripped, lifted and turned half-way.
void reach_the_middle(World& world) {
  grasp(world, 1.0);
  world.move_carrier(world.scene().carrier.gripper_pose({0.05, 0, 0.2}, 0.6), 0.3);
  run(world, 0.4);
}

TEST(WorldState, AnotherWorldContinuesBitwiseFromItsBytes) {
  for (const auto integration :
       {contact::Integration::kFirstOrder, contact::Integration::kSecondOrder}) {
    World world(rich_scene(integration));
    reach_the_middle(world);
    const std::string bytes = world.save_bytes();
    const std::string first = trace(world, 0.6);
    World other(rich_scene(integration));
    other.restore_bytes(bytes);
    EXPECT_EQ(other.time(), 1.7);
    EXPECT_EQ(other.save_bytes(), bytes);
    EXPECT_EQ(trace(other, 0.6), first);
    // And again in the first, which has gone on.
    world.restore_bytes(bytes);
    EXPECT_EQ(trace(world, 0.6), first);
  }
}

TEST(WorldState, AFileIsWrittenAndReadBack) {
  const auto file = std::filesystem::temp_directory_path() /
                    ("prehend_world_" + std::to_string(getpid()) + ".state");
  World world(rich_scene());
  reach_the_middle(world);
  world.save_file(file);
  const std::string first = trace(world, 0.2);
  World other(rich_scene());
  other.restore_file(file);
  EXPECT_EQ(trace(other, 0.2), first);

  std::string bytes;
  {
    std::ifstream in(file, std::ios::binary);
    std::ostringstream all;
    all << in.rdbuf();
    bytes = all.str();
  }
  std::ofstream(file, std::ios::binary) << bytes.substr(0, bytes.size() - 1);
  EXPECT_THROW(other.restore_file(file), geometry::InputError) << "one byte short";
  std::ofstream(file, std::ios::binary) << "";
  EXPECT_THROW(other.restore_file(file), geometry::InputError) << "empty";
  std::filesystem::remove(file);
  EXPECT_THROW(other.restore_file(file), geometry::InputError) << "missing";
  EXPECT_THROW(other.restore_file(std::filesystem::temp_directory_path()), geometry::InputError);
  EXPECT_THROW(world.save_file("/nowhere/at/all"), geometry::InputError);
}

std::string error_of(World& world, const std::string& bytes) {
  const std::string before = world.save_bytes();
  try {
    world.restore_bytes(bytes, "run.state");
  } catch (const geometry::InputError& error) {
    EXPECT_EQ(world.save_bytes(), before) << "the world must be as it was";
    return error.what();
  }
  return "accepted";
}

TEST(WorldState, WhatIsForeignDamagedOrCutOffIsRefused) {
  World world(rich_scene());
  grasp(world, 1.0);
  const std::string bytes = world.save_bytes();
  run(world, 0.01);
  for (std::size_t length = 0; length < bytes.size(); length += 1 + length / 50) {
    const std::string error = error_of(world, bytes.substr(0, length));
    EXPECT_TRUE(error.find("run.state") == 0 && error.find("accepted") == std::string::npos)
        << length << ": " << error;
  }
  for (std::size_t at = 0; at < bytes.size(); at += 1 + bytes.size() / 97) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    EXPECT_NE(error_of(world, damaged), "accepted") << at;
  }
  EXPECT_NE(error_of(world, bytes + "x").find("after its end"), std::string::npos);
  EXPECT_NE(error_of(world, "objects: []\n").find("is no world-state"), std::string::npos);
  EXPECT_NE(error_of(world, command_bytes({})).find("is no world-state"), std::string::npos);
  std::string newer = bytes;
  newer[std::string("prehend world-state\n").size()] = 3;
  EXPECT_NE(error_of(world, newer).find("has version 3"), std::string::npos);

  const auto of_scene = [&](auto change) {
    Scene scene = rich_scene();
    change(scene);
    return error_of(world, World(scene).save_bytes());
  };
  EXPECT_NE(of_scene([](Scene& s) { s.objects.pop_back(); }).find("2 objects"), std::string::npos);
  EXPECT_NE(of_scene([](Scene& s) { s.objects[1].name = "tin"; }).find("'tin'"), std::string::npos);
  EXPECT_NE(of_scene([](Scene& s) { s.step = 0.002; }).find("another scene"), std::string::npos);
  EXPECT_NE(of_scene([](Scene& s) { s.objects[0].mass = 1; }).find("another scene"),
            std::string::npos);
  EXPECT_NE(of_scene([](Scene& s) { s.gripper.pad.rows = 7; }).find("another scene"),
            std::string::npos);
  EXPECT_NE(of_scene([](Scene& s) { s.tactile.sensor.noise = 1; }).find("another scene"),
            std::string::npos);
  EXPECT_EQ(of_scene([](Scene&) {}), "accepted");
}

// Commands of every kind, at odd moments.
void act(World& world) {
  world.set_gripper_command(GripperMode::kVelocity, -0.04, 0.4);
  run(world, 0.613);
  world.set_gripper_command(GripperMode::kCurrent, -1);
  run(world, 0.3);
  world.move_carrier(world.scene().carrier.gripper_pose({0, 0, 0.2}, 0.4), 0.2);
  geometry::TriangleMesh mesh = geometry::make_box({0.05, 0.06, 0.07});
  for (auto& v : mesh.vertices) v.x() += 0.3;
  world.add_object("late", mesh, 0.2);
  run(world, 0.137);
  world.stop_carrier();
  world.place_object(
      "can", geometry::make_transform(Eigen::Quaterniond(0.9, 0.1, 0, 0.2), {0.1, 0.25, 0.15}));
  run(world, 0.2);
  world.remove_object("bottle");
  world.set_gripper_command(GripperMode::kPosition, 0.06, 0, 0.03);
  world.move_carrier(world.scene().carrier.gripper_pose({0.1, 0, 0.25}, 0), 0.3);
  run(world, 0.2);
  world.set_gripper_command(GripperMode::kStop, 0);
}

TEST(WorldCommands, ARecordedRunReplaysBitwise) {
  World world(rich_scene());
  world.record_commands(true);
  act(world);
  const std::string bytes = command_bytes(world.recorded_commands());
  EXPECT_EQ(world.recorded_commands().size(), 10u);
  World other(rich_scene());
  const auto commands = read_commands(bytes);
  replay(commands, world.step_count(), other);
  EXPECT_EQ(other.save_bytes(), world.save_bytes());
  EXPECT_EQ(trace(other, 0.3), trace(world, 0.3));
  EXPECT_EQ(command_bytes(commands), bytes);
}

TEST(WorldCommands, ARunIsRepeatedFromASavedState) {
  World world(rich_scene());
  grasp(world, 1.0);
  const std::string start = world.save_bytes();
  world.record_commands(true);
  world.move_carrier(world.scene().carrier.gripper_pose({0, 0.1, 0.3}, 0), 0.3);
  run(world, 0.3);
  world.set_gripper_command(GripperMode::kCurrent, -2);
  run(world, 0.3);
  World other(rich_scene());
  other.restore_bytes(start);
  replay(world.recorded_commands(), world.step_count(), other);
  EXPECT_EQ(other.save_bytes(), world.save_bytes());
}

TEST(WorldCommands, WhatWasRefusedIsNotRecordedAndBadListsAreRefused) {
  World world(rich_scene());
  world.set_gripper_command(GripperMode::kStop, 0);
  world.record_commands(true);
  EXPECT_TRUE(world.recorded_commands().empty());
  EXPECT_THROW(world.set_gripper_command(GripperMode::kPosition, 1), std::invalid_argument);
  EXPECT_THROW(world.move_carrier(geometry::RigidTransform::Identity(), -1), std::invalid_argument);
  EXPECT_FALSE(world.remove_object("nothing"));
  EXPECT_TRUE(world.recorded_commands().empty());
  world.stop_carrier();
  world.record_commands(false);
  world.stop_carrier();
  EXPECT_EQ(world.recorded_commands().size(), 1u);

  std::vector<WorldCommand> commands = world.recorded_commands();
  run(world, 0.01);
  EXPECT_THROW(replay(commands, 100, world), std::invalid_argument) << "begins in the past";
  commands.push_back(commands[0]);
  commands[0].step = 50;
  commands[1].step = 40;
  EXPECT_THROW(replay(commands, 100, world), std::invalid_argument) << "not in order";
  const std::string bytes = command_bytes(commands);
  EXPECT_THROW(read_commands(bytes.substr(0, bytes.size() / 2)), geometry::InputError);
  EXPECT_THROW(read_commands(world.save_bytes()), geometry::InputError);
  commands[0].kind = static_cast<WorldCommand::Kind>(77);
  EXPECT_THROW(read_commands(command_bytes(commands)), geometry::InputError);
  EXPECT_THROW(apply(commands[0], world), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::simulation

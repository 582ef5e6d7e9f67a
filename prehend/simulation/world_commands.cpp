#include "prehend/simulation/world_commands.h"

#include <stdexcept>

#include "prehend/simulation/state_bytes.h"
#include "prehend/simulation/state_frame.h"

namespace prehend::simulation {
namespace {

constexpr std::string_view kCommandsKind = "world-commands";

template <class Archive>
void archive_command(Archive& archive, WorldCommand& c) {
  archive(c.step, c.kind, c.mode, c.value, c.current_limit, c.speed, c.pose.matrix(), c.path,
          c.name, c.mesh_W.vertices, c.mesh_W.triangles, c.mass, c.friction, c.is_static,
          c.texture.pattern, c.texture.color, c.texture.second_color, c.texture.contrast,
          c.texture.scale, c.texture.seed);
}

}  // namespace

void apply(const WorldCommand& command, World& world) {
  switch (command.kind) {
    case WorldCommand::Kind::kGripper:
      world.set_gripper_command(command.mode, command.value, command.current_limit, command.speed);
      return;
    case WorldCommand::Kind::kMoveCarrier:
      world.move_carrier(command.pose, command.speed);
      return;
    case WorldCommand::Kind::kDriveCarrier:
      world.drive_carrier(command.pose.translation(), command.value);
      return;
    case WorldCommand::Kind::kGuideCarrier:
      world.guide_carrier(command.path);
      return;
    case WorldCommand::Kind::kStopCarrier:
      world.stop_carrier();
      return;
    case WorldCommand::Kind::kAddObject:
      world.add_object(command.name, command.mesh_W, command.mass, command.is_static,
                       command.friction, command.texture);
      return;
    case WorldCommand::Kind::kRemoveObject:
      world.remove_object(command.name);
      return;
    case WorldCommand::Kind::kPlaceObject:
      world.place_object(command.name, command.pose);
      return;
  }
  throw std::invalid_argument("a world's command is of no known kind");
}

void replay(const std::vector<WorldCommand>& commands, std::int64_t last_step, World& world) {
  std::int64_t previous = world.step_count();
  for (const WorldCommand& command : commands) {
    if (command.step < previous) {
      throw std::invalid_argument("a command of step " + std::to_string(command.step) +
                                  " comes after step " + std::to_string(previous) + " has begun");
    }
    previous = command.step;
  }
  auto next = commands.begin();
  while (true) {
    for (; next != commands.end() && next->step == world.step_count(); ++next) apply(*next, world);
    if (world.step_count() >= last_step) return;
    world.step();
  }
}

std::string command_bytes(std::vector<WorldCommand> commands) {
  StateWriter writer;
  writer(static_cast<std::uint64_t>(commands.size()));
  for (WorldCommand& command : commands) archive_command(writer, command);
  return framed(kCommandsKind, writer.bytes());
}

std::vector<WorldCommand> read_commands(std::string_view bytes, const std::string& what) {
  StateReader reader(unframed(kCommandsKind, bytes, what), what);
  std::uint64_t count = 0;
  reader(count);
  std::vector<WorldCommand> commands;
  for (std::uint64_t i = 0; i < count; ++i) {
    WorldCommand& command = commands.emplace_back();
    archive_command(reader, command);
    const bool known = command.kind <= WorldCommand::Kind::kGuideCarrier &&
                       command.mode >= GripperMode::kStop &&
                       command.mode <= GripperMode::kVoltage &&
                       command.texture.pattern >= Texture::Pattern::kNoise &&
                       command.texture.pattern <= Texture::Pattern::kWood;
    if (!known) reader.fail("has a command of no known kind");
  }
  if (reader.left() != 0) reader.fail("goes on after its end");
  return commands;
}

}  // namespace prehend::simulation

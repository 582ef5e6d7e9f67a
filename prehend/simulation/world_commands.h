#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "prehend/simulation/world.h"

/// What was asked of a World, so that a run can be repeated: the same scene and the same commands
/// at the same steps give bitwise the same states.
namespace prehend::simulation {

struct WorldCommand {
  enum class Kind : std::uint8_t {
    kGripper,
    kMoveCarrier,
    kStopCarrier,
    kAddObject,
    kRemoveObject,
    kPlaceObject,
    kDriveCarrier,  // pose: its translation is the velocity; value: the yaw rate
    kGuideCarrier
  };
  std::int64_t step = 0;  // number of steps taken before it
  Kind kind = Kind::kGripper;
  GripperMode mode = GripperMode::kStop;                                 // kGripper
  double value = 0, current_limit = 0, speed = 0;                        // kGripper; speed: also
                                                                         // kMoveCarrier
  geometry::RigidTransform pose = geometry::RigidTransform::Identity();  // kMoveCarrier, kPlace
  CarrierPath path;                                                      // kGuideCarrier
  std::string name;                                                      // of the object
  geometry::TriangleMesh mesh_W;                                         // kAddObject
  double mass = 0, friction = 0;                                         // kAddObject
  bool is_static = false;                                                // kAddObject
  Texture texture;                                                       // kAddObject
};

/// Does what `command` asks, whatever its step. @throws as World's function does.
void apply(const WorldCommand& command, World& world);

/// Steps `world` until world.step_count() is `last_step`, giving each command before the step that
/// follows its own. @throws std::invalid_argument when the commands are not in order or begin
/// before the world's present step.
void replay(const std::vector<WorldCommand>& commands, std::int64_t last_step, World& world);

/// As bytes: a format of its own, with version and checksum, little-endian.
std::string command_bytes(std::vector<WorldCommand> commands);
/// @throws geometry::InputError naming `what`: foreign, of another version, damaged, cut off.
std::vector<WorldCommand> read_commands(std::string_view bytes,
                                        const std::string& what = "the command list");

}  // namespace prehend::simulation

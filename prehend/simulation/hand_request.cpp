#include "prehend/simulation/hand_request.h"

#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>

#include "prehend/text/nearest_match.h"

namespace prehend::simulation {
namespace {

[[noreturn]] void refuse_request(const std::string& what) { throw std::invalid_argument(what); }

// A hand's own names are its platform's without the prefix.
std::vector<int> motors_of(const RobotWorld& world, const std::vector<std::string>& joints) {
  const std::vector<std::string>& names = world.motor_names();
  std::vector<int> motors;
  for (const std::string& name : joints) {
    auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) found = std::find(names.begin(), names.end(), "hand_" + name);
    if (found == names.end()) {
      refuse_request(
          fmt::format("the hand has no motor '{}'{}", name, text::nearest_match_hint(name, names)));
    }
    const int motor = static_cast<int>(found - names.begin());
    if (std::find(motors.begin(), motors.end(), motor) != motors.end()) {
      refuse_request(fmt::format("joint '{}' is named twice", name));
    }
    motors.push_back(motor);
  }
  return motors;
}

}  // namespace

NamedHandCommand check_hand_request(const RobotWorld& world, const HandRequest& request) {
  const std::size_t count = request.joints.size();
  if (count == 0) refuse_request("the goal names no joint");
  if (request.positions.size() != count) {
    refuse_request(fmt::format("{} positions for {} joints", request.positions.size(), count));
  }
  if (!request.efforts.empty() && request.efforts.size() != count) {
    refuse_request(fmt::format("{} efforts for {} joints", request.efforts.size(), count));
  }
  NamedHandCommand named;
  HandCommand& command = named.command;
  command.speed = request.speed;
  command.until_contact = request.until_contact;
  command.position = world.hand().targets();
  command.effort = world.hand().most_efforts();
  named.motors = motors_of(world, request.joints);
  for (std::size_t i = 0; i < count; ++i) {
    command.position[named.motors[i]] = request.positions[i];
    if (!request.efforts.empty()) command.effort[named.motors[i]] = request.efforts[i];
  }
  return named;
}

MotorsCommand check_joints_request(const RobotWorld& world, const JointsRequest& request) {
  const bool stops = request.mode == robot::JointMode::kStop;
  if (!stops && request.joints.empty()) refuse_request("the command names no joint");
  if (stops && !request.values.empty()) refuse_request("values for joints that are to stop");
  if (!stops && request.values.size() != request.joints.size()) {
    refuse_request(
        fmt::format("{} values for {} joints", request.values.size(), request.joints.size()));
  }
  return {request.mode,
          motors_of(world, request.joints.empty() ? world.motor_names() : request.joints),
          request.values};
}

}  // namespace prehend::simulation

#include "prehend/simulation/hand_request.h"

#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>

#include "prehend/text/nearest_match.h"

namespace prehend::simulation {
namespace {

[[noreturn]] void refuse_request(const std::string& what) { throw std::invalid_argument(what); }

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
  const std::vector<std::string>& names = world.motor_names();
  for (std::size_t i = 0; i < count; ++i) {
    // A hand's own names are its platform's without the prefix.
    const std::string& name = request.joints[i];
    auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) found = std::find(names.begin(), names.end(), "hand_" + name);
    if (found == names.end()) {
      refuse_request(
          fmt::format("the hand has no motor '{}'{}", name, text::nearest_match_hint(name, names)));
    }
    const int motor = static_cast<int>(found - names.begin());
    if (std::find(named.motors.begin(), named.motors.end(), motor) != named.motors.end()) {
      refuse_request(fmt::format("joint '{}' is named twice", name));
    }
    named.motors.push_back(motor);
    command.position[motor] = request.positions[i];
    if (!request.efforts.empty()) command.effort[motor] = request.efforts[i];
  }
  return named;
}

}  // namespace prehend::simulation

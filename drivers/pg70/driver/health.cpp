#include "drivers/pg70/driver/health.h"

namespace prehend::drivers::pg70 {
namespace {

using Level = Health::Level;

constexpr double kPatience = 1;  // s of connecting that say nothing yet

Health connecting(const Situation& s) {
  if (!s.obstacle.empty()) return {Level::kError, s.obstacle};
  if (s.connecting < kPatience) return {Level::kOk, to_string(s.reading.state)};
  const std::string module = std::to_string(s.address.module);
  return {Level::kError, "module " + module + " does not answer on " + s.address.line +
                             ". Check its supply, wiring and termination, that its id is " +
                             module + ", and that its bit rate is that of the bus"};
}

Health of_state(const Situation& s) {
  switch (s.reading.state) {
    case DriverState::kDisconnected:
      if (!s.line_problem.empty()) return {Level::kError, s.line_problem};
      return {Level::kOk, to_string(s.reading.state)};  // it is too early to say
    case DriverState::kConnecting:
      return connecting(s);
    case DriverState::kLost:
      return {Level::kError,
              "the module's answers are missing; it is told to stop until it answers. Check supply "
              "and wiring"};
    case DriverState::kFault:
      return {Level::kError, describe_code(s.reading.error_code) +
                                 ". Take its cause away, then: prehend service call "
                                 "/gripper/acknowledge"};
    case DriverState::kUnreferenced:
      return {Level::kWarning,
              "unreferenced. With nothing between the jaws: prehend service call "
              "/gripper/reference"};
    default:
      return {Level::kOk, to_string(s.reading.state)};
  }
}

}  // namespace

Health health_of(const Situation& s) {
  Health health = of_state(s);
  if (s.reading.state > DriverState::kFault && s.reading.warning_code != 0) {
    health = with_warning(health, "the cause persists of " + describe_code(s.reading.warning_code) +
                                      ", which was acknowledged");
  }
  if (s.reading.state >= DriverState::kFault) health = with_warning(health, s.link_problem);
  return with_warning(health, s.guard_problem);
}

std::string own_stop(const Reading& reading) {
  switch (reading.state) {
    case DriverState::kDisconnected:
      return "the gripper's line is gone";
    case DriverState::kConnecting:
      return "the gripper does not answer yet";
    case DriverState::kLost:
      return "the gripper's answers are missing";
    case DriverState::kFault:
      if (reading.error_code == static_cast<std::uint8_t>(ErrorCode::kFastStop)) return {};
      return "the gripper stopped by itself: " + describe_code(reading.error_code);
    default:
      return {};
  }
}

}  // namespace prehend::drivers::pg70

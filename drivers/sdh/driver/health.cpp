#include "drivers/sdh/driver/health.h"

#include <algorithm>
#include <cstdio>

namespace prehend::drivers::sdh {
namespace {

using Level = Health::Level;

constexpr double kPatience = 1.5;  // s of connecting that say nothing yet

Health of_state(const Situation& s) {
  switch (s.reading.state) {
    case DriverState::kDisconnected:
      if (!s.line_problem.empty()) return {Level::kError, s.line_problem};
      return {Level::kOk, to_string(s.reading.state)};  // it is too early to say
    case DriverState::kConnecting:
      if (s.connecting < kPatience) return {Level::kOk, to_string(s.reading.state)};
      return {Level::kError, "the hand does not answer on " + s.line +
                                 ". Check its supply (24 V) and line; one that was on for long may "
                                 "be too hot to answer: switch it off and let it cool"};
    case DriverState::kLost:
      return {
          Level::kError,
          "the hand's answers are missing; it is told to stop until it answers. Check supply and "
          "line; one that is too hot does not answer either"};
    case DriverState::kFault:
      return {Level::kError,
              "an axis of the hand is not initialised. Switch its supply off and on"};
    default:
      return {Level::kOk, to_string(s.reading.state)};
  }
}

}  // namespace

Health health_of(const Situation& s) {
  Health health = of_state(s);
  if (s.reading.state <= DriverState::kFault) return health;
  if (s.reading.error_code != 0) {
    health =
        with_warning(health, "the last motion was refused: " + describe_code(s.reading.error_code));
  }
  if (!s.reading.temperatures.empty()) {
    const double hottest = std::ranges::max(s.reading.temperatures);
    char words[96];
    std::snprintf(words, sizeof words,
                  "%.0f degree Celsius hot: switch its axes off (/hand/off) while it is not used",
                  hottest);
    if (hottest >= s.hot) health = with_warning(health, words);
  }
  health = with_warning(health, s.guard_problem);
  return with_warning(health, s.link_problem);
}

std::string own_stop(const Reading& reading) {
  switch (reading.state) {
    case DriverState::kDisconnected:
      return "the hand's line is gone";
    case DriverState::kConnecting:
      return "the hand does not answer yet";
    case DriverState::kLost:
      return "the hand's answers are missing";
    case DriverState::kFault:
      return "an axis of the hand is not initialised: its supply was off";
    default:
      return {};
  }
}

}  // namespace prehend::drivers::sdh

#include "drivers/barrett/driver/health.h"

#include <algorithm>
#include <cstdio>

namespace prehend::drivers::barrett {
namespace {

using Level = Health::Level;

constexpr double kPatience = 1.5;  // s of connecting that say nothing yet

// Who does not answer.
std::string silent(const Reading& reading) {
  const auto answering = std::ranges::count(reading.answers, true);
  if (answering == 0 || answering == static_cast<std::ptrdiff_t>(kAxes))
    return "the hand does not answer";
  std::string names;
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (!reading.answers[i]) names += (names.empty() ? "" : ", ") + std::string(axis_name(i));
  }
  return "of the hand's pucks these do not answer: " + names;
}

Health of_state(const Situation& s) {
  const Health by_name{Level::kOk, to_string(s.reading.state)};
  switch (s.reading.state) {
    case DriverState::kDisconnected:
      if (!s.line_problem.empty()) return {Level::kError, s.line_problem};
      return by_name;  // it is too early to say
    case DriverState::kConnecting:
      if (s.connecting < kPatience) return by_name;
      return {
          Level::kError,
          silent(s.reading) + " on " + s.line +
              (s.model == Model::kBh8_280
                   ? ". Check its supply (48 V), wiring, termination and the bit rate "
                     "(1 Mbit/s)"
                   : ". Check its supply (24 V), the line and its rate (baud:=, as the hand has "
                     "it stored)")};
    case DriverState::kLost:
      return {Level::kError,
              std::string("the hand's answers are missing; it is told to stop until ") +
                  (s.model == Model::kBh8_280 ? "each puck answers. Check supply and bus"
                                              : "it answers. Check supply and line")};
    case DriverState::kFault:
      if (!s.reading.problem.empty()) return {Level::kError, s.reading.problem};
      return {Level::kError, "a puck of the hand is in error (ERROR " +
                                 std::to_string(s.reading.error_code) +
                                 "). Switch its supply off and on"};
    case DriverState::kUninitialised:
      return {Level::kWarning,
              "the hand is not initialised: with nothing between its fingers, call "
              "/hand/initialise"};
    default:
      return by_name;
  }
}

}  // namespace

Health health_of(const Situation& s) {
  Health health = of_state(s);
  if (s.reading.state <= DriverState::kFault) return health;
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (s.reading.gauge_fails[i]) {
      health = with_warning(
          health, std::string(axis_name(i)) + " has no strain gauge: only stalling ends its grip");
    }
    const double hottest = std::max(s.reading.motor_temperature[i].value_or(-1000),
                                    s.reading.puck_temperature[i].value_or(-1000));
    char words[96];
    std::snprintf(words, sizeof words,
                  "%s is %.0f degree Celsius hot: let it rest; its torque falls near 60",
                  axis_name(i), hottest);
    if (hottest >= s.hot) health = with_warning(health, words);
    if (s.reading.pad_fails[i]) {
      health = with_warning(
          health, std::string("the pad of ") + axis_name(i) + " is not initialised (TACTID -2)");
    }
  }
  if (const double celsius = s.reading.temperature.value_or(-1000); celsius >= s.hot) {
    char words[64];
    std::snprintf(words, sizeof words, "the hand is %.0f degree Celsius hot: let it rest", celsius);
    health = with_warning(health, words);
  }
  health = with_warning(health, s.guard_problem);
  return with_warning(health, s.link_problem);
}

std::string own_stop(const Reading& reading) {
  switch (reading.state) {
    case DriverState::kDisconnected:
      return "the hand's bus is gone";
    case DriverState::kConnecting:
      return "the hand does not answer yet";
    case DriverState::kLost:
      return "the hand's answers are missing";
    case DriverState::kFault:
      return reading.problem.empty()
                 ? "a puck of the hand is in error " + std::to_string(reading.error_code)
                 : reading.problem;
    default:
      return {};
  }
}

}  // namespace prehend::drivers::barrett

#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "drivers/barrett/codec/axes.h"
#include "drivers/wire/hand/hand_motion.h"
#include "drivers/wire/time/time.h"

namespace prehend::drivers::barrett {

/// The BH8-262 talks by a serial line (gcl/driver.h), the BH8-280 by CAN (driver.h).
enum class Model { kBh8_262, kBh8_280 };

/// Of each axis, as axes.h numbers them; what motors press with in the model's unit: MT of the
/// BH8-280, the motor command of the BH8-262.
using Limits = HandLimits<kAxes>;
using HandGoal = drivers::HandGoal<kAxes>;

/// When fingers and spread are driven to their open stops, which become zero (HI).
enum class Initialisation {
  kAsked,    // by initialise() alone
  kAtStart,  // by initialise(), and once after the first connection
  kDone,     // BH8-280: it was done before: the zero of a first connection is believed
};

/// What each state means for power and motion stands in the header of each model's driver.
enum class DriverState {
  kDisconnected,
  kConnecting,
  kLost,
  kFault,
  kUninitialised,
  kInitialising,
  kStanding,
  kMoving,
  kHolding,
};
/// "standing", "moving", ...
const char* to_string(DriverState state);

struct Reading {
  DriverState state = DriverState::kDisconnected;
  AxisValues position{};            // rad, of the motors, at their joints while clutches are closed
  AxisValues velocity{};            // rad/s
  AxisValues joint{};               // rad, of the inner joints behind the clutches, and the spread
  AxisValues joint_velocity{};      // rad/s
  bool has_joint_encoders = false;  // else `joint` is what closed clutches would give
  std::array<bool, kAxes> clutch_open{};
  std::array<bool, kAxes> blocked{};  // stands before its target, and presses
  AxisValues effort{};                // N m, of the strain gauges, from rest
  std::array<std::optional<double>, kAxes> motor_temperature{}, puck_temperature{};  // deg C
  std::optional<double> temperature;      // degree Celsius, of a hand that has one alone
  std::array<bool, kAxes> pad_fails{};    // TACTID tells that it is not initialised
  std::array<bool, kAxes> gauge_fails{};  // of a finger whose strain gauge is missing
  std::array<bool, kAxes> answers{};      // each axis, since the connection began
  bool moving = false;
  std::uint64_t states = 0;  // whole rounds of readings so far
  std::string firmware;      // empty until it is known
  std::string problem;       // of kFault, in words; empty: `error_code` of a puck
  int error_code = 0;        // ERROR of the puck in fault, or what the hand shows or said last

  bool is_blocked() const;
  bool is_connected() const { return state != DriverState::kDisconnected; }
  /// It tells its states.
  bool is_answering() const { return state >= DriverState::kFault; }
};

struct DriverCounters {
  std::uint64_t replies = 0;      // good ones
  std::uint64_t strange = 0;      // that nobody asked for, or show what cannot be
  std::uint64_t unanswered = 0;   // questions and orders that had to be repeated or were given up
  std::uint64_t connections = 0;  // beginnings of a connection
};

/// A BarrettHand's driver, whichever model, as its node sees it: a state machine over messages and
/// time that does no input or output itself. Call update() every few milliseconds. Not thread-safe.
/// Same calls, same behaviour.
class HandDriver {
 public:
  using Note = std::function<void(bool is_problem, const std::string& words)>;
  virtual ~HandDriver() = default;

  virtual void connected(Time now) = 0;
  virtual void disconnected(const std::string& why) = 0;
  /// Somebody else has used the line, or messages were lost: as after connected(), a stop comes
  /// first.
  virtual void begin_anew(const std::string& why, Time now) = 0;
  virtual void update(Time now) = 0;

  /// To positions, each axis by itself; one that stalls stays there and presses, the others go on.
  /// Returns why it was refused, or ""; report() knows the ticket until the next command.
  virtual std::string move_to(const HandGoal& goal, Time now, std::uint64_t& ticket) = 0;
  /// A continuous command to the axes of `moves`: `values` in rad or rad/s. Axes that still move
  /// `watchdog` later are stopped. Returns why it was refused, or "".
  virtual std::string command(CommandMode mode, const std::array<bool, kAxes>& moves,
                              const AxisValues& values, Time now) = 0;
  /// Opens fingers, then the spread, to their stops, which become zero. As move_to().
  virtual std::string initialise(Time now, std::uint64_t& ticket) = 0;
  virtual MotionReport report(std::uint64_t ticket) const = 0;
  /// Stops all axes. `why` becomes the reason of the motion that it ends. From then on the hand is
  /// initialised by initialise() alone, kAtStart or not.
  virtual void stop(Time now, const std::string& why) = 0;

  virtual const Reading& reading() const = 0;
  virtual const DriverCounters& counters() const = 0;
  /// Messages that came to harm.
  virtual std::uint64_t damaged() const = 0;
  /// Of an axis, for people: "position", "off, clutch open".
  virtual std::string axis_words(std::size_t axis) const = 0;
  virtual bool is_stopping() const = 0;
  /// Nothing moves or is on its way to, and no stop is under way.
  virtual bool is_settled() const = 0;
};

/// Why a hand in this state moves nothing; "": it may.
std::string refusal_of_motion(const Reading& reading, bool is_stopping);
/// What is wrong with a goal; "" when it is within the limits.
std::string refusal_of_goal(const HandGoal& goal, const Limits& limits);
/// @throws std::invalid_argument for limits that are none.
void check_limits(const Limits& limits);
/// "0.25", for words.
std::string number(double value);

}  // namespace prehend::drivers::barrett

#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

/// Schunk SDH-2 over RS-232 or TCP. Facts are from Schunk's SDHLibrary-CPP 0.0.2.10 and
/// SDHLibrary-Python (2014), which are all that is published: the firmware's manual is not.
namespace prehend::drivers::sdh {

/// 0: the pivot of fingers 1 and 3 (they turn opposite ways); 1, 2: proximal and distal joint of
/// finger 1; 3, 4: of finger 2, the thumb; 5, 6: of finger 3 (SDHLibrary-CPP, sdh.h).
inline constexpr std::size_t kAxes = 7;
inline constexpr double kDegree = M_PI / 180;  // rad
/// A value of each axis. On the wire in degree, degree/s, degree/s^2, A.
using AxisValues = std::array<double, kAxes>;

/// Commands that are used here, by their number in the binary form (SDHLibrary-CPP, sdhserial.cpp).
enum class Command : std::uint8_t {
  kSpeed = 0x80,              // v, deg/s: of the pose controller the greatest
  kActualSpeed = 0x81,        // vel
  kActualPosition = 0x83,     // pos
  kState = 0x84,              // state, AxisState
  kTarget = 0x85,             // p, deg; nothing moves until kMove
  kAcceleration = 0x86,       // a, deg/s^2
  kMove = 0x87,               // m
  kStop = 0x88,               // stop: halts all axes, controllers stay on
  kProfile = 0x89,            // vp: 0 sine-square, 1 ramp
  kController = 0x8A,         // con: 0 pose, 1 velocity, 2 velocity with ramp
  kTargetActual = 0x8B,       // tpap: sets p, returns pos
  kSpeedActual = 0x8C,        // tvav: sets v, returns vel
  kSpeedLimit = 0x8D,         // vlim
  kAccelerationLimit = 0x8E,  // alim
  kTemperature = 0x91,        // temp: 9 values, degree Celsius
  kVersion = 0x94,            // ver
  kDuration = 0x9C,           // get_duration
  kGripCurrent = 0x9D,        // igrip, A
  kHoldCurrent = 0x9E,        // ihold, A
  kSelectGrip = 0x9F,         // selgrip: 0 to 3
  kGrip = 0xA0,               // grip: how far closed, deg/s; no stop ends it
  kCurrentLimit = 0xA3,       // ilim, A
  kPower = 0xA4,              // power: 0, 1
};
/// "pos"; null for a number that is none of these.
const char* to_string(Command command);
/// By its name in any case.
std::optional<Command> command_named(std::string_view name);

/// Of an axis (SDHLibrary-CPP, sdh.h, eAxisState).
enum class AxisState : std::uint8_t {
  kIdle = 0,
  kPositioning = 1,
  kSpeed = 2,
  kNotInitialised = 3,
  kBlockedClockwise = 4,
  kBlockedCounterClockwise = 5,
  kDisabled = 6,
  kLimitReached = 7,
};
inline constexpr std::uint8_t kLastAxisState = 7;

/// What refuses a command (SDHLibrary-CPP, sdhserial.h, eReturnCode); those that are used here.
enum class ReturnCode : std::uint8_t {
  kOk = 0,
  kChecksum = 10,
  kTooFewParameters = 11,
  kUnknownCommand = 13,
  kCommandFormat = 14,
  kInvalidParameter = 23,
  kRange = 24,
  kIndex = 26,
  kAxisDisabled = 28,
  kOverTemperature = 29,
  kLineTooLong = 32,
};
inline constexpr std::uint8_t kLastReturnCode = 36;
/// "E29 over-temperature".
std::string describe_code(std::uint8_t code);

}  // namespace prehend::drivers::sdh

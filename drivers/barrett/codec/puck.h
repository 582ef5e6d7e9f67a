#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "drivers/barrett/codec/axes.h"

/// BarrettHand BH8-280 over CAN: four motor controllers, "pucks", each a node of the bus. Facts are
/// from libbarrett, pyHand (RobotnikAutomation/barrett_hand), Barrett's BHand API 4.4.3 and the
/// BH8-series manual of firmware 4.4; numbers of properties hold from firmware 145 on.
namespace prehend::drivers::barrett {

inline constexpr std::uint8_t kHost = 0, kFirstPuck = 11;  // nodes
inline constexpr unsigned kBitRate = 1000000;              // bit/s

/// What a puck is asked for or told to be. Those of kWide have 32 bits, the others 16.
enum class Property : std::uint8_t {
  kVersion = 0,
  kRole = 1,
  kSerial = 2,
  kError = 4,
  kStatus = 5,       // Status
  kMode = 8,         // Mode
  kTemperature = 9,  // degree Celsius, of the puck
  kMostTemperature = 11,
  kThermistor = 20,  // degree Celsius, of the motor's winding
  kStrain = 25,      // 0..4095
  kCommand = 29,     // Command
  kTorque = 42,
  kMostTorque = 43,
  kVelocity = 44,         // counts/ms
  kMostVelocity = 45,     // counts/ms, of a motion to a target
  kPosition = 48,         // counts
  kDefaultPosition = 50,  // counts: where Command::kMove goes
  kEnd = 52,              // counts: of Mode::kTrapezoid
  kMove = 58,             // counts: setting it starts a motion to there
  kUptime = 63,           // s, since power-on
  kInitialVelocity = 73,  // counts/ms, of Command::kInitialise; negative opens
  kHold = 77,             // 1: ends in Mode::kPosition, 0: in kIdle
  kStallTime = 78,        // ms of standing before a target, then the motor is off; 0: never
  kAcceleration = 82,     // 1/256 counts/ms^2
  kJointPosition = 96,    // counts of the encoder behind the clutch
  kTactile = 106,         // 1 the top ten cells, 2 all, 3 tare
  kTactileId = 107,       // -2: the pad is not initialised
};
inline constexpr std::uint8_t kProperties = 128;
bool is_wide(std::uint8_t property);

enum class Status : std::uint8_t { kMonitor = 0, kError = 1, kReady = 2 };

enum class Mode : std::uint8_t {
  kIdle = 0,  // phases shorted: brakes
  kDuty = 1,
  kTorque = 2,
  kPosition = 3,  // holds
  kVelocity = 4,
  kTrapezoid = 5,  // to kEnd
};
inline constexpr std::uint8_t kLastMode = 5;

enum class Command : std::uint8_t {
  kReset = 2,
  kInitialise = 13,  // HI: to the open stop, which becomes zero
  kClose = 18,
  kMove = 19,  // to kDefaultPosition
  kOpen = 20,
  kOff = 21,  // T
};

/// Groups that pucks send to (libbarrett, bus_manager.h and puck.h).
enum class Group : std::uint8_t { kPosition = 3, kReply = 6, kTactileAll = 9 };

inline constexpr std::uint8_t kTactileFull = 2;
inline constexpr std::int16_t kPadNotInitialised = -2;
inline constexpr std::size_t kCells = 24;   // of a pad
inline constexpr double kCellCounts = 256;  // per N/cm^2
inline constexpr std::uint16_t kMostCellCount = 4095;

/// An identifier: kToGroup where a group is addressed, the sender from kSenderShift on, the
/// receiver.
inline constexpr unsigned kToGroup = 0x400, kSenderShift = 5, kReceiverMask = 0x1F;
/// Of what a puck sends to `group`, and of what the host sends to puck number `axis`.
std::uint16_t reply_identifier(std::size_t axis, Group group);
std::uint16_t request_identifier(std::size_t axis);

/// "MODE" as in Barrett's lists; null for a number that is none of Property's.
const char* to_string(Property property);
std::optional<Property> property_named(std::string_view name);

}  // namespace prehend::drivers::barrett

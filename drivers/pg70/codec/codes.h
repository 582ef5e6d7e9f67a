#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace prehend::drivers::pg70 {

/// Command codes of the Schunk Motion Protocol (Schunk Motion Control manual V1.41; agrees with the
/// public clients spatialaudio/schunk and ipa320/schunk_gripper_egl90).
enum class Command : std::uint8_t {
  kGetConfig = 0x80,
  kSetConfig = 0x81,
  kGetConfigExtended = 0x82,
  kSetConfigExtended = 0x83,
  kFragmentStart = 0x84,
  kFragmentMiddle = 0x85,
  kFragmentEnd = 0x86,
  kFragmentAcknowledge = 0x87,  // Profibus only
  kError = 0x88,                // impulse: fault, motor off
  kWarning = 0x89,              // impulse: acknowledged, the cause persists
  kInfo = 0x8A,                 // impulse
  kAcknowledge = 0x8B,
  kFastStop = 0x90,
  kStop = 0x91,
  kReference = 0x92,
  kMoveBlocked = 0x93,      // impulse: ended before the target
  kPositionReached = 0x94,  // impulse
  kGetState = 0x95,
  kGetDetailedError = 0x96,
  kReferenceHand = 0x97,
  kSetTargetVelocity = 0xA0,
  kSetTargetAcceleration = 0xA1,
  kSetTargetJerk = 0xA2,
  kSetTargetCurrent = 0xA3,
  kSetTargetTime = 0xA4,
  kSetTargetPosition = 0xA6,
  kSetTargetPositionRelative = 0xA7,
  kMovePosition = 0xB0,
  kMovePositionTime = 0xB1,
  kMoveCurrent = 0xB3,
  kMoveVelocity = 0xB5,
  kMoveGrip = 0xB7,
  kMovePositionRelative = 0xB8,
  kMovePositionTimeRelative = 0xB9,
  kReboot = 0xE0,
  kChangeUser = 0xE3,
  kCheckMasterToModule = 0xE4,
  kCheckModuleToMaster = 0xE5,
  kToggleImpulse = 0xE7,
};

/// Information codes: why a command was refused (a response with D-Len 2), or what CMD INFO says.
enum class InfoCode : std::uint8_t {
  kBoot = 0x01,
  kNoFreeSpace = 0x02,
  kNoRights = 0x03,
  kUnknownCommand = 0x04,
  kFailed = 0x05,
  kNotReferenced = 0x06,
  kSearchSineVector = 0x07,
  kNoError = 0x08,
  kCommunicationError = 0x09,
  kTimeout = 0x10,
  kUnknownAxisIndex = 0x11,
  kWrongBaudRate = 0x16,
  kChecksum = 0x19,
  kValueAboveMaximum = 0x1B,
  kValueBelowMinimum = 0x1C,  // inferred from 0x1B; no source read names it
  kMessageLength = 0x1D,
  kWrongParameter = 0x1E,
  kProgramEnd = 0x1F,
  kTrigger = 0x40,
  kReady = 0x41,
  kGuiConnected = 0x42,
  kGuiDisconnected = 0x43,
  kProgramChanged = 0x44,
};

/// Error codes: the second byte of GET STATE, CMD ERROR and CMD WARNING.
enum class ErrorCode : std::uint8_t {
  kNone = 0x00,
  kTemperatureLow = 0x70,
  kTemperatureHigh = 0x71,
  kLogicVoltageLow = 0x72,
  kLogicVoltageHigh = 0x73,
  kMotorVoltageLow = 0x74,
  kMotorVoltageHigh = 0x75,
  kCableBreak = 0x76,
  kMotorTemperature = 0x78,
  kOvershoot = 0x82,
  kWrongRampType = 0xC8,
  kConfigMemory = 0xD2,
  kProgramMemory = 0xD3,
  kInvalidPhrase = 0xD4,
  kSoftLow = 0xD5,
  kSoftHigh = 0xD6,
  kPressure = 0xD7,
  kService = 0xD8,
  kFastStop = 0xD9,
  kTow = 0xDA,
  kVpc3 = 0xDB,
  kFragmentation = 0xDC,
  kCommutation = 0xDD,
  kCurrent = 0xDE,
  kI2t = 0xDF,
  kInitialize = 0xE0,
  kInternal = 0xE1,
  kHardLow = 0xE2,
  kHardHigh = 0xE3,
  kTooFast = 0xE4,
  kResolverCheckEgl = 0xE5,  // EGL-90 driver; other clients have the same fault at 0xEB
  kResolverCheck = 0xEB,
  kMath = 0xEC,
};

/// A code with the manual's name and what it means and asks for, in words.
struct CodeText {
  std::uint8_t code = 0;
  const char* name = "";   ///< as in the manual, e.g. "ERROR TOW"
  const char* words = "";  ///< one line for a person
};

/// All codes that are known, sorted by code.
std::span<const CodeText> command_texts();
std::span<const CodeText> info_texts();
std::span<const CodeText> error_texts();

/// "ERROR TOW (0xDA): the drive could not follow ..."; a code nobody knows: "unknown code 0x55".
/// `describe_code` looks among errors first, then among information: the two share no code.
std::string describe_code(std::uint8_t code);
/// "MOVE POS"; of an unknown one "command 0x55".
std::string command_name(std::uint8_t command);

}  // namespace prehend::drivers::pg70

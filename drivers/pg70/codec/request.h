#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "drivers/pg70/codec/codes.h"
#include "drivers/pg70/codec/message.h"

namespace prehend::drivers::pg70 {

// What a master asks of a module, typed. Units are those of the module's unit system (mm, mm/s,
// mm/s^2, A, s by default); conversion to SI is the driver's. Floats are IEEE-754 binary32.

/// A command without parameters: CMD ACK, STOP, FAST STOP, REFERENCE, REFERENCE HAND, GET DETAILED
/// ERROR INFO, REBOOT, TOGGLE IMPULSE MESSAGE.
struct PlainRequest {
  Command command = Command::kStop;
  friend bool operator==(const PlainRequest&, const PlainRequest&) = default;
};

/// SET TARGET VEL, ACC, JERK, CUR, TIME, POS, POS REL: in force until changed or restarted.
struct SetTarget {
  Command command = Command::kSetTargetVelocity;
  float value = 0;
  friend bool operator==(const SetTarget&, const SetTarget&) = default;
};

/// Any MOVE command. `values[0]` is its target; the optional ones that follow (MOVE POS: velocity,
/// acceleration, current, jerk; MOVE POS TIME: velocity, acceleration, current, time; MOVE VEL:
/// current) may be left out only from the end.
struct Move {
  static constexpr int kMostValues = 5;
  Command command = Command::kMovePosition;
  std::uint8_t count = 1;  // of values, 1..kMostValues
  std::array<float, kMostValues> values{};
  friend bool operator==(const Move&, const Move&) = default;
};
/// Most values that a MOVE command takes; 0 for other commands.
int most_values(Command command);

/// What GET STATE reports, as a bit mask.
enum StateMode : std::uint8_t {
  kWithPosition = 0x01,
  kWithVelocity = 0x02,
  kWithCurrent = 0x04,
  kWithAll = 0x07,
};

/// GET STATE. Empty: once, with the mode last given (and, as public clients use it, the end of a
/// cyclic transmission). Else every `period` seconds (0: once) what `mode` says.
struct GetState {
  struct Cycle {
    float period = 0;
    std::uint8_t mode = 0;
    friend bool operator==(const Cycle&, const Cycle&) = default;
  };
  std::optional<Cycle> cycle;
  friend bool operator==(const GetState&, const GetState&) = default;
};

/// GET CONFIG of one parameter, or (empty) of the device's facts.
struct GetConfig {
  std::optional<std::uint8_t> parameter;
  friend bool operator==(const GetConfig&, const GetConfig&) = default;
};

/// SET CONFIG; the value's type depends on the parameter (ConfigParameter).
struct SetConfig {
  std::uint8_t parameter = 0;
  std::vector<std::uint8_t> value;  // 1..253 bytes
  friend bool operator==(const SetConfig&, const SetConfig&) = default;
};

/// A command with parameters that this codec does not take apart (GET/SET CONFIG EXT, CHANGE USER,
/// the communication tests, codes nobody knows), or whose length fits no layout above.
struct OtherRequest {
  Content content;
  friend bool operator==(const OtherRequest&, const OtherRequest&) = default;
};

using Request =
    std::variant<PlainRequest, SetTarget, Move, GetState, GetConfig, SetConfig, OtherRequest>;

/// @throws std::invalid_argument when a Move has a count that its command does not take,
/// std::length_error beyond 255 bytes.
Content encode(const Request& request);

/// The typed form of a command. `content` is not empty. Everything decodes: what fits no layout is
/// an OtherRequest, and encode(decode_request(c)) == c always.
Request decode_request(const Content& content);

/// Ids of configuration parameters (manual V1.41 after spatialaudio/schunk).
enum class ConfigParameter : std::uint8_t {
  kModuleId = 0x01,           // u8
  kGroupId = 0x02,            // u8
  kSerialBaudRate = 0x03,     // u16
  kCanBitRate = 0x04,         // u16, kbit/s
  kCommunicationMode = 0x05,  // u8: 0 auto, 1 serial, 2 CAN, 3 Profibus, 4 serial silent
  kUnitSystem = 0x06,         // u8, see UnitSystem
  kSoftHigh = 0x07,           // f32
  kSoftLow = 0x08,            // f32
  kMaximumVelocity = 0x09,    // f32
  kMaximumAcceleration = 0x0A,
  kMaximumCurrent = 0x0B,
  kNominalCurrent = 0x0C,
  kMaximumJerk = 0x0D,
  kReferenceOffset = 0x14,
  kSerialNumber = 0x15,  // u32
  kOrderNumber = 0x16,   // u32
  kGearRatio = 0x18,
};

/// Unit systems with float values; 6..9 are integer systems (um, udeg, uinch, mdeg).
enum class UnitSystem : std::uint8_t {
  kMillimetre = 0,
  kMetre = 1,
  kInch = 2,
  kRadian = 3,
  kDegree = 4,
  kInternal = 5,
};

}  // namespace prehend::drivers::pg70

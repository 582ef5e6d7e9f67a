#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "drivers/pg70/codec/codes.h"
#include "drivers/pg70/codec/message.h"

namespace prehend::drivers::pg70 {

// What a module says, typed. Units as in request.h.

/// D-Len 2 to a command: it was refused. (A success never has D-Len 2; manual, STM-48V, page 59.)
struct Refusal {
  Command command = Command::kStop;
  InfoCode reason = InfoCode::kFailed;
  friend bool operator==(const Refusal&, const Refusal&) = default;
};

/// "OK".
struct Confirmation {
  Command command = Command::kStop;
  friend bool operator==(const Confirmation&, const Confirmation&) = default;
};

/// A motion to a position has begun and will take about so long [s].
struct MoveStarted {
  Command command = Command::kMovePosition;
  float duration = 0;
  friend bool operator==(const MoveStarted&, const MoveStarted&) = default;
};

/// Status byte of GET STATE, as bits.
enum StatusBit : std::uint8_t {
  kReferenced = 0x01,
  kMoving = 0x02,
  kProgramMode = 0x04,
  kWarningPresent = 0x08,
  kErrorPresent = 0x10,
  kBrakeApplied = 0x20,  // the manual's examples contradict one another on its sense
  kMoveEnded = 0x40,
  kPositionWasReached = 0x80,
};

/// Answer to GET STATE. Which floats are there depends on the mode asked for.
struct State {
  std::optional<float> position;
  std::optional<float> velocity;
  std::optional<float> current;
  std::uint8_t status = 0;  // StatusBit
  std::uint8_t error = 0;   // ErrorCode, 0: none
  friend bool operator==(const State&, const State&) = default;
};

/// Answer to GET DETAILED ERROR INFO.
struct DetailedError {
  Command kind = Command::kError;  // kError, kWarning or kInfo
  std::uint8_t code = 0;
  float data = 0;
  friend bool operator==(const DetailedError&, const DetailedError&) = default;
};

/// Spontaneous: a motion ended before its target (kMoveBlocked) or at it (kPositionReached).
struct MotionEnd {
  Command kind = Command::kPositionReached;
  float position = 0;
  friend bool operator==(const MotionEnd&, const MotionEnd&) = default;
};

/// Spontaneous: CMD INFO. Two bytes on purpose, so that D-Len is not 2.
struct Info {
  std::uint16_t code = 0;  // InfoCode
  friend bool operator==(const Info&, const Info&) = default;
};

/// Spontaneous: CMD ERROR (kError: motor off, repeated every 15 s until acknowledged) or CMD
/// WARNING (kWarning: repeated every 30 s until the cause is gone).
struct Fault {
  Command kind = Command::kError;
  ErrorCode code = ErrorCode::kNone;
  friend bool operator==(const Fault&, const Fault&) = default;
};

/// Answer to GET CONFIG of one parameter.
struct ConfigValue {
  std::uint8_t parameter = 0;
  std::vector<std::uint8_t> value;
  friend bool operator==(const ConfigValue&, const ConfigValue&) = default;
};

/// Answer to SET CONFIG: "OK" and the parameter.
struct ConfigSet {
  std::uint8_t parameter = 0;
  friend bool operator==(const ConfigSet&, const ConfigSet&) = default;
};

/// Answer to GET CONFIG without a parameter (layout after spatialaudio/schunk, 44 bytes).
struct DeviceFacts {
  std::array<char, 8> type{};
  std::uint32_t order_number = 0;
  std::uint16_t firmware = 0;  // probably 100 * major + minor, e.g. 141
  std::uint16_t protocol = 0;
  std::uint16_t hardware = 0;
  std::array<char, 21> date{};
  std::array<std::uint8_t, 5> undocumented{};
  friend bool operator==(const DeviceFacts&, const DeviceFacts&) = default;
};

/// Answer to CMD TOGGLE IMPULSE MESSAGE.
struct ImpulseMessages {
  bool on = true;
  friend bool operator==(const ImpulseMessages&, const ImpulseMessages&) = default;
};

/// Answer to CHANGE USER: 0 user, 1 diagnostics, 2 profi, 3 advanced.
struct UserChanged {
  std::uint8_t user = 0;
  friend bool operator==(const UserChanged&, const UserChanged&) = default;
};

/// What fits no layout above.
struct OtherResponse {
  Content content;
  friend bool operator==(const OtherResponse&, const OtherResponse&) = default;
};

using Response =
    std::variant<Refusal, Confirmation, MoveStarted, State, DetailedError, MotionEnd, Info, Fault,
                 ConfigValue, ConfigSet, DeviceFacts, ImpulseMessages, UserChanged, OtherResponse>;

/// @throws std::length_error beyond 255 bytes.
Content encode(const Response& response);

/// The typed form of what a module said. `state_mode` (StateMode bits) is that of the last GET
/// STATE: which of the three a single or two floats are is known from it only; where the number of
/// floats contradicts it the state is taken as position, velocity, current in this order.
/// Everything decodes, and encode(decode_response(c, mode)) == c always.
Response decode_response(const Content& content, std::uint8_t state_mode);

/// Which direction the response goes out under: kError for CMD ERROR and WARNING, else kResponse.
Direction direction_of(const Response& response);

}  // namespace prehend::drivers::pg70

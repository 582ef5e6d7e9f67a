#include "drivers/sdh/codec/codes.h"

#include <algorithm>
#include <cctype>

namespace prehend::drivers::sdh {
namespace {

struct CommandName {
  Command command;
  const char* name;
};

constexpr CommandName kCommandNames[] = {
    {Command::kSpeed, "v"},
    {Command::kActualSpeed, "vel"},
    {Command::kActualPosition, "pos"},
    {Command::kState, "state"},
    {Command::kTarget, "p"},
    {Command::kAcceleration, "a"},
    {Command::kMove, "m"},
    {Command::kStop, "stop"},
    {Command::kProfile, "vp"},
    {Command::kController, "con"},
    {Command::kTargetActual, "tpap"},
    {Command::kSpeedActual, "tvav"},
    {Command::kSpeedLimit, "vlim"},
    {Command::kAccelerationLimit, "alim"},
    {Command::kTemperature, "temp"},
    {Command::kVersion, "ver"},
    {Command::kDuration, "get_duration"},
    {Command::kGripCurrent, "igrip"},
    {Command::kHoldCurrent, "ihold"},
    {Command::kSelectGrip, "selgrip"},
    {Command::kGrip, "grip"},
    {Command::kCurrentLimit, "ilim"},
    {Command::kPower, "power"},
};

constexpr const char* kCodes[kLastReturnCode + 1] = {"ok",
                                                     "not available",
                                                     "not initialised",
                                                     "already running",
                                                     "not supported",
                                                     "inconsistent data",
                                                     "timeout",
                                                     "read error",
                                                     "write error",
                                                     "out of resources",
                                                     "wrong checksum",
                                                     "too few parameters",
                                                     "no parameters expected",
                                                     "unknown command",
                                                     "wrong command format",
                                                     "access denied",
                                                     "already open",
                                                     "command failed",
                                                     "aborted",
                                                     "invalid handle",
                                                     "device not found",
                                                     "device not open",
                                                     "input or output error",
                                                     "invalid parameter",
                                                     "out of range",
                                                     "no data path",
                                                     "index out of bounds",
                                                     "homing error",
                                                     "axis disabled",
                                                     "over-temperature",
                                                     "too many commands",
                                                     "wrong password",
                                                     "command line too long",
                                                     "wrong CRC",
                                                     "no command",
                                                     "internal error",
                                                     "unknown error"};

}  // namespace

const char* to_string(Command command) {
  for (const CommandName& known : kCommandNames) {
    if (known.command == command) return known.name;
  }
  return nullptr;
}

std::optional<Command> command_named(std::string_view name) {
  for (const CommandName& known : kCommandNames) {
    const std::string_view own = known.name;
    const bool is_same = std::ranges::equal(own, name, [](char a, char b) {
      return a == static_cast<char>(std::tolower(static_cast<unsigned char>(b)));
    });
    if (is_same) return known.command;
  }
  return std::nullopt;
}

std::string describe_code(std::uint8_t code) {
  const std::string number = "E" + std::to_string(code);
  return code <= kLastReturnCode ? number + " " + kCodes[code] : number + " unknown";
}

}  // namespace prehend::drivers::sdh

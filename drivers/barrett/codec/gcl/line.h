#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/barrett/codec/axes.h"

/// BarrettHand BH8-262 over RS-232: Grasper Control Language (GCL). Facts are from the BH8-series
/// manuals of firmware 4.3x (D3000 AF.00, 2007) and 4.4.x, Barrett's BHand API, and the public
/// drivers BarrettHand826X (YARP), handif (Hsiao, Glashan) and gripper::barrett.
namespace prehend::drivers::barrett::gcl {

inline constexpr char kAbort = 0x03;  // Ctrl-C: ends what runs, all motors stop
inline constexpr std::string_view kPrompt = "=> ";
inline constexpr std::string_view kEndOfLine = "\n\r";  // in this order (YARP, gripper::barrett)
inline constexpr char kLooping = '*';                   // RealTime mode begins, or a block does
inline constexpr std::size_t kLongestLine = 256;        // that is sent; not published
inline constexpr std::size_t kLongestReply = 4096;      // FLISTV's is not published
inline constexpr std::array<unsigned, 7> kBauds{600, 1200, 2400, 4800, 9600, 19200, 38400};
inline constexpr unsigned kBaud = 9600;  // of a hand as it is delivered

/// What status words and ERR are made of, as sums (BHAPI; YARP and gripper::barrett agree).
enum Status : int {
  kNoBoard = 1,
  kNoMotor = 2,
  kNotInitialised = 4,
  kNotReached = 16,
  kUnknownCommand = 32,
  kUnknownProperty = 64,
  kInvalidValue = 128,
  kReadOnly = 256,
  kTooManyArguments = 1024,
  kInvalidHeader = 2048,
  kTakesNoMotors = 4096,
  kOverTemperature = 8192,
  kAborted = 16384,
};
/// "ERR 16 could not reach its position".
std::string describe_status(int status);

/// `12FSET LCV 1 LCVC 1`: motors, a command, words.
struct Request {
  std::array<bool, kAxes> motors{};  // none: those that are enabled
  std::string command;               // upper case
  std::vector<std::string> words{};  // upper case

  bool has_motors() const;
  friend bool operator==(const Request&, const Request&) = default;
};
/// Without its CR. Digits 1 to 4 before the command name the motors.
std::string encode(const Request& request);
/// Of a line without its CR, in any case; G before a command is 123, S is 4. An empty line is a
/// request without a command. Nothing for what has other than printable characters.
std::optional<Request> decode_request(std::string_view line);

/// What came back on a line, behind its echo.
struct Reply {
  enum class Kind {
    kPending,  // not whole yet
    kDone,     // up to the prompt
    kLoops,    // RealTime mode began
    kDamaged,  // another echo than what was sent, or more than can be
  };
  Kind kind = Kind::kPending;
  std::vector<std::string> lines{};  // without those of ERR
  int error = 0;                     // sum of all ERR

  bool is_good() const { return kind == Kind::kDone && error == 0; }
};
/// `received` since `sent` was sent, which had no CR. Line ends may be LF CR or CR LF.
Reply parse_reply(std::string_view received, std::string_view sent);

/// Whole numbers with blanks between and nothing else; empty: it is something else.
std::vector<int> integers_of(std::string_view text);

/// True when the text ends in a prompt at the beginning of a line.
bool ends_in_prompt(std::string_view received);
/// The sum of all `ERR n` lines.
int errors_in(std::string_view received);

}  // namespace prehend::drivers::barrett::gcl

#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/sdh/codec/codes.h"

namespace prehend::drivers::sdh {

/// Lines are no longer than the client's buffer (SDHLibrary-CPP, sdhserial.h).
inline constexpr std::size_t kLongestLine = 256;
inline constexpr std::size_t kMostValues = 9;  // of `temp`

/// `name`, `name(axis)`, `name=v,v,...`: what the computer says.
struct LineRequest {
  std::string name;  // lower case
  std::optional<int> axis{};
  std::vector<double> values{};  // none: it asks

  friend bool operator==(const LineRequest&, const LineRequest&) = default;
};

/// `NAME`, `NAME(axis)=text`, or `E` and a code: what the hand says.
struct LineReply {
  std::optional<std::uint8_t> error{};  // then all else is empty
  std::string name{};                   // upper case
  std::optional<int> axis{};
  std::optional<std::string> text{};  // behind the =

  friend bool operator==(const LineReply&, const LineReply&) = default;
};

/// With CR LF. Values as the vendor's library has them: %f for axes, %d where `as_integers`.
std::string encode(const LineRequest& request, bool as_integers = false);
std::string encode(const LineReply& reply);

/// A line without its CR LF. Blanks are allowed round = and numbers: the vendor's %12.3f makes
/// them. Nothing for what is no command: the hand answers that with kCommandFormat.
std::optional<LineRequest> decode_line_request(std::string_view line);
/// A line without its CR LF, as encode() makes it, but for its end.
std::optional<LineReply> decode_line_reply(std::string_view line);

/// The finite numbers that `text` begins with, separated by commas; what follows the last one is
/// not looked at (`M=4.51s`). Empty: it begins with none, or has more than kMostValues.
std::vector<double> numbers_of(std::string_view text);

}  // namespace prehend::drivers::sdh

#include "drivers/barrett/codec/gcl/line.h"

#include <algorithm>
#include <cctype>
#include <charconv>

namespace prehend::drivers::barrett::gcl {
namespace {

constexpr std::string_view kError = "ERR ";

char upper(char c) { return static_cast<char>(std::toupper(static_cast<unsigned char>(c))); }

std::vector<std::string_view> words_of(std::string_view text) {
  std::vector<std::string_view> words;
  while (true) {
    const std::size_t begin = text.find_first_not_of(' ');
    if (begin == std::string_view::npos) return words;
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    words.push_back(text.substr(begin, end - begin));
    text.remove_prefix(end);
  }
}

std::optional<int> integer(std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// Whole lines, and what follows the last of them. LF ends a line, CR is on either side of it.
struct Lines {
  std::vector<std::string> whole;
  std::string rest;
};
Lines lines_of(std::string_view text) {
  Lines lines;
  for (const char c : text) {
    if (c == '\n') {
      lines.whole.push_back(std::move(lines.rest));
      lines.rest.clear();
    } else if (c != '\r') {
      lines.rest += c;
    }
  }
  return lines;
}

// Of "ERR n"; 0: it is something else.
int error_of(std::string_view line) {
  return line.starts_with(kError) ? integer(line.substr(kError.size())).value_or(0) : 0;
}

}  // namespace

std::string describe_status(int status) {
  struct Words {
    int bit;
    const char* text;
  };
  constexpr Words kWords[] = {{kNoBoard, "a motor board is missing"},
                              {kNoMotor, "a motor is missing"},
                              {kNotInitialised, "it is not initialised"},
                              {kNotReached, "it could not reach its position"},
                              {kUnknownCommand, "unknown command"},
                              {kUnknownProperty, "unknown property"},
                              {kInvalidValue, "invalid value"},
                              {kReadOnly, "the property is read-only"},
                              {kTooManyArguments, "too many arguments"},
                              {kInvalidHeader, "invalid RealTime header"},
                              {kTakesNoMotors, "the command takes no motors"},
                              {kOverTemperature, "over-temperature"},
                              {kAborted, "Ctrl-C"}};
  std::string text = "ERR " + std::to_string(status);
  const char* separator = " ";
  for (const Words& words : kWords) {
    if ((status & words.bit) == 0) continue;
    text += separator + std::string(words.text);
    separator = ", ";
  }
  return text;
}

bool Request::has_motors() const {
  return std::ranges::any_of(motors, [](bool on) { return on; });
}

std::string encode(const Request& request) {
  std::string line;
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (request.motors[i]) line += static_cast<char>('1' + i);
  }
  line += request.command;
  for (const std::string& word : request.words) line += " " + word;
  return line;
}

std::optional<Request> decode_request(std::string_view line) {
  const bool is_text = std::ranges::all_of(line, [](char c) { return c >= ' ' && c <= '~'; });
  if (!is_text || line.size() > kLongestLine) return std::nullopt;
  Request request;
  const std::vector<std::string_view> words = words_of(line);
  if (words.empty()) return request;
  std::string_view command = words.front();
  for (; !command.empty(); command.remove_prefix(1)) {
    const char c = upper(command.front());
    if (c >= '1' && c <= '4') {
      request.motors[static_cast<std::size_t>(c - '1')] = true;
    } else if (c == 'G') {
      request.motors[0] = request.motors[1] = request.motors[2] = true;
    } else if (c == 'S') {
      request.motors[kSpread] = true;
    } else {
      break;
    }
  }
  std::ranges::transform(command, std::back_inserter(request.command), upper);
  for (std::size_t i = 1; i < words.size(); ++i) {
    std::ranges::transform(words[i], std::back_inserter(request.words.emplace_back()), upper);
  }
  return request;
}

Reply parse_reply(std::string_view received, std::string_view sent) {
  Reply reply;
  const std::string_view echo = received.substr(0, sent.size());
  if (received.size() > kLongestReply || !sent.starts_with(echo)) {
    reply.kind = Reply::Kind::kDamaged;
    return reply;
  }
  if (received.size() <= sent.size()) return reply;
  const std::string_view behind = received.substr(sent.size());
  if (behind.front() == kLooping) {
    reply.kind = behind.size() == 1 ? Reply::Kind::kLoops : Reply::Kind::kDamaged;
    return reply;
  }
  const Lines lines = lines_of(behind);
  // The echo of the CR comes first, and nothing before it.
  const bool is_cut = !lines.whole.empty() ? !lines.whole.front().empty() : !lines.rest.empty();
  if (is_cut) {
    reply.kind = Reply::Kind::kDamaged;
    return reply;
  }
  if (lines.rest != kPrompt) return reply;
  reply.kind = Reply::Kind::kDone;
  for (std::size_t i = 1; i < lines.whole.size(); ++i) {
    if (const int error = error_of(lines.whole[i]); error != 0) {
      reply.error |= error;
    } else if (!lines.whole[i].empty()) {
      reply.lines.push_back(lines.whole[i]);
    }
  }
  return reply;
}

std::vector<int> integers_of(std::string_view text) {
  std::vector<int> values;
  for (const std::string_view word : words_of(text)) {
    const auto value = integer(word);
    if (!value) return {};
    values.push_back(*value);
  }
  return values;
}

bool ends_in_prompt(std::string_view received) { return lines_of(received).rest == kPrompt; }

int errors_in(std::string_view received) {
  int errors = 0;
  for (const std::string& line : lines_of(received).whole) errors |= error_of(line);
  return errors;
}

}  // namespace prehend::drivers::barrett::gcl

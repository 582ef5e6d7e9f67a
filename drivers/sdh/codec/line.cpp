#include "drivers/sdh/codec/line.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>

namespace prehend::drivers::sdh {
namespace {

constexpr std::size_t kLongestName = 24;
constexpr int kMostAxis = 99;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

// Takes a name off the front: letters of one case, digits and _, a letter first.
std::string_view take_name(std::string_view& text, char first, char last) {
  std::size_t size = 0;
  while (size < text.size() && size <= kLongestName) {
    const char c = text[size];
    const bool is_letter = c >= first && c <= last;
    if (!is_letter && (size == 0 || !(is_digit(c) || c == '_'))) break;
    ++size;
  }
  const std::string_view name = text.substr(0, size);
  text.remove_prefix(size);
  return size <= kLongestName ? name : std::string_view();
}

// "(n)" at the front; -1: there is none, -2: a broken one.
int take_axis(std::string_view& text) {
  if (text.empty() || text.front() != '(') return -1;
  int axis = 0;
  const char* const begin = text.data() + 1;
  const auto [end, error] = std::from_chars(begin, text.data() + text.size(), axis);
  const auto size = static_cast<std::size_t>(end - begin);
  const bool is_canonical = size == 1 || (size == 2 && *begin != '0');
  if (error != std::errc() || !is_canonical || axis < 0 || axis > kMostAxis) return -2;
  if (end == text.data() + text.size() || *end != ')') return -2;
  text.remove_prefix(size + 2);
  return axis;
}

// A number at the front.
std::optional<double> take_number(std::string_view& text) {
  std::string_view rest = text;
  if (!rest.empty() && rest.front() == '+') rest.remove_prefix(1);
  const bool begins = !rest.empty() && (is_digit(rest.front()) || rest.front() == '-' ||
                                        rest.front() == '.');  // no "inf", no "nan"
  if (!begins) return std::nullopt;
  double value = 0;
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
  if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
  text = rest.substr(static_cast<std::size_t>(end - rest.data()));
  return value;
}

std::string with_axis(const std::string& name, const std::optional<int>& axis) {
  return axis ? name + "(" + std::to_string(*axis) + ")" : name;
}

bool is_printable(std::string_view text) {
  return std::ranges::all_of(text, [](char c) { return c >= ' ' && c <= '~'; });
}

}  // namespace

std::string encode(const LineRequest& request, bool as_integers) {
  std::string line = with_axis(request.name, request.axis);
  for (std::size_t i = 0; i < request.values.size(); ++i) {
    char text[64];
    if (as_integers) {
      std::snprintf(text, sizeof text, "%ld", std::lround(request.values[i]));
    } else {
      std::snprintf(text, sizeof text, "%f", request.values[i]);
    }
    line += (i == 0 ? "=" : ",") + std::string(text);
  }
  return line + "\r\n";
}

std::string encode(const LineReply& reply) {
  if (reply.error) return "E" + std::to_string(*reply.error) + "\r\n";
  std::string line = with_axis(reply.name, reply.axis);
  if (reply.text) line += "=" + *reply.text;
  return line + "\r\n";
}

std::optional<LineRequest> decode_line_request(std::string_view line) {
  if (line.size() > kLongestLine || !is_printable(line)) return std::nullopt;
  line = trimmed(line);
  LineRequest request;
  request.name = take_name(line, 'a', 'z');
  if (request.name.empty()) return std::nullopt;
  const int axis = take_axis(line);
  if (axis == -2) return std::nullopt;
  if (axis >= 0) request.axis = axis;
  line = trimmed(line);
  if (line.empty()) return request;
  if (line.front() != '=') return std::nullopt;
  line.remove_prefix(1);
  while (request.values.size() < kMostValues) {
    line = trimmed(line);
    const auto value = take_number(line);
    if (!value) return std::nullopt;
    request.values.push_back(*value);
    line = trimmed(line);
    if (line.empty()) return request;
    if (line.front() != ',') return std::nullopt;
    line.remove_prefix(1);
  }
  return std::nullopt;
}

std::optional<LineReply> decode_line_reply(std::string_view line) {
  if (line.size() > kLongestLine || !is_printable(line)) return std::nullopt;
  LineReply reply;
  // No ordinary reply begins with E and a digit.
  if (line.size() > 1 && line[0] == 'E' && is_digit(line[1])) {
    unsigned code = 0;
    const auto [end, error] = std::from_chars(line.data() + 1, line.data() + line.size(), code);
    const bool is_canonical = line.size() == 2 || line[1] != '0';
    if (error != std::errc() || end != line.data() + line.size() || code > 0xFF || !is_canonical) {
      return std::nullopt;
    }
    reply.error = static_cast<std::uint8_t>(code);
    return reply;
  }
  reply.name = take_name(line, 'A', 'Z');
  if (reply.name.empty()) return std::nullopt;
  const int axis = take_axis(line);
  if (axis == -2) return std::nullopt;
  if (axis >= 0) reply.axis = axis;
  if (line.empty()) return reply;
  if (line.front() != '=') return std::nullopt;
  reply.text = std::string(line.substr(1));
  return reply;
}

std::vector<double> numbers_of(std::string_view text) {
  std::vector<double> values;
  while (true) {
    while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
    const auto value = take_number(text);
    if (!value) return values;
    if (values.size() == kMostValues) return {};
    values.push_back(*value);
    while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
    if (text.empty() || text.front() != ',') return values;
    text.remove_prefix(1);
  }
}

}  // namespace prehend::drivers::sdh

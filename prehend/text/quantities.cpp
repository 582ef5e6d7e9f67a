#include "prehend/text/quantities.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include "prehend/text/input_error.h"

namespace prehend::text {
namespace {

using Units = std::vector<std::pair<std::string_view, double>>;

const Units kSeconds{{"ns", 1e-9}, {"us", 1e-6}, {"ms", 1e-3}, {"s", 1}, {"min", 60}, {"h", 3600}};
const Units kMetres{{"um", 1e-6}, {"mm", 1e-3}, {"cm", 1e-2}, {"m", 1}};

// Without a unit it is one of SI.
Units or_none(Units units) {
  units.emplace_back("", 1);
  return units;
}

// A number of at least 0 times its unit's factor, below `limit`; `above_zero`: 0 is refused.
double parse(const std::string& text, const Units& units, const char* what, const char* example,
             double limit, bool above_zero) {
  double number = 0;
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, number);
  std::string_view unit(rest, static_cast<std::size_t>(end - rest));
  while (unit.starts_with(' ')) unit.remove_prefix(1);
  if (error == std::errc() && std::isfinite(number) && (above_zero ? number > 0 : number >= 0)) {
    for (const auto& [name, factor] : units) {
      if (unit == name && number * factor < limit) return number * factor;
    }
  }
  std::string names;
  bool may_be_bare = false;
  for (const auto& [name, factor] : units) {
    may_be_bare = may_be_bare || name.empty();
    if (!name.empty()) names += fmt::format(" {}", name);
  }
  throw InputError(fmt::format("'{}' is no {}", text, what),
                   fmt::format("Write a number {} with one of the units{}, as in {}{}",
                               above_zero ? "above 0" : "of at least 0", names, example,
                               may_be_bare ? ", or without one in SI's" : ""));
}

}  // namespace

std::int64_t parse_duration(const std::string& text) {
  // In nanoseconds, which doubles hold exactly up to 104 days.
  Units units = kSeconds;
  for (auto& [name, factor] : units) factor = std::round(factor * 1e9);
  return std::llround(parse(text, units, "duration", "10ms", 9e18, false));
}

std::uint64_t parse_bytes(const std::string& text) {
  constexpr double k = 1024;
  static const Units kUnits{{"B", 1},       {"kB", 1e3},        {"MB", 1e6},
                            {"GB", 1e9},    {"TB", 1e12},       {"KiB", k},
                            {"MiB", k * k}, {"GiB", k * k * k}, {"TiB", k * k * k * k}};
  return static_cast<std::uint64_t>(
      std::llround(parse(text, kUnits, "number of bytes", "500MB", 9e18, false)));
}

double parse_seconds(const std::string& text) {
  static const Units kUnits = or_none(kSeconds);
  return parse(text, kUnits, "duration", "20ms", HUGE_VAL, true);
}

double parse_metres(const std::string& text) {
  static const Units kUnits = or_none(kMetres);
  return parse(text, kUnits, "length", "3mm", HUGE_VAL, true);
}

}  // namespace prehend::text

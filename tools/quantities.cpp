#include "tools/quantities.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

namespace prehend::tools {
namespace {

using Units = std::vector<std::pair<std::string_view, double>>;

double parse(const std::string& text, const Units& units, const std::string& example) {
  double number = 0;
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, number);
  const std::string_view unit(rest, static_cast<std::size_t>(end - rest));
  if (error == std::errc() && std::isfinite(number) && number >= 0) {
    for (const auto& [name, factor] : units) {
      if (unit == name && number * factor < 9e18) return number * factor;
    }
  }
  std::string names;
  for (const auto& [name, factor] : units) names += fmt::format(" {}", name);
  throw std::invalid_argument(
      fmt::format("'{}' is not a number with one of the units{}, as in {}", text, names, example));
}

}  // namespace

std::int64_t parse_duration(const std::string& text) {
  static const Units kUnits{{"ns", 1},  {"us", 1e3},   {"ms", 1e6},
                            {"s", 1e9}, {"min", 60e9}, {"h", 3600e9}};
  return std::llround(parse(text, kUnits, "10ms"));
}

std::uint64_t parse_bytes(const std::string& text) {
  constexpr double k = 1024;
  static const Units kUnits{{"B", 1},       {"kB", 1e3},        {"MB", 1e6},
                            {"GB", 1e9},    {"TB", 1e12},       {"KiB", k},
                            {"MiB", k * k}, {"GiB", k * k * k}, {"TiB", k * k * k * k}};
  return static_cast<std::uint64_t>(std::llround(parse(text, kUnits, "500MB")));
}

}  // namespace prehend::tools

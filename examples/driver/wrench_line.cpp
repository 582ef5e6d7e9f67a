#include "wrench_line.h"

#include <cmath>
#include <cstdlib>

namespace my_driver {
namespace {

constexpr std::size_t kLongest = 200;  // bytes: a line without an end is no line

}  // namespace

std::optional<Measurement> decode(std::string_view line) {
  const std::string text(line);
  const char* at = text.c_str();
  std::array<double, 6> values{};
  for (double& value : values) {
    char* end = nullptr;
    value = std::strtod(at, &end);
    if (end == at || !std::isfinite(value)) return std::nullopt;
    at = end;
  }
  while (*at == ' ' || *at == '\r') ++at;
  if (*at != '\0') return std::nullopt;
  return Measurement{{values[0], values[1], values[2]}, {values[3], values[4], values[5]}};
}

std::vector<Measurement> LineDecoder::take(std::string_view bytes) {
  std::vector<Measurement> measurements;
  for (const char byte : bytes) {
    if (byte != '\n') {
      if (rest_.size() <= kLongest) rest_ += byte;
      continue;
    }
    const auto measurement = rest_.size() <= kLongest ? decode(rest_) : std::nullopt;
    if (measurement) {
      measurements.push_back(*measurement);
    } else {
      ++damaged_;
    }
    rest_.clear();
  }
  return measurements;
}

}  // namespace my_driver

#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

// The codec: bytes to measurements, without input or output, so that tests give it whatever they
// like.
namespace my_driver {

struct Measurement {
  std::array<double, 3> force{};   // N
  std::array<double, 3> torque{};  // N m
};

/// "fx fy fz tx ty tz", newtons and newton metres; nothing for anything else.
std::optional<Measurement> decode(std::string_view line);

/// Cuts a stream of bytes into lines, and decodes them.
class LineDecoder {
 public:
  /// Those that `bytes` end.
  std::vector<Measurement> take(std::string_view bytes);
  /// Lines that were none so far.
  int damaged() const { return damaged_; }

 private:
  std::string rest_;
  int damaged_ = 0;
};

}  // namespace my_driver

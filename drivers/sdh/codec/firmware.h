#pragma once

#include <array>
#include <compare>
#include <optional>
#include <string>
#include <string_view>

namespace prehend::drivers::sdh {

/// "0.0.3.3"
struct Firmware {
  std::array<int, 4> numbers{};

  auto operator<=>(const Firmware&) const = default;
  std::string text() const;
  /// Knows vlim (SDHLibrary-CPP, sdhserial.cpp; so what follows).
  bool has_speed_limit() const { return *this >= Firmware{{0, 0, 2, 1}}; }
  /// Knows con and rvel.
  bool has_controllers() const { return *this >= Firmware{{0, 0, 2, 6}}; }
  /// Knows alim, and a ramp whose target may change on the way.
  bool has_smooth_ramp() const { return *this >= Firmware{{0, 0, 2, 7}}; }
  bool has_binary() const { return *this >= Firmware{{0, 0, 2, 15}}; }
  /// Answers m, selgrip and grip without debug lines before.
  bool is_terse() const { return *this >= Firmware{{0, 0, 3, 1}}; }
};

/// Four numbers of at most four digits at the beginning; nothing else behind them but blanks.
std::optional<Firmware> firmware_of(std::string_view text);

}  // namespace prehend::drivers::sdh

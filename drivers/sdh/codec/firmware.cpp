#include "drivers/sdh/codec/firmware.h"

#include <charconv>

namespace prehend::drivers::sdh {

std::string Firmware::text() const {
  std::string words;
  for (const int number : numbers) words += (words.empty() ? "" : ".") + std::to_string(number);
  return words;
}

std::optional<Firmware> firmware_of(std::string_view text) {
  constexpr std::size_t kMostDigits = 4;
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  Firmware firmware;
  for (std::size_t i = 0; i < firmware.numbers.size(); ++i) {
    if (i > 0) {
      if (text.empty() || text.front() != '.') return std::nullopt;
      text.remove_prefix(1);
    }
    unsigned number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    const auto digits = static_cast<std::size_t>(end - text.data());
    if (error != std::errc() || digits > kMostDigits) return std::nullopt;
    firmware.numbers[i] = static_cast<int>(number);
    text.remove_prefix(digits);
  }
  if (!text.empty()) return std::nullopt;
  return firmware;
}

}  // namespace prehend::drivers::sdh

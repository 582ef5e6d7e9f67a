#include "prehend/text/told_apart.h"

#include <fmt/format.h>

namespace prehend::text {

NumberPair told_apart(double first, double second, int digits) {
  constexpr int kMostDigits = 12;
  const auto at = [&](int places) {
    return NumberPair{fmt::format("{:.{}f}", first, places),
                      fmt::format("{:.{}f}", second, places)};
  };
  for (int places = digits; places <= kMostDigits; ++places) {
    NumberPair pair = at(places);
    // As numbers, since "-0.0" reads like "0.0".
    if (std::stod(pair.first) != std::stod(pair.second)) return pair;
  }
  return at(digits);
}

}  // namespace prehend::text

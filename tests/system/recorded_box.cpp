#include "tests/system/recorded_box.h"

#include <cmath>

namespace prehend::testing {

std::string image_of_a_box(const Eigen::Vector3d& size) {
  constexpr int kWidth = 160, kHeight = 120;
  constexpr double kFocal = 300, kMiddle = 80, kHorizon = 30;  // pixels
  constexpr double kOver = 0.03, kAway = 0.8;                  // m
  std::string text =
      "VERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\n"
      "WIDTH 160\nHEIGHT 120\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 19200\nDATA ascii\n";
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const double down = (v - kHorizon) / kFocal, right = (u - kMiddle) / kFocal;
      const double z = down * kAway < kOver ? kOver / down : kAway;
      const bool is_hit = down > 0 && z <= kAway + size.y() && down * z <= kOver + size.z() &&
                          std::abs(right * z) <= size.x() / 2;
      text += is_hit ? std::to_string(right * z) + " " + std::to_string(down * z) + " " +
                           std::to_string(z)
                     : "nan nan nan";
      text += " 16711680\n";
    }
  }
  return text;
}

}  // namespace prehend::testing

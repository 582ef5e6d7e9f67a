#include "prehend/shape/outline.h"

#include <algorithm>

namespace prehend::shape {

bool reaches_border(const geometry::MaskImage& mask) {
  for (int u = 0; u < mask.width; ++u) {
    if (mask.at(u, 0) || mask.at(u, mask.height - 1)) return true;
  }
  for (int v = 0; v < mask.height; ++v) {
    if (mask.at(0, v) || mask.at(mask.width - 1, v)) return true;
  }
  return false;
}

double hidden_outline_share(const geometry::MaskImage& mask, const geometry::DepthImage& nearer) {
  constexpr int kReach = 3;  // pixels
  const auto outside = [&](int u, int v) { return !mask.contains(u, v) || !mask.at(u, v); };
  double outline = 0, occluded = 0;
  for (int v = 0; v < mask.height; ++v) {
    for (int u = 0; u < mask.width; ++u) {
      if (!mask.at(u, v) ||
          (!outside(u - 1, v) && !outside(u + 1, v) && !outside(u, v - 1) && !outside(u, v + 1))) {
        continue;
      }
      outline += 1;
      bool is_cut = false;
      for (int y = std::max(0, v - kReach); y <= std::min(mask.height - 1, v + kReach); ++y) {
        for (int x = std::max(0, u - kReach); x <= std::min(mask.width - 1, u + kReach); ++x) {
          is_cut = is_cut || nearer.at(x, y) > 0;
        }
      }
      occluded += is_cut;
    }
  }
  return outline > 0 ? occluded / outline : 0;
}

}  // namespace prehend::shape

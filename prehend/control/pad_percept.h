#pragma once

#include <string>
#include <vector>

namespace prehend::control {

/// One pad as felt.
struct PadPercept {
  double sum = 0;   // N
  double area = 0;  // m^2, of the texels above the touch threshold
  double age = 0;   // s, of the frame
  std::string name{};
};

/// What the pads that touch feel.
struct MeanTouch {
  int pads = 0;
  double sum = 0;   // N, mean of those
  double area = 0;  // m^2, mean of those
};

/// Of the pads with a frame no older than `stale_time` [s], those that feel more than `touch_force`
/// [N].
inline MeanTouch mean_touch(const std::vector<PadPercept>& pads, double touch_force,
                            double stale_time) {
  MeanTouch mean;
  for (const PadPercept& pad : pads) {
    if (pad.age > stale_time || pad.sum <= touch_force) continue;
    ++mean.pads;
    mean.sum += pad.sum;
    mean.area += pad.area;
  }
  if (mean.pads > 0) {
    mean.sum /= mean.pads;
    mean.area /= mean.pads;
  }
  return mean;
}

}  // namespace prehend::control

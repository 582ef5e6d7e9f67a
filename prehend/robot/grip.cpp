#include "prehend/robot/grip.h"

#include <algorithm>
#include <cmath>

namespace prehend::robot {
namespace {

constexpr double kFirstShare = 0.35;     // of the effort that is thought to be enough
constexpr double kLeastShare = 0.05;     // of the hand's greatest
constexpr double kForceTolerance = 0.1;  // of the force
constexpr double kLeastRise = 1.05, kMostRise = 1.5;

}  // namespace

MeanTouch mean_touch(const std::vector<PadPercept>& pads, double touch_force, double stale_time) {
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

void GripOptions::validate(std::string_view of) const { knobs(*this, text::CheckKnobs{of}); }

double first_effort_share(double enough) {
  return std::clamp(kFirstShare * enough, kLeastShare, 1.0);
}

std::optional<double> next_effort_share(double share, const MeanTouch& felt, double wanted) {
  if (share >= 1) return std::nullopt;
  if (felt.pads > 0 && felt.sum >= (1 - kForceTolerance) * wanted) return std::nullopt;
  const double lacks = felt.pads > 0 ? wanted / felt.sum : kMostRise;
  return std::min(1.0, share * std::clamp(lacks, kLeastRise, kMostRise));
}

}  // namespace prehend::robot

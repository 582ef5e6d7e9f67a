#include "prehend/robot/grip.h"

#include <algorithm>
#include <cmath>

#include "prehend/text/require.h"

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

void GripOptions::validate(std::string_view of) const {
  const text::Require require{of};
  require(closing_speed > 0 && closing_speed <= 1, "closing_speed must be in (0, 1]");
  require(std::isfinite(gather) && gather >= 0, "gather must not be negative");
  require(std::isfinite(overrun) && overrun >= 0, "overrun must not be negative");
  require(std::isfinite(grip_force) && grip_force >= 0, "grip_force must not be negative");
  require(std::isfinite(touch_force) && touch_force > 0, "touch_force must be positive");
  require(std::isfinite(force_timeout) && force_timeout > 0, "force_timeout must be positive");
  require(std::isfinite(settle_time) && settle_time >= 0, "settle_time must not be negative");
}

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

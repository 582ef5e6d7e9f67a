#include "prehend/control/load_watch.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace prehend::control {
namespace {

constexpr std::size_t kLeastPads = 2;
constexpr double kUnbalanced = 0.35;  // of the pads' forces: something else presses, too

}  // namespace

LoadWatch::LoadWatch(robot::HandModel hand, double touch_force)
    : touch_(std::move(hand)), touch_force_(touch_force) {}

// What hangs in the pads is borne by their friction, but for what their faces bear.
std::optional<double> LoadWatch::share_of(double load, const ArmPercepts& percepts,
                                          const belief::HandSample& hand) const {
  std::vector<touch::PadContact> pads;
  try {
    pads = touch_.contacts(hand.joints, percepts.frames, touch_force_);
  } catch (const std::invalid_argument&) {
    return std::nullopt;  // what the pads say, or where they are, is not known
  }
  if (pads.size() < kLeastPads) return std::nullopt;
  double force = 0;
  Eigen::Vector3d sum_W = Eigen::Vector3d::Zero();
  for (const touch::PadContact& pad : pads) {
    force += pad.force;
    sum_W += pad.force * (hand.X_WH.linear() * pad.n_H);
  }
  if (!(force > 0) || sum_W.head<2>().norm() > kUnbalanced * force) return std::nullopt;
  const double share = (load - sum_W.z()) / force;
  return std::isfinite(share) && share > 0 ? std::optional(share) : std::nullopt;
}

void LoadWatch::step(const ArmCycle& cycle, const ArmPercepts& percepts,
                     const belief::HandSample& hand) {
  const Phase phase = cycle.phase();
  const bool holds = phase == Phase::kLift || phase == Phase::kMove;
  const std::size_t surprises = cycle.surprises().size();
  if (surprises < surprises_seen_) surprises_seen_ = 0;  // another cycle has begun
  if (holds && !open_) found_ = {};
  if (holds || open_) {
    const bool slips = std::any_of(
        cycle.surprises().begin() + static_cast<std::ptrdiff_t>(surprises_seen_),
        cycle.surprises().end(),
        [](const Surprise& one) { return one.kind == SurpriseKind::kSlip && one.felt > 0; });
    if (slips && percepts.wrist_force) {
      const double borne = cycle.holding().change(*percepts.wrist_force);
      found_.borne = std::max(found_.borne.value_or(0), borne);
      if (const auto share = share_of(borne, percepts, hand)) {
        found_.slipped_share = std::min(found_.slipped_share.value_or(*share), *share);
      }
    }
    if (cycle.holding().weight() && !found_.weight) {
      found_.weight = cycle.holding().weight();
      found_.weight_deviation = cycle.holding().weight_deviation();
      found_.held_share = share_of(*found_.weight, percepts, hand);
    }
  }
  surprises_seen_ = surprises;
  if (open_ && !holds && !found_.is_empty()) ++concluded_;
  open_ = holds;
}

}  // namespace prehend::control

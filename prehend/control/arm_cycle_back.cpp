// The arm goes back the way it came.

#include <algorithm>

#include "prehend/control/arm_cycle.h"

namespace prehend::control {
namespace {

constexpr double kOnPath = 0.03;    // rad or m, from a path: it stands there
constexpr double kLeastWay = 0.01;  // of a path, that is gone back

}  // namespace

void ArmCycle::clear_view() {
  // Behind a place: back by its way down, which is free as the retreat ends on it.
  constexpr std::size_t kPlaceAndRetreat = 2;
  if (gone_.size() < kPlaceAndRetreat) return look_now();
  const PlaceOnPath above =
      nearest_on(gone_[gone_.size() - 2], percepts_.names, percepts_.positions);
  gone_.pop_back();
  if (above.off > kOnPath) return look_now();
  clears_ = true;
  go_back();
}

void ArmCycle::go_back() {
  if (gone_.empty() && clears_) {
    clears_ = false;
    return look_now();
  }
  if (gone_.empty()) {
    if (!put_down_ || !failure().empty()) return ended(Outcome::kDone);
    holding_.begin_weighing();
    return enter(Step::kVerify, "looking whether the hand is empty");
  }
  // As far as it came: contact, or who stopped it, may have ended it on its way.
  JointTrajectory way = gone_.back();
  gone_.pop_back();
  JointTrajectory end = way;
  end.points = {way.points.back()};
  const auto off = [this](const JointTrajectory& path) {
    return nearest_on(path, percepts_.names, percepts_.positions);
  };
  if (off(end).off > kOnPath) way = part_of(way, std::max(off(way).share, kLeastWay));
  enter(Step::kGoBack, "going back the way it came");
  follow(reversed(way), 0, false);
}

}  // namespace prehend::control

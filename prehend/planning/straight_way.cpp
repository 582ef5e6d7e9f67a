#include "prehend/planning/straight_way.h"

#include <vector>

namespace prehend::planning {

PlatformPick plan_straight_way(const robot::Platform& platform, const robot::Positions& start,
                               const std::vector<PlatformGrasp>& ends, const PlatformScene& scene,
                               const PlatformPickOptions& arm, double speed) {
  constexpr double kLift = 0.02;  // m: of no use, as nothing is held
  PlatformPickOptions to_there = arm;
  to_there.moves_W.clear();
  to_there.shift = 0;
  to_there.inspection.reset();
  to_there.pick.lift_height = kLift;
  to_there.pick.straight_speed = speed;
  PlatformPick pick = plan_platform_pick(platform, start, ends, scene, to_there);
  std::erase_if(pick.motion.segments, [](const motion::PickSegment& segment) {
    return segment.kind != motion::SegmentKind::kReach &&
           segment.kind != motion::SegmentKind::kApproach;
  });
  return pick;
}

grasp::Grasp hand_at_end(const PlatformGrasp& end, const std::string& made_by) {
  grasp::Grasp hand;
  hand.X_WG = end.X_WG;
  hand.approach_W = end.approach_W;
  hand.pregrasp_distance = end.pregrasp_distance;
  hand.preshape = end.preshape;
  hand.open = hand.closed = end.open;
  hand.generator = made_by;
  return hand;
}

}  // namespace prehend::planning

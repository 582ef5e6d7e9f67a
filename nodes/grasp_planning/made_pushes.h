#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "msgs/grasp.pb.h"
#include "prehend/planning/push_plan.h"

namespace prehend::nodes {

/// The pushes that the robot has made in a cycle: where they did not part what stands there,
/// another is to be tried.
class MadePushes {
 public:
  /// What may be pushed next. Of the newest 256 plans that have a push.
  void planned(const msgs::GraspPlan& plan);
  /// A push that begins is made.
  void begun(const msgs::CycleState& state);
  /// What stands there is no more what was pushed: all of it may be pushed again.
  void something_was_put_down() { lines_.clear(); }
  void clear();

  const std::vector<planning::PushLine>& lines() const { return lines_; }

 private:
  using Object = std::pair<std::int64_t, std::uint32_t>;  // view [ns] and id: ids are of one view
  std::map<Object, planning::PushLine> planned_;
  std::vector<planning::PushLine> lines_;
};

}  // namespace prehend::nodes

#pragma once

#include <map>
#include <vector>

#include "msgs/grasp.pb.h"
#include "prehend/planning/push_plan.h"

namespace prehend::nodes {

/// The pushes that the robot has made in a cycle: where they did not part what stands there,
/// another is to be tried.
class MadePushes {
 public:
  /// What may be pushed next.
  void planned(const msgs::GraspPlan& plan);
  /// A push that begins is made.
  void begun(const msgs::CycleState& state);
  void clear();

  const std::vector<planning::PushLine>& lines() const { return lines_; }

 private:
  std::map<std::uint32_t, planning::PushLine> planned_;  // by object
  std::vector<planning::PushLine> lines_;
};

}  // namespace prehend::nodes

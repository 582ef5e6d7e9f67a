#pragma once

#include <map>
#include <string>
#include <vector>

#include "prehend/motion/pick_motion.h"

namespace prehend::motion {

/// Checks what plan_pick() is given. @throws std::invalid_argument as it says.
void check_pick(const RobotInWorld& robot, const robot::InverseKinematics& inverse,
                const PickTask& task, const PickOptions& options);

/// How a grasp, or one of its solutions, failed.
struct PickMiss {
  PickFilter filter = PickFilter::kOutOfReach;
  double passed = 0;  // the larger, the nearer to passing; compared within one filter only
  std::string text;

  /// Whether it came farther than `other`.
  bool is_farther_than(const PickMiss& other) const {
    return filter != other.filter ? filter > other.filter : passed > other.passed;
  }
};

/// "none of 12 grasps can be used: 10 out of reach (nearest: ...), 2 ..."
std::string rejection_problem(std::size_t grasps, const std::vector<PickRejection>& rejections);

/// Adds a ledger to another: counts of one filter are one.
void add_rejections(const std::vector<PickRejection>& more, std::vector<PickRejection>* all);

/// Counts grasps by the filter they failed at.
class PickLedger {
 public:
  void add(const PickMiss& miss);
  std::vector<PickRejection> rejections() const;

 private:
  struct Entry {
    int count = 0;
    PickMiss nearest;
  };
  std::map<PickFilter, Entry> entries_;
};

}  // namespace prehend::motion

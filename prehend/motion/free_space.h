#pragma once

#include <cstdint>
#include <string>

#include "prehend/robot/kinematic_chain.h"

namespace prehend::motion {

/// Which joint positions are free: all that a planner needs to know of a robot and its world.
/// Implementations are reentrant. Pure virtual, so that planners in shared libraries need nothing
/// of prehend linked to them.
class FreeSpace {
 public:
  virtual ~FreeSpace() = default;

  virtual int size() const = 0;  // joints
  /// Limits of a joint [rad or m]; may be infinite.
  virtual double lower(int joint) const = 0;
  virtual double upper(int joint) const = 0;

  /// Within limits, clear of obstacles and of itself. @pre `q` has size() entries, as in all that
  /// follows.
  virtual bool is_free(const Eigen::Ref<const Eigen::VectorXd>& q) const = 0;
  /// "the link of joint 'e2' touches 'table'"; empty when free.
  virtual std::string problem(const Eigen::Ref<const Eigen::VectorXd>& q) const = 0;
  /// Which of up to kBatch (8) positions are not free: bit i for q[i]. What is within 2 um of
  /// touching may count as touching, and nothing that touches as free.
  virtual std::uint32_t not_free(const robot::Positions* q, int count) const = 0;
  /// Whether the straight line in joint space is free at steps of at most `step` [rad or m] of any
  /// joint, both ends included.
  virtual bool is_free_between(const Eigen::Ref<const Eigen::VectorXd>& from,
                               const Eigen::Ref<const Eigen::VectorXd>& to, double step) const = 0;
  /// Whether the straight line is free between tested positions as well, see RobotInWorld: the test
  /// that each piece of a path must pass. Of RobotInWorld's balls it is as quick as the other one.
  virtual bool is_swept_free(const Eigen::Ref<const Eigen::VectorXd>& from,
                             const Eigen::Ref<const Eigen::VectorXd>& to) const = 0;

 protected:
  FreeSpace() = default;
  FreeSpace(const FreeSpace&) = default;
  FreeSpace(FreeSpace&&) = default;
  FreeSpace& operator=(const FreeSpace&) = default;
  FreeSpace& operator=(FreeSpace&&) = default;
};

}  // namespace prehend::motion

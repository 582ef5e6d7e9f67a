#pragma once

#include "prehend/motion/path_planner.h"

namespace prehend::motion {

enum class OmplAlgorithm {
  kRrtConnect,  // ompl::geometric::RRTConnect
  kBiTrrt,    // BiTRRT: L. Jaillet, J. Cortés, T. Siméon, "Transition-based RRT", IEEE T-RO 26(4)
  kLbKpiece,  // LBKPIECE1: I. A. Şucan, L. E. Kavraki, WAFR 2008; cells of the first three joints
};

/// Planners of the Open Motion Planning Library (I. A. Şucan, M. Moll, L. E. Kavraki, "The Open
/// Motion Planning Library", IEEE RAM 19(4), 2012). OMPL seeds its random numbers once for the
/// whole process; here the planner and its sampler get the seed of the options themselves, so that
/// kRrtConnect and kBiTrrt give the same path for the same seed, unless the budget ends them.
/// kLbKpiece draws from numbers that cannot be reached: its paths are not repeatable.
/// Sets OMPL's log level to errors, for the whole process.
class OmplPlanner final : public PathPlanner {
 public:
  explicit OmplPlanner(OmplAlgorithm algorithm) : algorithm_(algorithm) {}

  /// ompl_rrt_connect, ompl_bitrrt, ompl_kpiece.
  std::string name() const override;
  std::string about() const override;
  JointPath plan(const FreeSpace& space, const Eigen::Ref<const Eigen::VectorXd>& start,
                 const std::vector<robot::Positions>& goals,
                 const PathOptions& options) const override;

 private:
  OmplAlgorithm algorithm_;
};

}  // namespace prehend::motion

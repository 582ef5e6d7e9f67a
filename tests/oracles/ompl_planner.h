#pragma once

#include <functional>
#include <vector>

#include "prehend/motion/rrt_connect.h"

namespace prehend::motion {

enum class OmplAlgorithm {
  kRrtConnect,  // ompl::geometric::RRTConnect
  kBiTrrt,      // ompl::geometric::BiTRRT: prefers low costs; path length here
};

struct OmplOptions {
  OmplAlgorithm algorithm = OmplAlgorithm::kRrtConnect;
  double budget = 5;         // s of wall time, > 0
  double resolution = 0.05;  // rad or m, in joint space, between tested positions, > 0
  bool simplify = true;      // by OMPL's shortcuts
  /// Which positions are free; empty: RobotInWorld::is_free.
  std::function<bool(const robot::Positions&)> is_free = nullptr;
};

/// The same question as plan_path(), answered by the Open Motion Planning Library (I. A. Şucan, M.
/// Moll, L. E. Kavraki, "The Open Motion Planning Library", IEEE RAM 19(4), 2012). The reference
/// for plan_path(): OMPL seeds its random numbers once for the whole process, so paths are not
/// repeatable. Reasons as there. `goal` is -1 when OMPL ends between goals that nearly coincide.
/// @throws std::invalid_argument as plan_path().
JointPath plan_path_by_ompl(const RobotInWorld& robot,
                            const Eigen::Ref<const Eigen::VectorXd>& start,
                            const std::vector<robot::Positions>& goals,
                            const OmplOptions& options = {});

}  // namespace prehend::motion

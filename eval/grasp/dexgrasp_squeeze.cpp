#include "eval/grasp/dexgrasp_squeeze.h"

#include <algorithm>
#include <cmath>

#include "prehend/grasp/wrench/force_limits.h"

namespace prehend::eval {
namespace {

constexpr int kConeEdges = 8;

}  // namespace

Eigen::VectorXd balanced_squeeze(const DexHand& hand, const grasp::Grasp& grasp,
                                 const Eigen::Vector3d& center_W, double radius, double load,
                                 double safety) {
  const robot::HandModel& freed = hand.freed;
  grasp::ClosedFingers closed;
  closed.all = grasp.closed_all;
  closed.contacts = grasp.contacts;
  const grasp::HandForces forces =
      grasp::hand_forces(freed, grasp.X_WH, closed, center_W, radius, kConeEdges);
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(freed.size());
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      grasp::Vector6 wrench = grasp::Vector6::Zero();
      wrench[axis] = side * load;
      const grasp::Holding holding = grasp::hold(forces, wrench);
      if (!holding.possible) return {};
      mean += holding.torques / 6;
    }
  }
  const double share = (safety * mean).cwiseAbs().cwiseQuotient(forces.limits).maxCoeff();
  mean *= safety / std::max(1.0, share);
  Eigen::VectorXd efforts =
      Eigen::VectorXd::Zero(static_cast<Eigen::Index>(freed.model.joints.size()));
  for (int i = 0; i < freed.size(); ++i) {
    efforts[freed.actuated[static_cast<std::size_t>(i)]] = mean[i];
  }
  return efforts;
}

}  // namespace prehend::eval

#include "prehend/robot/closing_way.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace prehend::robot {

Eigen::VectorXd ClosingWay::at(double beyond) const {
  Eigen::VectorXd positions(closed.size());
  for (Eigen::Index i = 0; i < closed.size(); ++i) {
    double way = beyond * rate[i];
    if (beyond < 0) {
      const double back = open[i] - closed[i];
      way = std::clamp(way, std::min(0.0, back), std::max(0.0, back));
    }
    positions[i] = std::clamp(closed[i] + way, lower[i], upper[i]);
  }
  return positions;
}

double ClosingWay::closure(const Eigen::Ref<const Eigen::VectorXd>& positions) const {
  double sum = 0;
  int count = 0;
  for (Eigen::Index i = 0; i < closed.size(); ++i) {
    if (rate[i] == 0) continue;
    sum += (positions[i] - closed[i]) / rate[i];
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

void ClosingWay::validate() const {
  const Eigen::Index n = closed.size();
  if (open.size() != n || rate.size() != n || lower.size() != n || upper.size() != n) {
    throw std::invalid_argument("ClosingWay: all values must be of the same motors");
  }
  if (!open.allFinite() || !closed.allFinite() || !rate.allFinite()) {
    throw std::invalid_argument("ClosingWay: positions and rates must be finite");
  }
  if (!(lower.array() <= upper.array()).all()) {
    throw std::invalid_argument("ClosingWay: lower limits must not be above upper ones");
  }
}

ClosingWay closing_way(const HandModel& hand, const Preshape& preshape, const Eigen::VectorXd& open,
                       const Eigen::VectorXd& closed) {
  ClosingWay way;
  way.open = open.size() > 0 ? open : preshape.open;
  way.closed = closed;
  way.rate.resize(hand.size());
  way.lower.resize(hand.size());
  way.upper.resize(hand.size());
  for (int i = 0; i < hand.size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Joint& joint = hand.model.joints[static_cast<std::size_t>(hand.actuated[k])];
    way.rate[i] =
        preshape.closing[k].rate * (joint.kind == Joint::Kind::kPrismatic ? kJawLever : 1);
    way.lower[i] = joint.lower;
    way.upper[i] = joint.upper;
  }
  way.validate();
  return way;
}

}  // namespace prehend::robot

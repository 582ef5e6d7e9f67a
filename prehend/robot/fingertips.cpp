#include "prehend/robot/fingertips.h"

#include <vector>

namespace prehend::robot {
namespace {

constexpr double kStep = 1e-6;      // rad or m
constexpr double kLeastWay = 1e-6;  // m for each rad or m: the finger is moved

// In the middle of its collision shapes; of a link without any its origin.
Eigen::Vector3d middle_of(const Link& link) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const CollisionShape& shape : link.shapes) {
    const Eigen::Vector3d p_S = shape.solid ? geometry::bounds(*shape.solid).center()
                                            : Eigen::Vector3d(Eigen::Vector3d::Zero());
    sum += shape.X_LS * p_S;
  }
  return link.shapes.empty() ? sum : sum / static_cast<double>(link.shapes.size());
}

std::vector<Eigen::Vector3d> fingertips(const HandModel& hand, const Eigen::VectorXd& positions) {
  std::vector<geometry::RigidTransform> X_HL;
  hand.link_poses(hand.all_positions(positions), X_HL);
  std::vector<Eigen::Vector3d> tips_H;
  for (const Finger& finger : hand.fingers) {
    const auto link = static_cast<std::size_t>(finger.links.back());
    tips_H.emplace_back(X_HL[link] * middle_of(hand.model.links[link]));
  }
  return tips_H;
}

}  // namespace

FingertipWays fingertip_ways(const HandModel& hand,
                             const Eigen::Ref<const Eigen::VectorXd>& positions) {
  FingertipWays result{Eigen::Matrix3Xd::Zero(3, hand.size()),
                       std::vector<int>(static_cast<std::size_t>(hand.size()), -1)};
  for (int i = 0; i < hand.size(); ++i) {
    Eigen::VectorXd beyond = positions, before = positions;
    beyond[i] += kStep;
    before[i] -= kStep;
    const auto there = fingertips(hand, beyond), here = fingertips(hand, before);
    int moved = 0;
    for (std::size_t f = 0; f < there.size(); ++f) {
      const Eigen::Vector3d way = (there[f] - here[f]) / (2 * kStep);
      if (way.norm() < kLeastWay) continue;
      result.ways.col(i) = way;
      result.finger[static_cast<std::size_t>(i)] = static_cast<int>(f);
      ++moved;
    }
    if (moved == 1) continue;
    result.ways.col(i).setZero();
    result.finger[static_cast<std::size_t>(i)] = -1;
  }
  return result;
}

}  // namespace prehend::robot

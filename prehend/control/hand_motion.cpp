#include "prehend/control/hand_motion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>

#include "prehend/robot/fingertips.h"

namespace prehend::control {
namespace {

constexpr double kNearer = 1e-6;  // rad or m: a later preshape must be nearer by this

const robot::Joint& motor_joint(const robot::HandModel& hand, Eigen::Index motor) {
  return hand.model
      .joints[static_cast<std::size_t>(hand.actuated[static_cast<std::size_t>(motor)])];
}

void check_size(const robot::HandModel& hand, const Eigen::Ref<const Eigen::VectorXd>& positions) {
  if (positions.size() == hand.size() && positions.allFinite()) return;
  throw std::invalid_argument(
      fmt::format("hand '{}' has {} motors, each at a finite position", hand.name, hand.size()));
}

void check_force(double force) {
  if (force > 0 && std::isfinite(force)) return;
  throw std::invalid_argument("the force must be positive [N]");
}

}  // namespace

const robot::Preshape& nearest_preshape(const robot::HandModel& hand,
                                        const Eigen::Ref<const Eigen::VectorXd>& positions) {
  check_size(hand, positions);
  const robot::Preshape* nearest = &hand.preshapes.front();
  double least = std::numeric_limits<double>::infinity();
  for (const robot::Preshape& preshape : hand.preshapes) {
    Eigen::VectorXd rate(hand.size());
    for (Eigen::Index i = 0; i < rate.size(); ++i) {
      rate[i] = preshape.closing[static_cast<std::size_t>(i)].rate;
    }
    const Eigen::VectorXd off = positions - preshape.open;
    const double square = rate.squaredNorm();
    const double closed = square > 0 ? std::max(0.0, off.dot(rate) / square) : 0;
    const double distance = (off - closed * rate).norm();
    if (distance < least - kNearer) {
      least = distance;
      nearest = &preshape;
    }
  }
  return *nearest;
}

Eigen::VectorXd closed_positions(const robot::HandModel& hand, const robot::Preshape& preshape,
                                 const Eigen::Ref<const Eigen::VectorXd>& positions) {
  check_size(hand, positions);
  const auto leader = [&](Eigen::Index i) -> Eigen::Index {
    const int with = preshape.closing[static_cast<std::size_t>(i)].with;
    return with < 0 ? i : with;
  };
  Eigen::VectorXd closed = positions;
  for (Eigen::Index i = 0; i < closed.size(); ++i) {
    // How far its group goes: to the first of its limits.
    double way = std::numeric_limits<double>::infinity();
    for (Eigen::Index k = 0; k < closed.size(); ++k) {
      const double rate = preshape.closing[static_cast<std::size_t>(k)].rate;
      if (leader(k) != leader(i) || rate == 0) continue;
      const robot::Joint& joint = motor_joint(hand, k);
      way = std::min(way, ((rate > 0 ? joint.upper : joint.lower) - positions[k]) / rate);
    }
    const double rate = preshape.closing[static_cast<std::size_t>(i)].rate;
    if (rate != 0 && std::isfinite(way)) closed[i] += rate * std::max(0.0, way);
    const robot::Joint& joint = motor_joint(hand, i);
    closed[i] = std::clamp(closed[i], joint.lower, joint.upper);
  }
  return closed;
}

std::vector<double> efforts_for(const robot::HandModel& hand,
                                const Eigen::Ref<const Eigen::VectorXd>& positions, double force) {
  check_size(hand, positions);
  check_force(force);
  const robot::FingertipWays tips = robot::fingertip_ways(hand, positions);
  std::vector<double> efforts;
  for (int i = 0; i < hand.size(); ++i) {
    const robot::Joint& joint = motor_joint(hand, i);
    const double lever = hand.gripper ? 2 : tips.ways.col(i).norm();
    if (!(lever > 0)) {
      efforts.push_back(joint.max_effort);
      continue;
    }
    const double effort = force * lever;
    if (effort > joint.max_effort) {
      throw std::invalid_argument(
          fmt::format("a force of {:.1f} N is more than joint '{}' can: {:.1f} N at the fingertip",
                      force, joint.name, joint.max_effort / lever));
    }
    efforts.push_back(effort);
  }
  return efforts;
}

double current_for(const robot::GripperModel& gripper, double force) {
  check_force(force);
  const double most = gripper.max_current * gripper.force_per_current - gripper.friction_force;
  if (force > most) {
    throw std::invalid_argument(
        fmt::format("a force of {:.1f} N is more than gripper {} can: {:.1f} N of each finger",
                    force, gripper.name, most));
  }
  return (force + gripper.friction_force) / gripper.force_per_current;
}

}  // namespace prehend::control

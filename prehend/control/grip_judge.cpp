#include "prehend/control/grip_judge.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "prehend/control/arm_cycle.h"
#include "prehend/text/tree_file.h"

namespace prehend::control {

touch::Grip felt_grip(const touch::HandTouch& hand, const ArmPercepts& percepts,
                      const std::vector<std::string>& hand_joints,
                      const std::vector<double>& hand_positions) {
  std::vector<std::string> names = percepts.names;
  std::vector<double> positions = percepts.positions;
  if (hand_positions.size() == hand_joints.size()) {
    names.insert(names.end(), hand_joints.begin(), hand_joints.end());
    positions.insert(positions.end(), hand_positions.begin(), hand_positions.end());
  }
  return {hand.contacts(names, positions, percepts.frames), percepts.frames};
}

GripJudge::GripJudge(const robot::Platform& platform, touch::GraspStability model)
    : touch_(platform.hand),
      chain_(platform.arm_chain()),
      X_WB_(platform.X_WB),
      model_(std::move(model)) {}

GripJudge::GripJudge(const robot::Platform& platform)
    : GripJudge(platform,
                touch::GraspStability::load(text::tree_file("config/touch/grasp_stability.yaml"))) {
}

std::optional<GripJudge> GripJudge::of(const robot::Platform& platform) {
  if (platform.hand.pads.empty()) return std::nullopt;
  return GripJudge(platform);
}

std::optional<touch::Grip> GripJudge::felt(const ArmPercepts& percepts,
                                           const std::vector<std::string>& hand_joints,
                                           const std::vector<double>& hand_positions) const {
  try {
    return felt_grip(touch_, percepts, hand_joints, hand_positions);
  } catch (const std::invalid_argument&) {
    return std::nullopt;  // a joint or a pad that is not the platform's
  }
}

std::optional<double> GripJudge::height(const ArmPercepts& percepts) const {
  robot::Positions q(chain_.size());
  for (int i = 0; i < chain_.size(); ++i) {
    const auto found = std::find(percepts.names.begin(), percepts.names.end(),
                                 chain_.joints()[static_cast<std::size_t>(i)].name);
    if (found == percepts.names.end()) return std::nullopt;
    q[i] = percepts.positions.at(static_cast<std::size_t>(found - percepts.names.begin()));
  }
  return (X_WB_ * chain_.forward(q)).translation().z();
}

std::optional<double> GripJudge::closed(const ArmPercepts& percepts,
                                        const std::vector<std::string>& hand_joints,
                                        const std::vector<double>& hand_positions) {
  start_.reset();
  closed_ = felt(percepts, hand_joints, hand_positions);
  if (!closed_ || closed_->contacts.empty()) {
    closed_.reset();
    return std::nullopt;
  }
  start_ = height(percepts);
  return model_.probability(*closed_);
}

double GripJudge::if_pressed(double factor) const {
  return model_.probability(touch::pressed_harder(closed_.value(), factor));
}

std::optional<double> GripJudge::lifting(const ArmPercepts& percepts,
                                         const std::vector<std::string>& hand_joints,
                                         const std::vector<double>& hand_positions) {
  if (!closed_ || !start_) return std::nullopt;
  const std::optional<double> now = height(percepts);
  if (!now || *now < *start_ + kAskedWhenRisen) return std::nullopt;
  start_.reset();
  const std::optional<touch::Grip> grip = felt(percepts, hand_joints, hand_positions);
  if (!grip) return std::nullopt;
  return model_.probability(*closed_, &*grip);
}

}  // namespace prehend::control

// The hand puts itself in the middle of what its fingers have met beside its prediction.

#include <algorithm>

#include <fmt/format.h>

#include "prehend/control/arm_cycle.h"

namespace prehend::control {
namespace {

constexpr double kFeelingShare = 0.35;  // of the hand's greatest effort
constexpr double kLeastLeft = 0.02;     // of the approach's time
constexpr double kBack = 0.2;           // of the approach's time, that is gone back from contact
constexpr double kFarthest = 0.04;      // m, that a thing is thought to be beside its prediction
constexpr double kShiftTime = 0.5;      // s, at least; longer where a joint's speed asks for it

}  // namespace

bool ArmCycle::feel() {
  const bool can = options_.reacts && !hand_.feels_its_grip() && !grasp().shifts.empty() &&
                   segment(motion::SegmentKind::kApproach) != nullptr;
  if (!can || adapted_ >= options_.adaptations) return false;
  std::vector<double> gentle = grasp().largest_effort;
  for (double& effort : gentle) effort *= kFeelingShare;
  const Eigen::VectorXd sent = grasp().hand.at(options_.overrun);
  hand_.move(grasp().hand_joints, {sent.begin(), sent.end()}, options_.closing_speed, true, gentle);
  enter(Step::kFeel, "feeling where it is");
  return true;
}

bool ArmCycle::adapt(bool felt_only) {
  const std::vector<double> stopped = hand_.positions();
  const auto motors = static_cast<Eigen::Index>(grasp().hand_joints.size());
  const bool can = options_.reacts && !grasp().shifts.empty() &&
                   segment(motion::SegmentKind::kApproach) != nullptr &&
                   grasp().stops.size() == motors && grasp().fingertips.ways.cols() == motors &&
                   static_cast<Eigen::Index>(stopped.size()) == motors;
  if (!can || adapted_ >= options_.adaptations) return false;
  const Eigen::Vector3d beside_W = displacement_felt(
      grasp().hand.rate, grasp().stops, Eigen::Map<const Eigen::VectorXd>(stopped.data(), motors),
      grasp().hand.at(options_.overrun), grasp().fingertips);
  if (beside_W.norm() > kFarthest) return false;  // it is of another shape, not elsewhere
  shift_ = followed(beside_W, grasp().shifts);
  // What was only felt may stand in the middle by now; then the approach goes on.
  if (!felt_only && shift_.way_W.norm() <= options_.shift_tolerance) return false;
  if (shift_.way_W.norm() <= options_.shift_tolerance) shift_ = {};
  ++adapted_;
  const Eigen::VectorXd& open = grasp().hand.open;
  hand_.move(grasp().hand_joints, {open.begin(), open.end()}, options_.opening_speed, false, {});
  enter(Step::kLoosen,
        fmt::format("it is {:.0f} mm beside its prediction: letting go", 1e3 * beside_W.norm()));
  return true;
}

// Along the approach as it is from now on; back a little first from what stands in the way of it.
void ArmCycle::shift() {
  const JointTrajectory& approach = *segment(motion::SegmentKind::kApproach);
  const double gone =
      nearest_on(beside(approach, shifted_), percepts_.names, percepts_.positions).share;
  shifted_.resize(approach.joints.size());
  for (std::size_t k = 0; k < shift_.offsets.size(); ++k) shifted_.at(k) += shift_.offsets[k];
  const bool approaches = primitive() == Primitive::kApproach;
  const double share = std::max(gone - (approaches ? kBack : 0), kLeastLeft);
  JointTrajectory there{approach.joints,
                        {part_of(beside(approach, shifted_), share).points.back()}};
  there.points.front() = {0, there.points.front().position, {}, {}};
  there.points.push_back({kShiftTime, there.points.front().position, {}, {}});
  enter(Step::kShift, fmt::format("shifting the hand by {:.0f} mm", 1e3 * shift_.way_W.norm()));
  // What joined() fades out is all of the way. What the hand leaves does not stop it.
  follow(there, approaches ? 0 : options_.collision_force);
}

void ArmCycle::approach_again() {
  if (primitive() != Primitive::kApproach) return gather();
  const JointTrajectory left = beside(*segment(motion::SegmentKind::kApproach), shifted_);
  const double gone = nearest_on(left, percepts_.names, percepts_.positions).share;
  enter(Step::kApproach, "arm: approach");
  follow(reversed(part_of(reversed(left), std::max(1 - gone, kLeastLeft))), options_.contact_force);
}

}  // namespace prehend::control

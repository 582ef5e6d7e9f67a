#include "prehend/belief/act_perceiver.h"

#include <cmath>
#include <utility>

#include "prehend/robot/grip.h"

namespace prehend::belief {
namespace {

constexpr double kStill = 0.02, kStillJaw = 2e-3;  // rad, m: see PerceivedMotor

}  // namespace

PadImage pad_image(const contact::PadLayout& layout, const std::vector<double>& counts,
                   double newton_per_count, int touch_counts) {
  PadImage image;
  image.texels.reserve(counts.size());
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const bool touched =
        counts[i] > touch_counts && std::isfinite(counts[i]) && layout.scale[i] > 0;
    const double force = touched ? counts[i] * newton_per_count : 0;
    image.texels.push_back(force);
    if (!touched) continue;
    image.force += force;
    image.area += layout.area(i);
    image.center_P += force * layout.position(i);
  }
  if (image.force > 0) image.center_P /= image.force;
  return image;
}

ActPerceiver::ActPerceiver(const robot::HandModel& hand, robot::ClosingWay way, double touch_force)
    : hand_(hand), way_(std::move(way)), touch_force_(touch_force) {
  for (const robot::HandPad& pad : hand.pads) percepts_.pads.push_back({pad.name, {}, {}});
  for (const std::string& name : hand.actuated_names()) {
    percepts_.motors.push_back({name, {}, {}});
  }
}

void ActPerceiver::closing(const ActMoment& moment) {
  if (times_.empty()) start_ = moment.time;
  times_.push_back(moment.time - start_);
  motors_.push_back(moment.motors);
  if (moment.wrist) {
    sum_.force += moment.wrist->force;
    sum_.torque += moment.wrist->torque;
    ++wrenches_;
  }
  if (!touched_) {
    for (const PadImage& pad : moment.pads) {
      if (pad.force >= touch_force_) touched_ = times_.back();
    }
  }
  if (moment.motors.size() != way_.closed.size()) return;
  const double closure = way_.closure(moment.motors);
  for (std::size_t i = 0; i < moment.pads.size(); ++i) {
    std::optional<double>& touched_at = percepts_.pads[i].touched_at;
    if (!touched_at && moment.pads[i].force >= touch_force_) touched_at = closure;
  }
}

void ActPerceiver::closed(const ActMoment& moment) {
  note(kClosed, moment);
  if (wrenches_ > 0) percepts_.closing = Wrench{sum_.force / wrenches_, sum_.torque / wrenches_};
  for (std::size_t m = 0; m < percepts_.motors.size(); ++m) note_stop(m);
}

void ActPerceiver::lifted(const ActMoment& moment, const geometry::RigidTransform& X_WH) {
  note(kLifted, moment);
  // What it carries pulls it down.
  if (moment.wrist) percepts_.weight = -(X_WH.linear() * moment.wrist->force).z();
}

void ActPerceiver::note(std::size_t instant, const ActMoment& moment) {
  for (std::size_t i = 0; i < moment.pads.size(); ++i) {
    percepts_.pads[i].at[instant] = moment.pads[i];
  }
  percepts_.wrist[instant] = moment.wrist;
  if (moment.motors.size() != hand_.size()) return;
  for (std::size_t m = 0; m < percepts_.motors.size(); ++m) {
    percepts_.motors[m].at[instant] = moment.motors[static_cast<Eigen::Index>(m)];
  }
}

void ActPerceiver::note_stop(std::size_t motor) {
  PerceivedMotor& percept = percepts_.motors[motor];
  if (!percept.at[kClosed]) return;
  // A jaw comes fast to where it is predicted to touch, and from there on slowly; an act that is
  // foretold has one speed.
  const bool is_jaw = hand_.gripper.has_value();
  if (is_jaw && !touched_) return;
  const auto at = static_cast<Eigen::Index>(motor);
  const double still = hand_.gripper ? kStillJaw : kStill;
  std::size_t last = times_.size();
  while (last > 0 && at < motors_[last - 1].size() &&
         std::abs(motors_[last - 1][at] - *percept.at[kClosed]) <= still) {
    --last;
  }
  if (last < times_.size()) percept.stopped_after = times_[last] - (is_jaw ? *touched_ : 0);
}

}  // namespace prehend::belief

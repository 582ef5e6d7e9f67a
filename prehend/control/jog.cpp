#include "prehend/control/jog.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "prehend/geometry/symmetric_solve.h"
#include "prehend/motion/nearness.h"
#include "prehend/text/require.h"

namespace prehend::control {

using geometry::RigidTransform;
using robot::Positions;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

namespace {

constexpr int kNewtonSteps = 15;
constexpr double kExact = 1e-9;     // m and rad, of the tool on its way
constexpr double kDamping = 1e-6;   // lambda^2; m^2 or rad^2 for each rad^2
constexpr int kHalvings = 7;        // of the speed that is looked for
constexpr double kAtLimit = 1e-9;   // rad or m
constexpr double kStands = 2e-3;    // rad or m off the last set point
constexpr double kSlack = 1e-9;     // of comparisons, relative
constexpr double kNoNearer = 1e-9;  // m
constexpr double kSlowed = 0.95;    // of the speed asked for: less is told
constexpr double kCreeps = 0.01;    // of the speed asked for
constexpr double kLongestStep = 3;  // periods that one step may make good

// Of X_BG against where it is to be, [m] and [rad], in the base's frame.
Vector6 pose_error(const RigidTransform& wanted, const RigidTransform& now) {
  Vector6 error;
  const Eigen::AngleAxisd turn(Eigen::Quaterniond(wanted.linear() * now.linear().transpose()));
  error << wanted.translation() - now.translation(), turn.angle() * turn.axis();
  return error;
}

std::string number_of(const robot::ChainJoint& joint, double value) {
  return joint.is_revolute ? fmt::format("{:.1f} deg", value * 180 / M_PI)
                           : fmt::format("{:.1f} mm", value * 1000);
}

const char* axis_name(int axis) {
  constexpr const char* kNames[] = {"along x", "along y", "along z",
                                    "about x", "about y", "about z"};
  return kNames[axis];
}

// The greatest speed from which, after a step of `h`, an axis still stops within `way`.
double stopping_speed(double way, double acceleration, double h) {
  if (way <= 0) return 0;
  return acceleration * (std::sqrt(h * h + 2 * way / acceleration) - h);
}

}  // namespace

void JogOptions::validate() const {
  const text::Require require{"JogOptions."};
  const auto positive = [&](double value, const char* name) {
    require(value > 0 && std::isfinite(value), std::string(name) + " must be positive and finite");
  };
  positive(hold_time, "hold_time");
  positive(linear_speed, "linear_speed");
  positive(angular_speed, "angular_speed");
  positive(linear_acceleration, "linear_acceleration");
  positive(angular_acceleration, "angular_acceleration");
  positive(stale_time, "stale_time");
  positive(lag, "lag");
  positive(lag_time, "lag_time");
  positive(settle_time, "settle_time");
  positive(period, "period");
}

ArmJog::ArmJog(robot::KinematicChain chain, const Positions& acceleration,
               const RigidTransform& X_FG, const JogOptions& options)
    : chain_(std::move(chain)), acceleration_(acceleration), X_FG_(X_FG), options_(options) {
  options_.validate();
  const text::Require require{"ArmJog: "};
  require(acceleration_.size() == chain_.size(), "not one acceleration a joint");
  require((acceleration_.array() > 0).all() && acceleration_.allFinite(),
          "accelerations must be positive and finite");
  require(X_FG_.matrix().allFinite(), "the tool's pose is not finite");
  for (const robot::ChainJoint& joint : chain_.joints()) {
    require(joint.max_velocity > 0 && std::isfinite(joint.max_velocity),
            "joint '" + joint.name + "' has no velocity limit");
    require(!std::isnan(joint.lower) && !std::isnan(joint.upper),
            "joint '" + joint.name + "' has limits that are no numbers");
  }
  q_ = v_ = Positions::Zero(chain_.size());
}

void ArmJog::set_speed(double share) {
  text::Require{"ArmJog: "}(share > 0 && share <= 1, "the speed must be in (0, 1]");
  share_ = share;
}

void ArmJog::press(const JogMotion& motion, double time) {
  const text::Require require{"ArmJog: "};
  const int axes = motion.kind == JogMotion::Kind::kJoint ? chain_.size() : 6;
  require(motion.axis >= 0 && motion.axis < axes, "there is no such axis");
  require(motion.sign == 1 || motion.sign == -1, "the sign must be 1 or -1");
  pressed_ = motion;
  pressed_until_ = time + options_.hold_time;
}

void ArmJog::let_go() {
  pressed_.reset();
  active_.reset();
  settles_since_.reset();
  speed_ = 0;
  v_.setZero();
}

double ArmJog::greatest(const JogMotion& motion) const {
  if (motion.kind != JogMotion::Kind::kJoint) {
    return motion.axis < 3 ? options_.linear_speed : options_.angular_speed;
  }
  const auto j = static_cast<std::size_t>(motion.axis);
  const double most = chain_.joints()[j].max_velocity;
  // So that the tool, too, keeps its greatest speed, where it is now.
  const Eigen::Matrix<double, 6, Eigen::Dynamic> J = chain_.jacobian(q_);
  const Eigen::Vector3d arm = chain_.forward(q_).linear() * X_FG_.translation();
  const Eigen::Vector3d rate =
      J.col(motion.axis).head<3>() + J.col(motion.axis).tail<3>().cross(arm).eval();
  const double lever = rate.norm();
  return lever * most > options_.linear_speed ? options_.linear_speed / lever : most;
}

double ArmJog::acceleration(const JogMotion& motion) const {
  if (motion.kind == JogMotion::Kind::kJoint) return acceleration_[motion.axis];
  return motion.axis < 3 ? options_.linear_acceleration : options_.angular_acceleration;
}

void ArmJog::begin(const Positions& measured) {
  // Where it stands may be a little beyond a limit; no set point is.
  q_ = measured;
  for (int j = 0; j < chain_.size(); ++j) {
    const robot::ChainJoint& joint = chain_.joints()[static_cast<std::size_t>(j)];
    q_[j] = std::clamp(q_[j], joint.lower, joint.upper);
  }
  v_.setZero();
  floor_ = -std::numeric_limits<double>::infinity();
}

RigidTransform ArmJog::tool_after(double way) const {
  const Eigen::Vector3d axis = Eigen::Vector3d::Unit(active_->axis % 3);
  RigidTransform motion = RigidTransform::Identity();
  if (active_->axis < 3) {
    motion.translation() = way * axis;
  } else {
    motion.linear() = Eigen::AngleAxisd(way, axis).toRotationMatrix();
  }
  if (active_->kind == JogMotion::Kind::kTool) return X_BG_start_ * motion;
  RigidTransform X = X_BG_start_;
  X.linear() = motion.linear() * X_BG_start_.linear();
  X.translation() = X_BG_start_.translation() + motion.translation();
  return X;
}

std::optional<Positions> ArmJog::solve(const RigidTransform& X_BG) const {
  Positions q = q_;
  for (int i = 0; i < kNewtonSteps; ++i) {
    const RigidTransform X_BF = chain_.forward(q);
    const Vector6 error = pose_error(X_BG, X_BF * X_FG_);
    if (!error.allFinite()) return std::nullopt;
    if (error.norm() < kExact) return q;
    Eigen::Matrix<double, 6, Eigen::Dynamic> J = chain_.jacobian(q);
    const Eigen::Vector3d arm = X_BF.linear() * X_FG_.translation();
    for (int j = 0; j < chain_.size(); ++j) {
      J.col(j).head<3>() += J.col(j).tail<3>().cross(arm).eval();
    }
    const Matrix6 A = J * J.transpose() + kDamping * Matrix6::Identity();
    q += J.transpose() * geometry::symmetric_solve<6>(A, error);
  }
  return std::nullopt;
}

std::optional<Positions> ArmJog::after(double way) const {
  if (active_->kind != JogMotion::Kind::kJoint) return solve(tool_after(way_ + way));
  Positions q = q_;
  q[active_->axis] += way;
  return q;
}

bool ArmJog::allows(double speed, double h, JogStep* step) const {
  const auto refuse = [&](JogHindrance hindrance, std::string words) {
    step->hindrance = hindrance;
    step->words = std::move(words);
    return false;
  };
  const double a = acceleration(*active_);
  const double rest = speed * h + std::copysign(speed * speed / (2 * a), speed);
  const std::optional<Positions> next = after(speed * h), end = after(rest);
  if (!next || !end) {
    return refuse(JogHindrance::kCannot,
                  fmt::format("the tool does not get on {} from here: stretched, near a singular "
                              "position, or no joints for it. Move single joints",
                              axis_name(active_->axis)));
  }
  for (int j = 0; j < chain_.size(); ++j) {
    const robot::ChainJoint& joint = chain_.joints()[static_cast<std::size_t>(j)];
    const bool below = (*end)[j] < joint.lower - kAtLimit && (*end)[j] < q_[j];
    const bool above = (*end)[j] > joint.upper + kAtLimit && (*end)[j] > q_[j];
    if (below || above) {
      return refuse(JogHindrance::kLimit,
                    fmt::format("limit of joint '{}', {}", joint.name,
                                number_of(joint, below ? joint.lower : joint.upper)));
    }
    const double most = share_ * joint.max_velocity * h * (1 + kSlack);
    if (std::abs((*next)[j] - q_[j]) > most) {
      return refuse(
          JogHindrance::kSpeed,
          fmt::format("joint '{}' would be too fast: near a singular position", joint.name));
    }
  }
  if (!space_) return true;
  for (const Positions& q : {*next, *end}) {
    const motion::Nearness near = motion::nearness(*space_, q);
    if (near.distance >= floor_ - kNoNearer) continue;
    return refuse(JogHindrance::kNear, motion::pair_of(*space_, near) + " would touch");
  }
  return true;
}

std::string ArmJog::lag_of(const Positions& measured) const {
  for (int j = 0; j < chain_.size(); ++j) {
    const robot::ChainJoint& joint = chain_.joints()[static_cast<std::size_t>(j)];
    const double off = q_[j] - measured[j];
    if (std::abs(off) <= options_.lag + options_.lag_time * std::abs(v_[j])) continue;
    return fmt::format("joint '{}' does not follow: it is {} from where it was told to be",
                       joint.name, number_of(joint, std::abs(off)));
  }
  return {};
}

JogStep ArmJog::end(JogHindrance hindrance, const std::string& words) {
  JogStep step;
  step.ended = is_moving();
  step.hindrance = hindrance;
  step.words = words;
  let_go();
  return step;
}

JogStep ArmJog::step(const Positions& measured, double age, double time) {
  const double since = last_time_ ? time - *last_time_ : 0;
  const double h = std::clamp(last_time_ ? time - *last_time_ : options_.period,
                              1e-3 * options_.period, kLongestStep * options_.period);
  last_time_ = time;
  if (pressed_ && !(time < pressed_until_)) pressed_.reset();
  if (!active_ && !pressed_) return {};
  if (measured.size() != chain_.size() || !measured.allFinite()) {
    return end(JogHindrance::kSilent, "nobody tells where the arm's joints are");
  }
  if (!(age <= options_.stale_time)) {
    return end(JogHindrance::kSilent,
               fmt::format("where the joints are was told {:.1f} s ago", age));
  }
  // Who was stopped meanwhile must not go on where it was: the driver has braked.
  if (active_ && since > options_.stale_time) {
    return end(JogHindrance::kSilent, fmt::format("this program was held up for {:.1f} s", since));
  }
  if (!active_) begin(measured);
  if (const std::string lag = lag_of(measured); active_ && !lag.empty()) {
    return end(JogHindrance::kDoesNotFollow, lag);
  }
  // Another motion begins where this one has come to rest.
  if (pressed_ && (!active_ || (speed_ == 0 && !active_->is_along(*pressed_)))) {
    active_ = JogMotion{pressed_->kind, pressed_->axis, 1};
    X_BG_start_ = X_BG(q_);
    way_ = 0;
  }
  JogStep step;
  const bool goes = pressed_ && pressed_->is_along(*active_);
  if (goes) step.asked = pressed_->sign * share_ * greatest(*active_);
  const double change = acceleration(*active_) * h;
  const double wanted = std::clamp(step.asked, speed_ - change, speed_ + change);
  // What is too near already may be so, but no nearer than it was since the motion began.
  if (space_) floor_ = std::max(floor_, std::min(0.0, motion::nearness(*space_, q_).distance));
  double speed = wanted;
  if (wanted != 0 && !allows(wanted, h, &step)) {
    double low = 0, high = 1;  // shares of `wanted`
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = (low + high) / 2;
      (allows(middle * wanted, h, &step) ? low : high) = middle;
    }
    speed = low * wanted;
  }
  // While it speeds up, what is in the way of more than it has now is no news.
  if (std::abs(speed) >= kSlowed * std::abs(step.asked) || !goes) {
    step.hindrance = JogHindrance::kNone;
    step.words.clear();
  }
  Positions next = q_;
  if (speed != 0) next = *after(speed * h);
  for (int j = 0; j < chain_.size(); ++j) {
    const robot::ChainJoint& joint = chain_.joints()[static_cast<std::size_t>(j)];
    next[j] = std::clamp(next[j], joint.lower, joint.upper);
  }
  v_ = (next - q_) / h;
  q_ = next;
  way_ += speed * h;
  speed_ = step.speed = speed;
  step.set_point = q_;
  if (speed_ != 0 || pressed_) {
    settles_since_.reset();
    return step;
  }
  if (!settles_since_) settles_since_ = time;
  if ((measured - q_).cwiseAbs().maxCoeff() > kStands &&
      time - *settles_since_ < options_.settle_time) {
    return step;
  }
  let_go();
  step.set_point.reset();
  step.ended = true;
  return step;
}

std::vector<Positions> ArmJog::ahead(const JogMotion& motion, const Positions& measured,
                                     double duration, JogStep* end) const {
  ArmJog other = *this;
  other.let_go();
  other.last_time_.reset();
  std::vector<Positions> steps;
  Positions q = measured;
  bool holds = true;
  for (int i = 0; holds || other.is_moving(); ++i) {
    const double time = i * options_.period;
    holds = holds && time < duration;
    if (holds) {
      other.press(motion, time);
    } else {
      other.release();
    }
    const JogStep step = other.step(q, 0, time);
    if (step.hindrance != JogHindrance::kNone) *end = step;
    if (!step.set_point) break;
    // What it can only creep to is not waited for.
    if (holds && std::abs(step.speed) < kCreeps * std::abs(step.asked) && i > 0) holds = false;
    q = *step.set_point;
    steps.push_back(q);
  }
  if (!steps.empty() && (steps.back() - measured).cwiseAbs().maxCoeff() < kAtLimit) steps.clear();
  return steps;
}

AxisJog::AxisJog(const Axis& axis, const JogOptions& options) : axis_(axis), options_(options) {
  options_.validate();
  const text::Require require{"AxisJog: "};
  require(axis.lower <= axis.upper, "limits cross");
  require(axis.greatest_speed > 0 && std::isfinite(axis.greatest_speed),
          "the greatest speed must be positive and finite");
  require(axis.acceleration > 0 && std::isfinite(axis.acceleration),
          "the acceleration must be positive and finite");
}

void AxisJog::press(double sign, double time) {
  text::Require{"AxisJog: "}(sign == 1 || sign == -1, "the sign must be 1 or -1");
  sign_ = sign;
  pressed_until_ = time + options_.hold_time;
}

AxisJog::Step AxisJog::step(double position, double age, double share, double time) {
  Step step;
  if (!(time < pressed_until_)) sign_ = 0;
  if (sign_ != 0 && !(std::isfinite(position) && age <= options_.stale_time)) {
    step.hindrance = JogHindrance::kSilent;
    sign_ = 0;
  }
  double speed = 0;
  if (sign_ != 0) {
    const double way = sign_ > 0 ? axis_.upper - position : position - axis_.lower;
    const double asked = share * axis_.greatest_speed;
    speed = std::min(asked, stopping_speed(way, axis_.acceleration, options_.period + age));
    if (speed < kSlowed * asked) step.hindrance = JogHindrance::kLimit;
    if (way <= kStands * std::min(axis_.upper - axis_.lower, 1.0)) speed = 0;
  }
  step.ended = moves_ && speed == 0;
  moves_ = speed != 0;
  if (moves_) step.speed = sign_ * speed;
  return step;
}

}  // namespace prehend::control

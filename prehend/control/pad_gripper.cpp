#include "prehend/control/pad_gripper.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "prehend/text/require.h"

namespace prehend::control {
namespace {

constexpr double kClosed = 1e-3;    // m, of the opening: nothing is between the pads
constexpr double kBreakAway = 0.5;  // s, after which a drive that stands is blocked
constexpr double kLeastPush = 5;    // N, per finger, that breaks the drive away

std::string millimetres(double metres) { return fmt::format("{:.1f} mm", metres * 1e3); }

}  // namespace

void PadGripperOptions::validate() const {
  knobs(*this, text::CheckKnobs{"PadGripperOptions."});
  const text::Require require{"PadGripperOptions."};
  require(std::isfinite(touch_force) && touch_force > 0, "touch_force must be positive");
  require(std::isfinite(stale_time) && stale_time > 0, "stale_time must be positive");
  force.validate();
}

PadGripper::PadGripper(const robot::GripperModel& gripper, const PadGripperOptions& options,
                       GripperPort& port)
    : gripper_(gripper), options_(options), port_(port), controller_(options.force) {
  options_.validate();
  set_gripper(gripper);
}

void PadGripper::set_gripper(const robot::GripperModel& gripper) {
  gripper_ = gripper;
  options_.force.force_per_current = gripper.force_per_current;
  options_.force.largest_current = gripper.nominal_current;
  controller_ = ForceController(options_.force);
}

void PadGripper::prepare(const ArmGrasp& grasp) {
  force_ = std::min(grasp.force, std::max(0.0, most()));
  predicted_opening_ = 2 * grasp.hand.closed[0];
}

void PadGripper::move(const std::vector<std::string>& /*joints*/,
                      const std::vector<double>& positions, double speed, bool until_contact,
                      const std::vector<double>& /*effort*/) {
  problem_.clear();
  is_blocked_ = false;
  begun_ = now_;
  mode_ = until_contact ? Mode::kCloses : Mode::kMoves;
  status_ = MotionStatus::kMoving;
  if (until_contact) return;
  port_.move_to(std::min(2 * positions.at(0), gripper_.max_opening), speed * gripper_.max_speed);
}

MotionStatus PadGripper::motion() {
  if (mode_ != Mode::kMoves) return status_;
  const MotionStatus status = port_.motion();
  // What opens and is blocked is no contact that anybody asked for.
  if (status == MotionStatus::kContact || status == MotionStatus::kFailed) {
    is_blocked_ = status == MotionStatus::kContact;
    problem_ = is_blocked_ ? "the gripper does not open" : "the gripper's motion failed";
    return MotionStatus::kFailed;
  }
  return status;
}

std::vector<double> PadGripper::positions() {
  if (!percept_) return {};
  return {percept_->opening / 2};
}

void PadGripper::stop() {
  mode_ = Mode::kStands;
  port_.stop();
}

void PadGripper::press() {
  controller_.start(force_, mean_sum());
  rises_since_.reset();
  updated_ = begun_ = now_;
  settled_since_.reset();
  mode_ = Mode::kPresses;
  status_ = MotionStatus::kMoving;
}

double PadGripper::most() const {
  return options_.force.largest_current * gripper_.force_per_current - gripper_.friction_force;
}

bool PadGripper::hold_harder(double factor, double largest) {
  if (mode_ != Mode::kHolds) return false;
  const double limit = largest > 0 ? std::min(largest, most()) : most();
  const double force = std::min(factor * force_, limit);
  if (!(force > force_)) return false;
  force_ = force;
  controller_.aim(force_);
  rises_since_ = now_;
  return true;
}

bool PadGripper::press_harder(double factor) {
  const double force = std::min(factor * force_, most());
  if (!(force > force_)) return false;
  force_ = force;
  press();
  return true;
}

void PadGripper::step(const ArmPercepts& percepts) {
  now_ = percepts.time;
  percept_ = percepts.gripper;
  left_.reset();
  right_.reset();
  for (const PadPercept& pad : percepts.pads) {
    if (pad.name == "left") left_ = pad;
    if (pad.name == "right") right_ = pad;
  }
  if (!percept_ || !left_ || !right_) return;  // who asks inputs() stops
  if (mode_ == Mode::kCloses) close();
  if (mode_ == Mode::kPresses) settle();
  if (mode_ == Mode::kHolds) hold();
}

void PadGripper::fail(const std::string& problem) {
  problem_ = problem;
  mode_ = Mode::kStands;
  status_ = MotionStatus::kFailed;
}

void PadGripper::close() {
  const bool left = left_->sum > options_.touch_force, right = right_->sum > options_.touch_force;
  if (left && right) {
    mode_ = Mode::kStands;
    status_ = MotionStatus::kContact;
    return;
  }
  const std::string felt =
      left || right ? std::string("only the ") + (left ? "left" : "right") + " pad felt something"
                    : "neither pad felt anything";
  if (percept_->blocked && now_ - begun_ > kBreakAway) return fail("closing was blocked, " + felt);
  if (percept_->opening < kClosed) return fail("closed completely, " + felt);
  if (now_ - begun_ > options_.closing_timeout) return fail("closing timed out, " + felt);
  // Enough to break the drive away and push the object to the middle, not more than the grasp.
  const double current = std::clamp(
      (gripper_.friction_force + std::max(kLeastPush, force_ / 2)) / gripper_.force_per_current,
      options_.force.least_current, options_.force.largest_current);
  // Faster through what should be empty.
  const bool far =
      !left && !right && percept_->opening > predicted_opening_ + options_.closing_margin;
  port_.command_velocity(-(far ? options_.fast_closing_speed : options_.closing_speed), current);
}

void PadGripper::regulate() {
  const double current = controller_.update(mean_sum(), now_ - updated_);
  updated_ = now_;
  port_.command_velocity(-options_.pressing_speed, current);
}

void PadGripper::hold() {
  regulate();
  if (!rises_since_) return;
  // Pressed harder, foam gives way further: that is no collapse.
  if (!controller_.settled() && now_ - *rises_since_ <= options_.force_timeout) return;
  if (percept_->opening >= kClosed) grip_opening_ = percept_->opening;
  rises_since_.reset();
}

void PadGripper::settle() {
  regulate();
  if (!controller_.settled()) settled_since_.reset();
  if (controller_.settled() && !settled_since_) settled_since_ = now_;
  if (percept_->opening < kClosed) return fail("the object slipped out while gripping");
  if (!settled_since_ || now_ - *settled_since_ < options_.settled_time) {
    if (now_ - begun_ <= options_.force_timeout) return;
    // Dry friction of the drive can hold more than was asked for: that is no reason to let go.
    const double felt = mean_sum();
    if (felt < options_.least_share * force_ || felt > options_.largest_excess * force_) {
      return fail(
          fmt::format("the grasp force was not reached: {:.1f} N of {:.1f} N", felt, force_));
    }
  }
  grip_opening_ = percept_->opening;
  mode_ = Mode::kHolds;
  status_ = MotionStatus::kReached;
}

std::vector<InputAge> PadGripper::inputs() const {
  const auto age = [](const auto& percept) {
    return percept ? std::optional(percept->age) : std::nullopt;
  };
  return {{"the gripper's state", age(percept_), options_.stale_time},
          {"the left pad's frames", age(left_), options_.stale_time},
          {"the right pad's frames", age(right_), options_.stale_time}};
}

std::string PadGripper::fault() const {
  if (!percept_ || percept_->error == 0) return {};
  return "the gripper reports error " + std::to_string(percept_->error);
}

bool PadGripper::touches() const {
  const auto feels = [this](const std::optional<PadPercept>& pad) {
    return pad && pad->sum > std::max(options_.touch_force, options_.early_force);
  };
  return feels(left_) || feels(right_);
}

std::string PadGripper::lost(bool rests) const {
  if (!percept_ || !left_ || !right_) return {};
  // While the force rises, what is felt follows.
  const double wanted = rises_since_ ? std::min(force_, controller_.reference()) : force_;
  const double least = std::max(options_.touch_force, options_.held_ratio * wanted);
  const PadPercept& less = left_->sum < right_->sum ? *left_ : *right_;
  const PadPercept& more = left_->sum < right_->sum ? *right_ : *left_;
  // The jaws press with one force: what a pad feels less of it is borne beside its cells. What both
  // feel is held, though it turned in the jaws until they came closer; jaws that are closed feel
  // each other.
  if (less.sum >= options_.touch_force && more.sum >= least && percept_->opening >= kClosed) {
    return {};
  }
  const double least_opening =
      rises_since_ ? kClosed : std::max(kClosed, grip_opening_ - options_.largest_collapse);
  if (percept_->opening < least_opening) {
    return "the opening collapsed from " + millimetres(grip_opening_) + " to " +
           millimetres(percept_->opening);
  }
  // What stands leans on one pad more than on the other, but it stays between them.
  if (rests) return {};
  return fmt::format("the {} pad feels only {:.1f} N", less.name, less.sum);
}

std::string PadGripper::grip() const {
  return fmt::format("gripped with {:.1f} N at an opening of {}", controller_.target(),
                     millimetres(grip_opening_));
}

std::string PadGripper::still_felt() const {
  const double left = left_ ? left_->sum : 0, right = right_ ? right_->sum : 0;
  if (std::max(left, right) <= options_.touch_force) return {};
  return fmt::format("the pads still feel {:.1f} N and {:.1f} N", left, right);
}

}  // namespace prehend::control

#include "prehend/control/jog_session.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

namespace prehend::control {
namespace {

constexpr double kRun = 1;          // s, of a trajectory before it slows down
constexpr double kStanding = 0.02;  // of the speed asked for
constexpr std::array kSpeeds{0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0};

std::vector<JogRow> rows_of_arm(const robot::KinematicChain& chain) {
  std::vector<JogRow> rows;
  for (const robot::ChainJoint& joint : chain.joints()) {
    rows.push_back(
        {joint.name, false, joint.is_revolute, joint.lower, joint.upper, joint.max_velocity});
  }
  return rows;
}

}  // namespace

JogKey jog_key(int character) {
  switch (character) {
    case '+':
    case '=':
      return JogKey::kPlus;
    case '-':
    case '_':
      return JogKey::kMinus;
    case '\t':
      return JogKey::kNext;
    case 'm':
      return JogKey::kMode;
    case 'x':
      return JogKey::kAxisX;
    case 'y':
      return JogKey::kAxisY;
    case 'z':
      return JogKey::kAxisZ;
    case 'r':
      return JogKey::kRoll;
    case 'p':
      return JogKey::kPitch;
    case 'w':
      return JogKey::kYaw;
    case ',':
    case '<':
    case '[':
      return JogKey::kSlower;
    case '.':
    case '>':
    case ']':
      return JogKey::kFaster;
    case 'o':
      return JogKey::kOpen;
    case 'c':
      return JogKey::kClose;
    case '!':
    case 27:  // Escape
      return JogKey::kEmergency;
    case 'q':
      return JogKey::kQuit;
    default:
      return JogKey::kStop;
  }
}

JogSession::JogSession(ArmJog arm, std::vector<JogRow> hand,
                       const std::vector<double>& accelerations, const JogOptions& options)
    : arm_(std::move(arm)), rows_(rows_of_arm(arm_.chain())) {
  if (accelerations.size() != hand.size()) {
    throw std::invalid_argument("JogSession: not one acceleration for each joint of the hand");
  }
  for (std::size_t i = 0; i < hand.size(); ++i) {
    hand[i].is_hand = true;
    hand_.emplace_back(
        AxisJog::Axis{hand[i].lower, hand[i].upper, hand[i].greatest_speed, accelerations[i]},
        options);
    rows_.push_back(std::move(hand[i]));
  }
}

bool JogSession::is_moving() const {
  return arm_.is_moving() || run_ ||
         std::any_of(hand_.begin(), hand_.end(),
                     [](const AxisJog& axis) { return axis.is_moving(); });
}

void JogSession::release() {
  arm_.release();
  for (AxisJog& axis : hand_) axis.release();
}

void JogSession::move(double sign, double time) {
  words_.clear();
  hindrance_ = JogHindrance::kNone;
  refused_ = true;  // unless step() finds that it may
  if (mode_ != Kind::kJoint) return arm_.press({mode_, axis_, sign}, time);
  const int first = arm_.chain().size();
  if (row_ < first) return arm_.press({mode_, row_, sign}, time);
  hand_[static_cast<std::size_t>(row_ - first)].press(sign, time);
}

void JogSession::key(JogKey key, double time) {
  const auto choose_axis = [&](int axis) {
    release();
    // Of a joint's mode the letters mean nothing: then they are as any other key.
    if (mode_ != Kind::kJoint) axis_ = axis;
  };
  const auto turn = [](int& at, int by, int count) { at = (at + by + count) % count; };
  const auto choose = [&](int by) {
    release();
    if (mode_ == Kind::kJoint) {
      turn(row_, by, static_cast<int>(rows_.size()));
    } else {
      turn(axis_, by, 6);
    }
  };
  const auto change_speed = [&](int by) {
    // Of the steps the nearest, then one on.
    const auto at = std::lower_bound(kSpeeds.begin(), kSpeeds.end(), arm_.speed() * 0.999);
    const auto index = std::clamp<std::ptrdiff_t>(at - kSpeeds.begin() + by, 0,
                                                  static_cast<std::ptrdiff_t>(kSpeeds.size()) - 1);
    arm_.set_speed(kSpeeds[static_cast<std::size_t>(index)]);
  };
  switch (key) {
    case JogKey::kPlus:
      return move(1, time);
    case JogKey::kMinus:
      return move(-1, time);
    case JogKey::kPrevious:
      return choose(-1);
    case JogKey::kNext:
      return choose(1);
    case JogKey::kMode:
      release();
      mode_ = mode_ == Kind::kJoint  ? Kind::kBase
              : mode_ == Kind::kBase ? Kind::kTool
                                     : Kind::kJoint;
      return;
    case JogKey::kAxisX:
      return choose_axis(0);
    case JogKey::kAxisY:
      return choose_axis(1);
    case JogKey::kAxisZ:
      return choose_axis(2);
    case JogKey::kRoll:
      return choose_axis(3);
    case JogKey::kPitch:
      return choose_axis(4);
    case JogKey::kYaw:
      return choose_axis(5);
    case JogKey::kSlower:
      return change_speed(-1);
    case JogKey::kFaster:
      return change_speed(1);
    case JogKey::kOpen:
      pending_.open_hand = true;
      pending_.close_hand = false;
      return release();
    case JogKey::kClose:
      pending_.close_hand = true;
      pending_.open_hand = false;
      return release();
    case JogKey::kStop:
    case JogKey::kEmergency:
    case JogKey::kQuit:
      release();
      pending_.open_hand = pending_.close_hand = false;
      // Jaws that stand may hold something: they are not told to stop.
      pending_.end_hand_motion = true;
      if (key == JogKey::kEmergency) pending_.emergency = pending_.stop_arm = true;
      if (key == JogKey::kQuit) pending_.quit = true;
      return;
  }
}

void JogSession::step_by_runs(const JogPercepts& percepts, JogCommands* commands) {
  const std::optional<JogMotion> pressed = arm_.pressed(percepts.time);
  const bool told =
      percepts.arm.size() == arm_.chain().size() && percepts.arm_age <= arm_.options().stale_time;
  if (run_) {
    if (!told || pressed != run_) commands->end_run = percepts.arm_runs;
    if (percepts.arm_runs) return;
    run_.reset();
  }
  if (!pressed || percepts.arm_runs) return;
  if (!told) {
    hindrance_ = JogHindrance::kSilent;
    words_ = "nobody tells where the arm's joints are";
    return arm_.let_go();
  }
  JogStep end;
  commands->run = arm_.ahead(*pressed, percepts.arm, kRun, &end);
  hindrance_ = end.hindrance;
  words_ = end.words.empty() ? "" : (commands->run.empty() ? "stopped: " : "ahead: ") + end.words;
  if (!commands->run.empty()) run_ = pressed;
}

JogCommands JogSession::step(const JogPercepts& percepts) {
  JogCommands commands = std::exchange(pending_, {});
  if (commands.emergency) {
    commands.end_run = run_.has_value();
    arm_.let_go();
  }
  if (!percepts.forbidden.empty()) {
    commands.open_hand = commands.close_hand = false;
    commands.end_hand_motion = true;
    if (arm_.is_moving()) commands.stop_arm = true;
    commands.end_run = run_.has_value();
    if (!percepts.arm_runs) run_.reset();
    for (AxisJog& axis : hand_) commands.stop_hand = commands.stop_hand || axis.is_moving();
    release();
    arm_.let_go();
    for (AxisJog& axis : hand_) axis.step(0, 0, 1, percepts.time);
    if (std::exchange(refused_, false)) words_ = percepts.forbidden;
    return commands;
  }
  refused_ = false;
  const bool is_pressed = arm_.pressed(percepts.time).has_value();
  if (!percepts.arm_forbidden.empty() && (arm_.is_moving() || is_pressed)) {
    commands.stop_arm = commands.stop_arm || arm_.is_moving();
    arm_.let_go();
    words_ = percepts.arm_forbidden;
  }
  if (percepts.arm_takes_runs) step_by_runs(percepts, &commands);
  JogStep arm = percepts.arm_takes_runs ? JogStep()
                                        : arm_.step(percepts.arm, percepts.arm_age, percepts.time);
  commands.arm = arm.set_point;
  commands.stop_arm = commands.stop_arm || arm.ended;
  if (arm.hindrance != JogHindrance::kNone) {
    hindrance_ = arm.hindrance;
    const bool stands = std::abs(arm.speed) <= kStanding * std::abs(arm.asked);
    words_ = (stands ? "stopped: " : "slowed down: ") + arm.words;
  } else if (arm.asked != 0) {
    hindrance_ = JogHindrance::kNone;
    words_.clear();
  }
  const auto first = static_cast<std::size_t>(arm_.chain().size());
  for (std::size_t i = 0; i < hand_.size(); ++i) {
    const double position =
        i < percepts.hand.size() ? percepts.hand[i] : std::numeric_limits<double>::quiet_NaN();
    const AxisJog::Step step =
        hand_[i].step(position, percepts.hand_age, arm_.speed(), percepts.time);
    if (step.speed) commands.hand = {static_cast<int>(i), *step.speed};
    commands.stop_hand = commands.stop_hand || step.ended;
    if (step.hindrance == JogHindrance::kNone) continue;
    hindrance_ = step.hindrance;
    words_ = step.hindrance == JogHindrance::kSilent
                 ? fmt::format("nobody tells where '{}' is", rows_[first + i].name)
                 : fmt::format("'{}' is at its limit", rows_[first + i].name);
  }
  // One joint moves at a time: what another one's stop would end as well goes on with the next.
  if (commands.hand) commands.stop_hand = false;
  return commands;
}

}  // namespace prehend::control

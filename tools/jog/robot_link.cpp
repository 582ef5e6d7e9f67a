#include "tools/jog/robot_link.h"

#include <signal.h>

#include <algorithm>
#include <stdexcept>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "msgs/graph.pb.h"
#include "prehend/text/nearest_match.h"
#include "prehend/touch/hand_touch.h"
#include "tools/command_node.h"

namespace prehend::tools {
namespace {

using std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr auto kEmergencyPatience = 500ms;
constexpr double kEmergencySilence = 1;  // s, of who repeats it several times a second
constexpr std::size_t kMostNews = 50;

std::atomic<bool> interrupt_came = false;

void note_interrupt(int) { interrupt_came = true; }

double age_of(steady_clock::time_point time) {
  if (time == steady_clock::time_point{}) return 1e9;
  return std::chrono::duration<double>(steady_clock::now() - time).count();
}

}  // namespace

void notice_interrupts() {
  struct sigaction action = {};
  action.sa_handler = note_interrupt;
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
  action.sa_flags = SA_RESTART;
  ::sigaction(SIGHUP, &action, nullptr);
}

bool interrupted() { return interrupt_came; }

RobotLink::RobotLink(const std::string& name, const std::string& registry,
                     const robot::Platform& platform)
    : platform_(platform),
      chain_(platform.arm_chain()),
      has_gripper_(platform.hand_port == robot::HandPort::kGripper),
      node_(command_node(name, registry)),
      emergency_stop_(node_, "prehend " + name) {
  using graph::QoS;
  using graph::Received;
  for (const std::string& joint : platform_.hand.actuated_names()) {
    hand_names_.push_back("hand_" + joint);
  }
  arm_commands_ = node_.advertise<msgs::JointCommand>("/arm/command", QoS::queue(10));
  stop_arm_ = node_.client<msgs::Empty, msgs::Acknowledge>("/arm/stop");
  follow_ = node_.action_client<msgs::FollowTrajectoryGoal, msgs::FollowTrajectoryFeedback,
                                msgs::FollowTrajectoryResult>("/arm/follow");
  subscriptions_.push_back(node_.subscribe<msgs::JointState>(
      "/joint_states", QoS::queue(50),
      [this](const Received<msgs::JointState>& state) { take(*state); }));
  if (has_gripper_) {
    gripper_commands_ = node_.advertise<msgs::GripperCommand>("/gripper/command", QoS::queue(10));
    stop_hand_ = node_.client<msgs::Empty, msgs::Acknowledge>("/gripper/stop");
    move_gripper_ = node_.action_client<msgs::MoveGripperGoal, msgs::MoveGripperFeedback,
                                        msgs::MoveGripperResult>("/gripper/move");
    subscriptions_.push_back(node_.subscribe<msgs::GripperState>(
        "/gripper/state", QoS::latest(), [this](const Received<msgs::GripperState>& state) {
          const std::lock_guard lock(mutex_);
          joints_.hand = {state->opening()};
          joints_.hand_velocity = {state->velocity()};
          joints_.gripper_blocked = state->blocked();
          hand_time_ = steady_clock::now();
        }));
  } else {
    hand_commands_ = node_.advertise<msgs::JointCommand>("/hand/command", QoS::queue(10));
    stop_hand_ = node_.client<msgs::Empty, msgs::Acknowledge>("/hand/stop");
    move_hand_ =
        node_.action_client<msgs::MoveHandGoal, msgs::MoveHandFeedback, msgs::MoveHandResult>(
            "/hand/move");
  }
  for (const robot::HandPad& pad : platform_.hand.pads) {
    subscriptions_.push_back(node_.subscribe<msgs::TactileFrame>(
        "/tactile/" + pad.name, QoS::latest(),
        [this, name = pad.name](const Received<msgs::TactileFrame>& frame) {
          const std::lock_guard lock(mutex_);
          pads_[name] = {frame->sum(), steady_clock::now()};
        }));
  }
  subscriptions_.push_back(node_.subscribe<msgs::EmergencyStop>(
      "/emergency_stop", QoS::latched(50), [this](const Received<msgs::EmergencyStop>& stop) {
        const std::lock_guard lock(mutex_);
        emergency_ = *stop;
        emergency_time_ = steady_clock::now();
      }));
  subscriptions_.push_back(node_.subscribe<msgs::graph::LogLine>(
      "/log", QoS::queue(100), [this](const Received<msgs::graph::LogLine>& line) {
        if (line->level() < msgs::graph::WARNING) return;
        say(line->node() + ": " + line->text());
      }));
  node_.spin_in_background();
}

RobotLink::~RobotLink() { node_.shutdown(); }

void RobotLink::say(std::string line) {
  const std::lock_guard lock(mutex_);
  news_.push_back(std::move(line));
  if (news_.size() > kMostNews) news_.pop_front();
}

std::vector<std::string> RobotLink::news() {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> lines(news_.begin(), news_.end());
  news_.clear();
  return lines;
}

void RobotLink::take(const msgs::JointState& state) {
  if (state.name_size() != state.position_size()) return;
  const std::vector<std::string> names(state.name().begin(), state.name().end());
  const auto index_of = [&](const std::string& name) {
    return static_cast<int>(std::find(names.begin(), names.end(), name) - names.begin());
  };
  const auto value = [](const google::protobuf::RepeatedField<double>& values, int i) {
    return i < values.size() ? values[i] : 0.0;
  };
  robot::Positions arm(chain_.size()), velocity(chain_.size());
  std::string lacking;
  for (int j = 0; j < chain_.size() && lacking.empty(); ++j) {
    const std::string& name = chain_.joints()[static_cast<std::size_t>(j)].name;
    const int i = index_of(name);
    if (i == state.name_size()) {
      lacking = fmt::format("'{}'{}", name, text::nearest_match_hint(name, names));
      break;
    }
    arm[j] = state.position(i);
    velocity[j] = value(state.velocity(), i);
  }
  std::vector<double> hand, hand_velocity, hand_effort;
  for (const std::string& name : hand_names_) {
    const int i = index_of(name);
    if (i == state.name_size()) break;
    hand.push_back(state.position(i));
    hand_velocity.push_back(value(state.velocity(), i));
    if (i < state.effort_size()) hand_effort.push_back(state.effort(i));
  }
  const std::lock_guard lock(mutex_);
  lacking_ = lacking;
  // Several publish on one topic: who has a hand alone says nothing of the arm.
  if (lacking.empty() && arm.allFinite()) {
    joints_.arm = arm;
    joints_.arm_velocity = velocity;
    arm_time_ = steady_clock::now();
  }
  if (has_gripper_ || hand.size() != hand_names_.size()) return;
  joints_.hand = hand;
  joints_.hand_velocity = hand_velocity;
  joints_.hand_effort = hand_effort.size() == hand.size() ? hand_effort : std::vector<double>();
  hand_time_ = steady_clock::now();
}

RobotLink::Joints RobotLink::joints() const {
  const std::lock_guard lock(mutex_);
  Joints joints = joints_;
  joints.arm_age = age_of(arm_time_);
  joints.hand_age = age_of(hand_time_);
  return joints;
}

RobotLink::Joints RobotLink::wait_for_joints(double patience, Needed needed) {
  const Time begin = steady_clock::now();
  while (true) {
    const Joints now = joints();
    const double waited = age_of(begin);
    const bool arm = now.arm_age < waited || needed == Needed::kHand;
    const bool hand = now.hand_age < waited || needed == Needed::kArm;
    if (arm && hand) return now;
    if (interrupted()) throw std::runtime_error("interrupted");
    if (waited > patience) {
      const std::lock_guard lock(mutex_);
      const std::string said = lacking_.empty() ? "" : "; /joint_states has no " + lacking_;
      if (!arm) {
        throw std::runtime_error(fmt::format(
            "/joint_states with the joints of {}'s arm did not come within {:.0f} s{}. Start the "
            "robot's drivers or the simulation, or name the robot by --platform (`prehend topic "
            "list`)",
            platform_.name, patience, said));
      }
      throw std::runtime_error(
          fmt::format("{} did not come within {:.0f} s. Start who moves the hand of {}",
                      has_gripper_ ? "/gripper/state" : "/joint_states with the hand's joints",
                      patience, platform_.name));
    }
    std::this_thread::sleep_for(5ms);
  }
}

Eigen::VectorXd RobotLink::hand_positions(const Joints& joints) const {
  const robot::HandModel& hand = platform_.hand;
  if (joints.hand.empty()) return hand.all_positions(hand.preshapes.front().open);
  if (has_gripper_) {
    return hand.all_positions(Eigen::VectorXd::Constant(1, joints.hand.front() / 2));
  }
  return touch::joint_positions(hand, hand_names_, joints.hand);
}

std::vector<RobotLink::Pad> RobotLink::pads() const {
  const std::lock_guard lock(mutex_);
  std::vector<Pad> pads;
  for (const auto& [name, felt] : pads_) pads.push_back({name, felt.first, age_of(felt.second)});
  return pads;
}

std::string RobotLink::forbidden() const {
  const std::lock_guard lock(mutex_);
  if (!emergency_) return {};
  if (emergency_->stopped()) {
    return fmt::format("emergency stop by {}: {}", emergency_->source(), emergency_->reason());
  }
  const double silent = age_of(emergency_time_);
  if (silent < kEmergencySilence) return {};
  return fmt::format("the node emergency_stop is silent for {:.0f} s", silent);
}

void RobotLink::command_arm(const robot::Positions& positions) {
  msgs::JointCommand command;
  command.mutable_header()->set_stamp(node_.clock().now());
  command.set_mode(msgs::JointCommand::POSITION);
  for (int j = 0; j < chain_.size(); ++j) {
    command.add_joint_name(chain_.joints()[static_cast<std::size_t>(j)].name);
    command.add_value(positions[j]);
  }
  arm_commands_.publish(command);
}

void RobotLink::stop_arm() {
  msgs::JointCommand command;
  command.mutable_header()->set_stamp(node_.clock().now());
  command.set_mode(msgs::JointCommand::STOP);
  arm_commands_.publish(command);
}

void RobotLink::run_arm(const std::vector<robot::Positions>& positions, double period) {
  msgs::FollowTrajectoryGoal goal;
  msgs::JointTrajectory& path = *goal.mutable_trajectory();
  for (const robot::ChainJoint& joint : chain_.joints()) path.add_joint_name(joint.name);
  const robot::Positions start = joints().arm;
  const auto at = [&](std::size_t i) -> const robot::Positions& {
    return i == 0 ? start : positions[std::min(i, positions.size()) - 1];
  };
  for (std::size_t i = 0; i <= positions.size(); ++i) {
    msgs::JointTrajectoryPoint& point = *path.add_points();
    point.set_time(period * static_cast<double>(i));
    const bool inner = i > 0 && i < positions.size();
    for (int j = 0; j < chain_.size(); ++j) {
      point.add_position(at(i)[j]);
      point.add_velocity(inner ? (at(i + 1)[j] - at(i - 1)[j]) / (2 * period) : 0);
    }
  }
  run_is_cut_ = false;
  run_ = follow_.send(goal);
  run_.on_result([this](const graph::Outcome<msgs::FollowTrajectoryResult>& outcome) {
    if (outcome.status() == graph::Status::kCancelled || (outcome.ok() && outcome->reached())) {
      return;
    }
    say("/arm/follow: " + (outcome.ok() ? outcome->reason() : outcome.error()));
  });
}

void RobotLink::end_run() {
  if (arm_runs() && !std::exchange(run_is_cut_, true)) run_.cancel();
}

// Without stamps: a clock that is not the drivers' must not make them old.
void RobotLink::command_hand(int motor, double speed) {
  if (has_gripper_) {
    msgs::GripperCommand command;
    command.set_mode(msgs::GripperCommand::VELOCITY);
    command.set_value(speed);
    return gripper_commands_.publish(command);
  }
  msgs::JointCommand command;
  command.set_mode(msgs::JointCommand::VELOCITY);
  command.add_joint_name(hand_names_.at(static_cast<std::size_t>(motor)));
  command.add_value(speed);
  hand_commands_.publish(command);
}

void RobotLink::stop_hand() {
  if (has_gripper_) {
    msgs::GripperCommand command;
    command.set_mode(msgs::GripperCommand::STOP);
    return gripper_commands_.publish(command);
  }
  msgs::JointCommand command;
  command.set_mode(msgs::JointCommand::STOP);
  hand_commands_.publish(command);
}

std::string RobotLink::emergency_stop(const std::string& reason) {
  stop_arm();
  std::string why = "there is no node emergency_stop";
  if (emergency_stop_.is_there()) {
    why = emergency_stop_.stop(reason, kEmergencyPatience);
    if (why.empty()) return "EMERGENCY STOP; prehend service call /emergency_stop/reset ends it";
  }
  // Whatever the reason: each device itself.
  const char* const hand_stop = has_gripper_ ? "/gripper/stop" : "/hand/stop";
  std::string done;
  for (const auto& [client, name] :
       {std::pair{&stop_arm_, "/arm/stop"}, std::pair{&stop_hand_, hand_stop}}) {
    if (!client->wait_for_server(0ns)) {
      done += fmt::format("; nobody serves {}", name);
      continue;
    }
    const auto answer = client->call({}, kEmergencyPatience / 2);
    done += answer.ok() && answer->success() ? fmt::format("; {} done", name)
            : answer.ok()                    ? fmt::format("; {}: {}", name, answer->reason())
                                             : "; " + answer.error();
  }
  return "EMERGENCY: " + why + done;
}

bool RobotLink::hand_is_served(double patience) const {
  const auto time =
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(patience));
  return has_gripper_ ? move_gripper_.wait_for_server(time) : move_hand_.wait_for_server(time);
}

void RobotLink::move_hand(const HandGoal& goal) {
  int number = 0;
  {
    const std::lock_guard lock(mutex_);
    hand_end_.reset();
    number = ++hand_goals_;
  }
  hand_moves_ = true;
  const auto ended = [this, number](HandEnd end) {
    const std::lock_guard lock(mutex_);
    if (number != hand_goals_) return;  // of one before
    hand_end_ = std::move(end);
    hand_moves_ = false;
  };
  if (has_gripper_) {
    msgs::MoveGripperGoal message;
    message.set_opening(2 * goal.positions[0]);
    message.set_speed(goal.speed * platform_.hand.gripper->max_speed);
    message.set_current_limit(goal.current);
    gripper_goal_ = move_gripper_.send(message);
    return gripper_goal_.on_result([ended](const graph::Outcome<msgs::MoveGripperResult>& outcome) {
      if (!outcome.has_value()) return ended({false, false, outcome.error()});
      ended({outcome->reached(), outcome->blocked(), outcome->reason()});
    });
  }
  msgs::MoveHandGoal message;
  for (std::size_t i = 0; i < hand_names_.size(); ++i) {
    message.add_joint_name(hand_names_[i]);
    message.add_position(goal.positions[static_cast<Eigen::Index>(i)]);
  }
  message.set_speed(goal.speed);
  message.set_until_contact(goal.until_contact);
  for (const double effort : goal.efforts) message.add_effort(effort);
  hand_goal_ = move_hand_.send(message);
  hand_goal_.on_result([ended](const graph::Outcome<msgs::MoveHandResult>& outcome) {
    if (!outcome.has_value()) return ended({false, false, outcome.error()});
    ended({outcome->reached(), outcome->blocked(), outcome->reason()});
  });
}

void RobotLink::cancel_hand() {
  if (!hand_moves_) return;
  if (has_gripper_) {
    gripper_goal_.cancel();
  } else {
    hand_goal_.cancel();
  }
}

std::optional<RobotLink::HandEnd> RobotLink::hand_end() {
  const std::lock_guard lock(mutex_);
  return std::exchange(hand_end_, std::nullopt);
}

}  // namespace prehend::tools

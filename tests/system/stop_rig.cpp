#include "tests/system/stop_rig.h"

#include <arpa/inet.h>
#include <signal.h>

#include <algorithm>
#include <cmath>
#include <thread>
#include <utility>

#include "drivers/kuka_rsi/transport/udp_socket.h"
#include "drivers/wire/stream/tcp_server.h"

namespace prehend::testing {
namespace {

using namespace std::chrono_literals;
using std::chrono::steady_clock;

constexpr double kStands = 2e-3;  // m/s or rad/s, of a joint, below which it stands
constexpr double kMoves = 0.01;   // ... above which it moves

bool wait_for(const std::function<bool()>& condition, std::chrono::seconds patience) {
  const auto end = steady_clock::now() + patience;
  while (!condition()) {
    if (steady_clock::now() > end) return false;
    std::this_thread::sleep_for(2ms);
  }
  return true;
}

template <class Handle>
std::string reason_of(const Handle& handle) {
  if (!handle) return "no goal was sent";
  const auto outcome = handle.wait(20s);
  if (!outcome.has_value()) return outcome.error();
  return outcome->reason();
}

void replace(std::string& text, const std::string& word, const std::string& by) {
  const auto at = text.find(word);
  if (at != std::string::npos) text.replace(at, word.size(), by);
}

}  // namespace

std::vector<StoppedRobot> stopped_robots() {
  return {
      {.name = "StageAndPg70",
       .launch_file = "launch/emulated_robot.yaml",
       .arguments = {"gripper:=pg70", "tactile:=dsa", "wrench:=ft300", "lines:=LINES",
                     "can:=slcan:LINES_can"},
       .required = {"pg70", "simulation", "ft300"},
       .world_joints = "/joint_states",
       .arm_set_points = "",
       .hand_set_points = "/world/gripper/command",
       .has_gripper = true,
       .hand_joint = "",
       .least = 0.005,
       .most = 0.065,
       .way = 0.15,
       .fault = {"pg70_emulator", "fault", "222", "0", "/gripper/acknowledge",
                 "pg70: the gripper stopped by itself: ERROR CURRENT", 0}},
      {.name = "KukaOverRsi",
       .launch_file = "launch/emulated_robot.yaml",
       .arguments = {"platform:=kr5_pg70", "arm:=rsi", "rsi_port:=PORT", "wrench:=ft300",
                     "lines:=LINES"},
       .required = {"kuka_rsi", "simulation", "ft300"},
       .world_joints = "/world/joint_states",
       .arm_set_points = "/world/arm/command",
       .hand_set_points = "",
       .hand_joint = "opening",
       .least = 0.002,
       .most = 0.032,
       .speed = 0.35,
       .way = 1.0,
       .fault = {"kuka_rsi_emulator", "emergency_stop", "true", "", "", "kuka_rsi: RSI has ended",
                 1}},
      {.name = "ArmAndSdh2",
       .launch_file = "launch/emulated_robot.yaml",
       .arguments = {"platform:=kr5_sdh", "hand:=sdh", "tactile:=dsa", "lines:=LINES"},
       .required = {"sdh", "simulation", "dsa"},
       .world_joints = "/world/joint_states",
       .arm_set_points = "",
       .hand_set_points = "/world/hand/command",
       .hand_joint = "finger_1_proximal",
       .least = 0,
       .most = 0.9,
       .way = 1.0,
       .fault = {"sdh_emulator", "mute", "true", "false", "", "sdh: the hand's answers are missing",
                 0}},
      {.name = "ArmAndBarrettHand",
       .launch_file = "launch/emulated_robot.yaml",
       .arguments = {"platform:=pa10_barrett", "hand:=barrett", "wrench:=ft300", "lines:=LINES"},
       .required = {"barrett", "simulation", "ft300"},
       .world_joints = "/world/joint_states",
       .arm_set_points = "",
       .hand_set_points = "/world/hand/command",
       .hand_joint = "finger_1_inner",
       .least = 0,
       .most = 1.8,
       .way = 1.0,
       .fault = {"barrett_emulator", "mute", "true", "false", "",
                 "barrett: the hand's answers are missing", 0}},
      {.name = "ArmAndSerialBarrettHand",
       .launch_file = "launch/emulated_robot.yaml",
       .arguments = {"platform:=pa10_barrett", "hand:=barrett", "barrett_model:=bh8_262",
                     "wrench:=ft300", "lines:=LINES"},
       .required = {"barrett", "simulation", "ft300"},
       .world_joints = "/world/joint_states",
       .arm_set_points = "",
       .hand_set_points = "/world/hand/command",
       .hand_joint = "finger_1_inner",
       .least = 0,
       .most = 1.8,
       .way = 1.0,
       .fault = {"barrett_serial_emulator", "mute", "true", "false", "",
                 "barrett: the hand's answers are missing", 0}}};
}

StopRig::StopRig(const StoppedRobot& robot)
    : robot_(robot),
      registry_(drivers::TcpServer().name()),  // its port is free again
      launched_("prehend", arguments_of(robot), scratch_.path() / "output.txt"),
      node_(options()),
      follow_(node_.action_client<msgs::FollowTrajectoryGoal, msgs::FollowTrajectoryFeedback,
                                  msgs::FollowTrajectoryResult>("/arm/follow")),
      move_gripper_(node_.action_client<msgs::MoveGripperGoal, msgs::MoveGripperFeedback,
                                        msgs::MoveGripperResult>("/gripper/move")),
      move_hand_(
          node_.action_client<msgs::MoveHandGoal, msgs::MoveHandFeedback, msgs::MoveHandResult>(
              "/hand/move")),
      stop_(node_.client<msgs::EmergencyStopRequest, msgs::Acknowledge>("/emergency_stop/stop")),
      reset_(node_.client<msgs::Empty, msgs::Acknowledge>("/emergency_stop/reset")) {
  subscriptions_.push_back(node_.subscribe<msgs::JointState>(
      robot.world_joints, graph::QoS::queue(200),
      [this](const graph::Received<msgs::JointState>& state) { take(*state); }));
  // What is planned from is what the driver says.
  if (robot.world_joints != "/joint_states") {
    subscriptions_.push_back(
        node_.subscribe<msgs::JointState>("/joint_states", graph::QoS::queue(200),
                                          [this](const graph::Received<msgs::JointState>& state) {
                                            const std::lock_guard lock(mutex_);
                                            keep_positions(*state);
                                          }));
  }
  if (robot.has_gripper) {
    subscriptions_.push_back(node_.subscribe<msgs::GripperState>(
        "/world/gripper/state", graph::QoS::queue(200),
        [this](const graph::Received<msgs::GripperState>& state) {
          const std::lock_guard lock(mutex_);
          hand_.push_back({steady_clock::now(), std::abs(state->velocity())});
          hand_position_ = state->opening();
        }));
    subscriptions_.push_back(node_.subscribe<msgs::GripperCommand>(
        robot.hand_set_points, graph::QoS::queue(200),
        [this](const graph::Received<msgs::GripperCommand>& command) {
          const std::lock_guard lock(mutex_);
          // It repeats the stop for as long as it holds.
          if (command->mode() == msgs::GripperCommand::STOP) return;
          hand_commands_.push_back(steady_clock::now());
        }));
  }
  if (!robot.arm_set_points.empty()) watch(robot.arm_set_points, arm_commands_, arm_command_);
  if (!robot.has_gripper && !robot.hand_set_points.empty()) {
    watch(robot.hand_set_points, hand_commands_, hand_command_);
  }
  subscriptions_.push_back(node_.subscribe<msgs::EmergencyStop>(
      "/emergency_stop", graph::QoS::latched(50),
      [this](const graph::Received<msgs::EmergencyStop>& state) {
        const std::lock_guard lock(mutex_);
        if (state->stopped() && !state_.stopped()) told_ = steady_clock::now();
        if (!state->stopped()) told_.reset();
        state_ = *state;
      }));
  start_emergency_stop();
  node_.spin_in_background();
}

StopRig::~StopRig() {
  node_.shutdown();
  launched_.send_signal(SIGINT);
  launched_.wait(20s);
}

void StopRig::watch(const std::string& topic, std::vector<Time>& changes, std::string& last) {
  subscriptions_.push_back(node_.subscribe<msgs::JointCommand>(
      topic, graph::QoS::queue(200),
      [this, &changes, &last](const graph::Received<msgs::JointCommand>& command) {
        const std::lock_guard lock(mutex_);
        msgs::JointCommand content = *command;
        content.clear_header();
        std::string now = content.SerializeAsString();
        if (now != std::exchange(last, now)) changes.push_back(steady_clock::now());
      }));
}

void StopRig::take(const msgs::JointState& state) {
  const std::lock_guard lock(mutex_);
  Sample arm{steady_clock::now(), 0}, hand = arm;
  const bool is_first = joints_.empty();
  for (int i = 0; i < std::min(state.name_size(), state.velocity_size()); ++i) {
    const bool of_hand = state.name(i).starts_with("hand_");
    double& speed = of_hand ? hand.speed : arm.speed;
    speed = std::max(speed, std::abs(state.velocity(i)));
    if (is_first && !of_hand) joints_.push_back(state.name(i));
    if (state.name(i) == "hand_" + robot_.hand_joint) hand_position_ = state.position(i);
  }
  arm_.push_back(arm);
  if (!robot_.has_gripper) hand_.push_back(hand);
  if (robot_.world_joints == "/joint_states") keep_positions(state);
}

// Under the lock. Each who tells has an order of its own.
void StopRig::keep_positions(const msgs::JointState& state) {
  for (int i = 0; i < std::min(state.name_size(), state.position_size()); ++i) {
    position_[state.name(i)] = state.position(i);
  }
}

void StopRig::start_emergency_stop() {
  std::string required = "required:=[";
  for (const std::string& node : robot_.required) {
    required += (required.back() == '[' ? "" : ", ") + node;
  }
  emergency_ = std::make_unique<Launched>(
      "emergency_stop",
      std::vector<std::string>{"--registry", registry_, "--param", required + "]"},
      scratch_.path() / "emergency_stop.txt");
}

std::string StopRig::wait_until_ready() {
  const bool are_there = wait_for(
      [this] {
        const std::lock_guard lock(mutex_);
        return !arm_.empty() && !hand_.empty() &&
               std::ranges::all_of(joints_, [this](const std::string& joint) {
                 return position_.count(joint) > 0;
               });
      },
      60s);
  if (!are_there) return "the robot does not tell where it is: " + output();
  if (!stop_.wait_for_server(30s)) return "there is no node emergency_stop";
  // Required nodes are known a moment later.
  std::this_thread::sleep_for(1s);
  return wait_until_stands(steady_clock::now(), 30s) ? "" : "the robot does not stand";
}

msgs::FollowTrajectoryGoal StopRig::arm_goal() {
  const std::lock_guard lock(mutex_);
  msgs::FollowTrajectoryGoal goal;
  for (const std::string& joint : joints_) goal.mutable_trajectory()->add_joint_name(joint);
  for (const double share : {0.0, 1.0}) {
    msgs::JointTrajectoryPoint& point = *goal.mutable_trajectory()->add_points();
    point.set_time(4 * share);
    for (std::size_t i = 0; i < joints_.size(); ++i) {
      const double way = i == 0 ? share * (goes_ ? -robot_.way : robot_.way) : 0.0;
      point.add_position(position_.at(joints_[i]) + way);
      point.add_velocity(0);
      point.add_acceleration(0);
    }
  }
  return goal;
}

std::string StopRig::move() {
  const Time from = steady_clock::now();
  const double least = robot_.least, most = robot_.most;
  double target = 0;  // the farther end
  {
    const std::lock_guard lock(mutex_);
    target = hand_position_ > (least + most) / 2 ? least : most;
  }
  arm_goal_ = follow_.send(arm_goal());
  if (robot_.has_gripper) {
    msgs::MoveGripperGoal goal;
    goal.set_opening(target);
    goal.set_speed(0.015);
    gripper_goal_ = move_gripper_.send(goal);
  } else {
    msgs::MoveHandGoal goal;
    goal.add_joint_name(robot_.hand_joint);
    goal.add_position(target);
    goal.set_speed(robot_.speed);
    hand_goal_ = move_hand_.send(goal);
  }
  goes_ = !goes_;
  const auto moves = [&](const std::vector<Sample>& samples) {
    const std::lock_guard lock(mutex_);
    return !samples.empty() && samples.back().time > from && samples.back().speed > kMoves;
  };
  if (!wait_for([&] { return moves(arm_) && moves(hand_); }, 10s)) {
    std::string words = "arm or hand do not move";
    for (const std::string& reason : reasons()) words += "; " + reason;
    return words;
  }
  return "";
}

std::vector<std::string> StopRig::reasons() {
  return {reason_of(arm_goal_),
          robot_.has_gripper ? reason_of(gripper_goal_) : reason_of(hand_goal_)};
}

std::vector<std::string> StopRig::refusals() {
  std::vector<std::string> reasons{reason_of(follow_.send(arm_goal()))};
  if (robot_.has_gripper) {
    msgs::MoveGripperGoal goal;
    goal.set_opening(0.03);
    goal.set_speed(0.02);
    reasons.push_back(reason_of(move_gripper_.send(goal)));
  } else {
    msgs::MoveHandGoal goal;
    goal.add_joint_name(robot_.hand_joint);
    goal.add_position(0.03);
    goal.set_speed(robot_.speed);
    reasons.push_back(reason_of(move_hand_.send(goal)));
  }
  return reasons;
}

msgs::Acknowledge StopRig::stop(const std::string& reason) {
  msgs::EmergencyStopRequest request;
  request.set_source("the test");
  request.set_reason(reason);
  const auto outcome = stop_.call(request, 10s);
  return outcome ? *outcome : msgs::Acknowledge();
}

msgs::Acknowledge StopRig::reset() {
  const auto outcome = reset_.call({}, 10s);
  return outcome ? *outcome : msgs::Acknowledge();
}

bool StopRig::is_stopped() const {
  const std::lock_guard lock(mutex_);
  return state_.stopped();
}

std::string StopRig::reason() const {
  const std::lock_guard lock(mutex_);
  return state_.reason();
}

std::optional<StopRig::Time> StopRig::told_stopped() const {
  const std::lock_guard lock(mutex_);
  return told_;
}

bool StopRig::kill(const std::string& node) {
  if (node == "emergency_stop") {
    emergency_.reset();  // which kills it
    return true;
  }
  const std::vector<pid_t> processes = descendants(launched_.pid(), node);
  for (const pid_t process : processes) ::kill(process, SIGKILL);
  return !processes.empty();
}

StopRig::Track StopRig::track(const std::vector<Sample>& samples, const std::vector<Time>& commands,
                              Time from) const {
  Track track;
  bool has_begun = false;
  for (const Sample& sample : samples) {
    if (sample.time < from) {
      track.speed = sample.speed;
      continue;
    }
    has_begun = true;
    if (sample.speed >= 0.98 * track.speed) track.slower = sample.time;
    if (sample.speed > kStands) {
      track.stands.reset();
    } else if (!track.stands) {
      track.stands = sample.time;
    }
  }
  track.stood = has_begun && track.stands.has_value();
  for (const Time command : commands) {
    if (command >= from) track.command = command;
  }
  return track;
}

StopRig::Track StopRig::arm_since(Time from) const {
  const std::lock_guard lock(mutex_);
  return track(arm_, arm_commands_, from);
}

StopRig::Track StopRig::hand_since(Time from) const {
  const std::lock_guard lock(mutex_);
  return track(hand_, hand_commands_, from);
}

// For as long that what pauses only is not taken for standing.
bool StopRig::wait_until_stands(Time from, std::chrono::seconds patience) const {
  return wait_for(
      [&] {
        const Track arm = arm_since(from), hand = hand_since(from);
        const Time before = steady_clock::now() - 500ms;
        return arm.stood && hand.stood && *arm.stands < before && *hand.stands < before;
      },
      patience);
}

std::vector<std::string> StopRig::arguments_of(const StoppedRobot& robot) const {
  std::vector<std::string> words{"launch", robot.launch_file};
  const int port =
      ntohs(drivers::kuka_rsi::UdpSocket("127.0.0.1", 0).here().address.sin_port);  // free again
  for (std::string argument : robot.arguments) {
    replace(argument, "PORT", std::to_string(port));
    replace(argument, "LINES", (scratch_.path() / "line").string());
    words.push_back(argument);
  }
  for (const std::string& word : {std::string("--registry"), registry_, std::string("--log-dir"),
                                  (scratch_.path() / "log").string()}) {
    words.push_back(word);
  }
  return words;
}

graph::NodeOptions StopRig::options() const {
  graph::NodeOptions options;
  options.name = "test";
  options.registry = registry_;
  options.registry_timeout = 30s;
  return options;
}

}  // namespace prehend::testing

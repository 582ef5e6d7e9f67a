#pragma once

#include <signal.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "drivers/wire/stream/tcp_server.h"
#include "msgs/actions.pb.h"
#include "msgs/graph.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/graph/node.h"
#include "tests/drivers/contract/jaws_world.h"
#include "tests/drivers/eventually.h"
#include "tests/system/launched.h"

namespace prehend::drivers {

/// A launch file that brings a robot up, and its arguments.
struct RobotKind {
  enum class World {
    kSimulation,
    kJaws,  // JawsWorld: a gripper alone
    kReal,
  };
  std::string name;
  std::string launch_file;
  std::vector<std::string> arguments;  // "LINES" stands for a folder of the test's own
  World world = World::kSimulation;

  bool has_senses() const { return world != World::kJaws; }
  /// Its motor can be given a voltage: only the simulation's.
  bool takes_voltage() const { return name == "Simulation"; }
  graph::ClockMode clock() const {
    return world == World::kSimulation ? graph::ClockMode::kSimulated : graph::ClockMode::kWall;
  }
};

/// Simulation and emulated devices; on CAN sockets the emulated gripper alone, as the other devices
/// have no part in that; real ones when PREHEND_HARDWARE holds the arguments of
/// launch/bringup.yaml, e.g. "gripper:=pg70 tactile:=dsa wrench:=ft300 can:=can0". Nothing may be
/// between its jaws then.
inline std::vector<RobotKind> robot_kinds() {
  std::vector<RobotKind> kinds{{"Simulation", "launch/bringup.yaml", {}},
                               {"EmulatedDevices",
                                "launch/emulated_robot.yaml",
                                {"gripper:=pg70", "tactile:=dsa", "wrench:=ft300",
                                 "lines:=LINES/line", "can:=slcan:LINES/can"}}};
  if (std::getenv("PREHEND_VCAN")) {  // socket_can/run.sh
    kinds.push_back({"EmulatedDevicesOnSocketCan",
                     "tests/drivers/contract/gripper_on_can.yaml",
                     {},
                     RobotKind::World::kJaws});
  }
  if (const char* hardware = std::getenv("PREHEND_HARDWARE")) {
    RobotKind real{"Hardware", "launch/bringup.yaml", {}, RobotKind::World::kReal};
    std::istringstream words(hardware);
    for (std::string word; words >> word;) real.arguments.push_back(word);
    kinds.push_back(real);
  }
  return kinds;
}

/// The last messages of a topic. Thread-safe.
template <class Message>
class TopicLog {
 public:
  TopicLog(graph::Node& node, const std::string& topic)
      : subscription_(node.subscribe<Message>(topic, graph::QoS::queue(200),
                                              [this](const graph::Received<Message>& message) {
                                                const std::lock_guard lock(mutex_);
                                                messages_.push_back(*message);
                                              })) {}
  std::vector<Message> all() const {
    const std::lock_guard lock(mutex_);
    return messages_;
  }
  std::size_t size() const {
    const std::lock_guard lock(mutex_);
    return messages_.size();
  }
  Message last() const {
    const std::lock_guard lock(mutex_);
    return messages_.empty() ? Message{} : messages_.back();
  }
  void clear() {
    const std::lock_guard lock(mutex_);
    messages_.clear();
  }

 private:
  mutable std::mutex mutex_;
  std::vector<Message> messages_;
  graph::Subscription subscription_;
};

/// The running robot, and a node that uses it.
class RobotUnderTest {
 public:
  using MoveClient = graph::ActionClient<msgs::MoveGripperGoal, msgs::MoveGripperFeedback,
                                         msgs::MoveGripperResult>;

  explicit RobotUnderTest(const RobotKind& kind)
      : registry_(free_endpoint()),
        launched_("prehend", arguments_of(kind), scratch_.path() / "output.txt"),
        node_(options_of(kind)),
        commands(node_.advertise<msgs::GripperCommand>("/gripper/command", graph::QoS::queue(10))),
        move(node_.action_client<msgs::MoveGripperGoal, msgs::MoveGripperFeedback,
                                 msgs::MoveGripperResult>("/gripper/move")),
        states(node_, "/gripper/state"),
        left(node_, "/tactile/left"),
        right(node_, "/tactile/right"),
        wrenches(node_, "/wrench"),
        kind_(kind) {
    if (kind.world == RobotKind::World::kJaws) jaws_ = std::make_unique<JawsWorld>(node_);
    node_.spin_in_background();
  }
  ~RobotUnderTest() {
    launched_.send_signal(SIGINT);
    launched_.wait(std::chrono::seconds(20));
  }

  graph::Node& node() { return node_; }
  std::string output() const { return launched_.output(); }
  pid_t pid() const { return launched_.pid(); }
  void command(msgs::GripperCommand::Mode mode, double value, double current_limit = 0,
               std::int64_t stamp = 0) {
    msgs::GripperCommand message;
    message.mutable_header()->set_stamp(stamp != 0 ? stamp : node_.clock().now());
    message.set_mode(mode);
    message.set_value(value);
    message.set_current_limit(current_limit);
    commands.publish(message);
  }
  /// Sees how fast this machine runs the simulation beside whatever else it does, and slows the
  /// robot's clock to half of that where it could not keep up with the wires: a clock that is slow
  /// is no fault, one that is held up now and then looks like jaws that stand. "" or what failed.
  std::string set_pace() {
    if (kind_.world != RobotKind::World::kSimulation) return {};
    constexpr auto kTrial = std::chrono::milliseconds(500);
    if (std::string problem = set_speed(0); !problem.empty()) return problem;
    const auto began = std::chrono::steady_clock::now();
    const std::int64_t from = node_.clock().now();
    std::this_thread::sleep_for(kTrial);
    const std::chrono::duration<double, std::nano> passed =
        std::chrono::steady_clock::now() - began;
    const double most = static_cast<double>(node_.clock().now() - from) / passed.count();
    speed_ = std::clamp(0.5 * most, 0.05, 1.0);
    return set_speed(speed_);
  }
  /// Of the robot's clock, simulated seconds per second.
  double speed() const { return speed_; }
  /// Lets the world's time stand still for a while of real time.
  void hold_world_up(std::chrono::milliseconds time) {
    if (jaws_) {
      jaws_->hold_up(true);
      std::this_thread::sleep_for(time);
      return jaws_->hold_up(false);
    }
    for (const pid_t world : testing::descendants(pid(), "simulation")) {
      ::kill(world, SIGSTOP);
      std::this_thread::sleep_for(time);
      ::kill(world, SIGCONT);
    }
  }
  JawsWorld* jaws() { return jaws_.get(); }
  msgs::Acknowledge call(const std::string& service) {
    const auto client = node_.client<msgs::Empty, msgs::Acknowledge>(service);
    const auto outcome = client.call({}, std::chrono::seconds(10));
    return outcome ? *outcome : msgs::Acknowledge{};
  }

 private:
  std::string set_speed(double speed) {
    msgs::graph::ClockControlRequest request;
    request.set_command(msgs::graph::ClockControlRequest::SET_SPEED);
    request.set_speed(speed);
    const auto outcome =
        node_
            .client<msgs::graph::ClockControlRequest, msgs::graph::ClockControlResponse>(
                "/clock/control")
            .call(request, std::chrono::seconds(10));
    return outcome ? outcome->error() : outcome.error();
  }
  static std::string free_endpoint() {
    const TcpServer server;  // its port is free again when it is gone
    return server.name();
  }
  std::vector<std::string> arguments_of(const RobotKind& kind) const {
    std::vector<std::string> arguments{"launch", kind.launch_file};
    for (std::string argument : kind.arguments) {
      const auto at = argument.find("LINES");
      if (at != std::string::npos) argument.replace(at, 5, scratch_.path().string());
      arguments.push_back(argument);
    }
    for (const std::string& word : {std::string("--registry"), registry_, std::string("--log-dir"),
                                    (scratch_.path() / "log").string()}) {
      arguments.push_back(word);
    }
    return arguments;
  }
  graph::NodeOptions options_of(const RobotKind& kind) const {
    graph::NodeOptions options;
    options.name = "contract";
    options.registry = registry_;
    options.clock = kind.clock();
    options.registry_timeout = std::chrono::seconds(30);
    return options;
  }

  testing::ScratchFolder scratch_;
  std::string registry_;
  testing::Launched launched_;
  graph::Node node_;

 public:
  graph::Publisher<msgs::GripperCommand> commands;
  MoveClient move;
  TopicLog<msgs::GripperState> states;
  TopicLog<msgs::TactileFrame> left, right;
  TopicLog<msgs::Wrench> wrenches;

 private:
  const RobotKind kind_;
  double speed_ = 1;
  std::unique_ptr<JawsWorld> jaws_;
};

}  // namespace prehend::drivers

// The drivers of a whole robot, a KR5 with SDH-2, pads, force sensor and depth camera, as
// launch/bringup.yaml starts them, beside emulated devices that another graph serves
// (launch/emulated_devices.yaml): how much of a processor each driver takes, while the robot stands
// and while arm and hand move.

#include <arpa/inet.h>
#include <benchmark/benchmark.h>
#include <signal.h>
#include <unistd.h>

#include <fstream>
#include <map>
#include <mutex>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "drivers/kuka_rsi/transport/udp_socket.h"
#include "drivers/wire/stream/tcp_server.h"
#include "msgs/actions.pb.h"
#include "msgs/joints.pb.h"
#include "prehend/graph/node.h"
#include "tests/system/launched.h"

namespace {

using namespace prehend;
using namespace std::chrono_literals;
using std::chrono::steady_clock;
using testing::Launched;

constexpr const char* kDrivers[] = {"kuka_rsi", "sdh",   "sdh_guardian",
                                    "dsa",      "ft300", "depth_camera"};
constexpr double kWay = 0.5, kTime = 2;  // rad, s, to and fro

double seconds_since(steady_clock::time_point begin) {
  return std::chrono::duration<double>(steady_clock::now() - begin).count();
}

/// [s] Processor time of a process so far, user and system.
double processor_time(pid_t process) {
  std::ifstream file("/proc/" + std::to_string(process) + "/stat");
  std::string line, skipped;
  std::getline(file, line);
  std::istringstream fields(line.substr(line.rfind(')') + 2));
  for (int i = 0; i < 11; ++i) fields >> skipped;
  double user = 0, system = 0;
  fields >> user >> system;
  return (user + system) / static_cast<double>(::sysconf(_SC_CLK_TCK));
}

std::string free_port() {
  return std::to_string(
      ntohs(drivers::kuka_rsi::UdpSocket("127.0.0.1", 0).here().address.sin_port));
}

/// Emulated devices and, in a graph of their own, the drivers.
class WholeRobot {
 public:
  WholeRobot()
      : rsi_port_(free_port()),
        camera_port_(free_port()),
        lines_((scratch_.path() / "line").string()),
        registry_(drivers::TcpServer().name()),
        devices_(
            "prehend",
            {"launch", "launch/emulated_devices.yaml", "platform:=kr5_sdh", "arm:=rsi", "hand:=sdh",
             "tactile:=dsa", "wrench:=ft300", "camera:=openni", "lines:=" + lines_,
             "rsi_port:=" + rsi_port_, "camera_port:=" + camera_port_, "--registry",
             drivers::TcpServer().name(), "--log-dir", (scratch_.path() / "devices").string()},
            scratch_.path() / "devices.txt"),
        drivers_("prehend",
                 {"launch", "launch/bringup.yaml", "platform:=kr5_sdh", "arm:=rsi",
                  "rsi_host:=127.0.0.1", "rsi_port:=" + rsi_port_, "hand:=sdh",
                  "sdh:=" + lines_ + "_sdh", "tactile:=dsa", "dsa:=" + lines_ + "_dsa",
                  "wrench:=ft300", "ft300:=" + lines_ + "_ft300", "camera:=openni",
                  "depth_device:=prehend://127.0.0.1:" + camera_port_, "--registry", registry_,
                  "--log-dir", (scratch_.path() / "drivers").string()},
                 scratch_.path() / "drivers.txt"),
        node_(options()),
        follow_(node_.action_client<msgs::FollowTrajectoryGoal, msgs::FollowTrajectoryFeedback,
                                    msgs::FollowTrajectoryResult>("/arm/follow")),
        move_hand_(
            node_.action_client<msgs::MoveHandGoal, msgs::MoveHandFeedback, msgs::MoveHandResult>(
                "/hand/move")),
        states_(node_.subscribe<msgs::JointState>(
            "/joint_states", graph::QoS::latest(),
            [this](const graph::Received<msgs::JointState>& state) {
              const std::lock_guard lock(mutex_);
              for (int i = 0; i < state->name_size(); ++i) {
                position_[state->name(i)] = state->position(i);
              }
            })) {
    node_.spin_in_background();
  }
  ~WholeRobot() {
    node_.shutdown();
    for (Launched* launched : {&drivers_, &devices_}) {
      launched->send_signal(SIGINT);
      launched->wait(20s);
    }
  }

  /// "" or what does not come.
  std::string wait_until_ready() const {
    const auto begin = steady_clock::now();
    while (position("hand_finger_1_proximal") == std::nullopt ||
           position(arm_joint(0)) == std::nullopt) {
      if (seconds_since(begin) > 60) return "the robot does not tell where it is";
      std::this_thread::sleep_for(50ms);
    }
    std::this_thread::sleep_for(3s);  // what a start costs is over
    return {};
  }
  /// [s] by driver. @throws std::runtime_error when one is not there.
  std::map<std::string, double> used() const {
    std::map<std::string, double> all;
    for (const std::string driver : kDrivers) {
      const std::vector<pid_t> processes = testing::descendants(drivers_.pid(), driver);
      if (processes.empty()) throw std::runtime_error("there is no process " + driver);
      for (const pid_t process : processes) all[driver] += processor_time(process);
    }
    return all;
  }
  /// Arm and hand begin to go to one side or the other, and are there `kTime` later.
  void begin_move(bool there) {
    msgs::FollowTrajectoryGoal goal;
    for (const double share : {0.0, 1.0}) {
      msgs::JointTrajectoryPoint& point = *goal.mutable_trajectory()->add_points();
      point.set_time(kTime * share);
      for (int i = 0; i < 6; ++i) {
        const double way = i == 0 ? share * (there ? kWay : -kWay) : 0.0;
        point.add_position(position(arm_joint(i)).value_or(0) + way);
        point.add_velocity(0);
        point.add_acceleration(0);
        if (share == 0) goal.mutable_trajectory()->add_joint_name(arm_joint(i));
      }
    }
    arm_ = follow_.send(goal);
    msgs::MoveHandGoal fingers;
    fingers.add_joint_name("finger_1_proximal");
    fingers.add_position(there ? 0.5 : 0.0);
    fingers.set_speed(0.2);
    hand_ = move_hand_.send(fingers);
  }
  /// "" or why the arm did not get there.
  std::string end_move() {
    const auto arm = arm_.wait(20s);
    hand_.wait(20s);
    return arm ? arm->reason() : arm.error();
  }

 private:
  static std::string arm_joint(int i) { return "arm_axis_" + std::to_string(i + 1); }
  std::optional<double> position(const std::string& joint) const {
    const std::lock_guard lock(mutex_);
    const auto found = position_.find(joint);
    return found == position_.end() ? std::nullopt : std::optional(found->second);
  }
  graph::NodeOptions options() const {
    graph::NodeOptions options;
    options.name = "bench";
    options.registry = registry_;
    options.registry_timeout = 30s;
    return options;
  }

  testing::ScratchFolder scratch_;
  const std::string rsi_port_, camera_port_, lines_, registry_;
  Launched devices_, drivers_;
  mutable std::mutex mutex_;  // guards what follows
  std::map<std::string, double> position_;
  graph::Node node_;
  graph::ActionClient<msgs::FollowTrajectoryGoal, msgs::FollowTrajectoryFeedback,
                      msgs::FollowTrajectoryResult>
      follow_;
  graph::ActionClient<msgs::MoveHandGoal, msgs::MoveHandFeedback, msgs::MoveHandResult> move_hand_;
  graph::GoalHandle<msgs::FollowTrajectoryResult> arm_;
  graph::GoalHandle<msgs::MoveHandResult> hand_;
  graph::Subscription states_;
};

void drivers_of_kr5_sdh(benchmark::State& state) {
  const bool moves = state.range(0) != 0;
  const auto seconds = static_cast<double>(state.range(1));
  WholeRobot robot;
  if (const std::string problem = robot.wait_until_ready(); !problem.empty()) {
    state.SkipWithError(problem.c_str());
    return;
  }
  for (auto _ : state) {
    const std::map<std::string, double> before = robot.used();
    const auto begin = steady_clock::now();
    for (bool there = true; moves && seconds_since(begin) < seconds; there = !there) {
      robot.begin_move(there);
      const std::string problem = robot.end_move();
      if (problem.empty()) continue;
      state.SkipWithError(problem.c_str());
      return;
    }
    if (!moves) std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
    const double time = seconds_since(begin);
    double sum = 0;
    for (const auto& [driver, now] : robot.used()) {
      const double percent = 100 * (now - before.at(driver)) / time;
      state.counters[driver + "_percent"] = percent;
      sum += percent;
    }
    state.counters["percent_of_a_core"] = sum;
    state.SetIterationTime(time);
  }
}
BENCHMARK(drivers_of_kr5_sdh)
    ->ArgNames({"moves", "seconds"})
    ->Args({0, 30})
    ->Args({1, 30})
    ->Iterations(1)
    ->UseManualTime()
    ->Unit(benchmark::kSecond);

}  // namespace

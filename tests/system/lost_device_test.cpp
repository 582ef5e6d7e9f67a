// A grasp through real drivers and emulated devices, one of which falls silent on the way: all
// motion stops, and that is the reason. Once the object was lifted, carried and put down by a
// gripper that did not answer any more, and a silent force sensor was not noticed at all.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/wire/stream/tcp_server.h"
#include "msgs/convert/geometry.h"
#include "msgs/convert/objects.h"
#include "msgs/grasp.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/graph/node.h"
#include "prehend/simulation/scene.h"
#include "prehend/surface/model.h"
#include "tests/system/launched.h"

namespace prehend::testing {
namespace {

using std::chrono::seconds;
using ::testing::HasSubstr;

struct Loss {
  std::string node, parameter;  // that silences it
  std::string moment;           // in the cycle's words
  std::string reason;
  friend void PrintTo(const Loss& loss, std::ostream* out) { *out << loss.node; }
};

class LostDevice : public ::testing::TestWithParam<Loss> {
 protected:
  LostDevice()
      : registry_(drivers::TcpServer().name()),  // its port is free again
        robot_("prehend",
               {"launch", "launch/emulated_robot.yaml", "gripper:=pg70", "tactile:=dsa",
                "wrench:=ft300", "lines:=" + line(), "can:=slcan:" + line() + "_can", "--registry",
                registry_, "--log-dir", (scratch_.path() / "log").string()},
               scratch_.path() / "robot.txt"),
        node_(options()),
        models_(node_.advertise<msgs::ObjectModel>("/models", graph::QoS::latched(4))),
        joints_subscription_(node_.subscribe<msgs::JointState>(
            "/joint_states", graph::QoS::latest(),
            [this](const graph::Received<msgs::JointState>& state) {
              const std::lock_guard lock(mutex_);
              joints_ = *state;
            })),
        results_(node_.subscribe<msgs::CycleResult>(
            "/cycle/result", graph::QoS::latched(1),
            [this](const graph::Received<msgs::CycleResult>& result) {
              const std::lock_guard lock(mutex_);
              result_ = *result;
            })) {
    node_.spin_in_background();
  }
  ~LostDevice() override {
    robot_.send_signal(SIGINT);
    robot_.wait(seconds(20));
  }

  // Of the demo's carton, as if it had been seen.
  void publish_model() {
    const simulation::Scene scene = simulation::read_scene("config/scenes/demo.yaml");
    const simulation::SceneObject& carton = scene.objects.front();
    const auto object = surface::model_of_mesh(geometry::transformed(
        simulation::object_mesh(carton),
        geometry::make_transform(
            Eigen::Quaterniond(Eigen::AngleAxisd(carton.yaw, Eigen::Vector3d::UnitZ())),
            {carton.x, carton.y, 0})));
    auto model = convert::to_message(object);
    model.mutable_header()->set_stamp(1);
    model.set_object_count(1);
    model.set_valid(true);
    *model.mutable_table() = convert::to_message(geometry::Plane{});
    models_.publish(model);
  }

  bool eventually(const std::function<bool()>& condition, seconds timeout) {
    const auto end = std::chrono::steady_clock::now() + timeout;
    while (std::chrono::steady_clock::now() < end) {
      {
        const std::lock_guard lock(mutex_);
        if (condition()) return true;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }
  // Where the stage is: x, y, z [m] and yaw [rad].
  std::vector<double> stands_at() {
    const std::lock_guard lock(mutex_);
    return {joints_.position().begin(), joints_.position().begin() + 4};
  }
  double now() {  // s, simulated, as told last
    const std::lock_guard lock(mutex_);
    return static_cast<double>(joints_.header().stamp()) * 1e-9;
  }
  std::string line() const { return (scratch_.path() / "line").string(); }

 private:
  graph::NodeOptions options() const {
    graph::NodeOptions options;
    options.name = "test";
    options.registry = registry_;
    options.clock = graph::ClockMode::kSimulated;
    options.registry_timeout = seconds(30);
    return options;
  }

 protected:
  ScratchFolder scratch_;
  std::string registry_;
  Launched robot_;
  std::mutex mutex_;
  msgs::JointState joints_;
  std::optional<msgs::CycleResult> result_;
  graph::Node node_;
  graph::Publisher<msgs::ObjectModel> models_;
  graph::Subscription joints_subscription_, results_;
};

TEST_P(LostDevice, StopsAllMotionAndIsTheReason) {
  const Loss& loss = GetParam();
  ASSERT_TRUE(eventually([&] { return joints_.header().stamp() > 0; }, seconds(60)))
      << robot_.output();
  publish_model();
  const Launched planning(
      "grasp_planning", {"--registry", registry_, "--clock", "simulated", "--param", "motions:=1"},
      scratch_.path() / "planning.txt");
  Launched cycle("grasp_cycle",
                 {"--registry", registry_, "--clock", "simulated", "--param", "look_timeout:=0"},
                 scratch_.path() / "cycle.txt");
  ASSERT_TRUE(cycle.wait_for_output(loss.moment, seconds(90))) << cycle.output();
  const Outcome set = run_program(
      "prehend", {"param", "set", loss.node, loss.parameter, "true", "--registry", registry_},
      seconds(20));
  ASSERT_EQ(set.exit_code, 0) << set.output;
  ASSERT_TRUE(eventually([&] { return result_.has_value(); }, seconds(60))) << cycle.output();
  EXPECT_EQ(result_->outcome(), msgs::CycleResult::FAILED);
  EXPECT_THAT(result_->reason(), HasSubstr(loss.reason)) << cycle.output();
  EXPECT_EQ(result_->attempts(), 1u);
  // The stage brakes and stays where it is.
  const double ended = now();
  ASSERT_TRUE(eventually(
      [&] {
        return std::all_of(joints_.velocity().begin(), joints_.velocity().begin() + 4,
                           [](double speed) { return std::abs(speed) < 1e-9; });
      },
      seconds(20)));
  EXPECT_LT(now() - ended, 1.0) << "s of simulated time until it stood";
  const std::vector<double> stood = stands_at();
  const double since = now();
  ASSERT_TRUE(
      eventually([&] { return static_cast<double>(joints_.header().stamp()) * 1e-9 > since + 1; },
                 seconds(60)));
  const std::vector<double> stands = stands_at();
  for (std::size_t i = 0; i < stood.size(); ++i) EXPECT_NEAR(stands[i], stood[i], 1e-4) << i;
}

INSTANTIATE_TEST_SUITE_P(
    Devices, LostDevice,
    ::testing::Values(
        Loss{"pg70_emulator", "mute", "closing until both pads touch", "lost the gripper's state"},
        Loss{"ft300_emulator", "silent", "approach: arm: approach", "lost the wrist's force"},
        Loss{"dsa_emulator", "silent", "lift: arm: lift", "pad's frames"}),
    [](const auto& test) { return test.param.node; });

}  // namespace
}  // namespace prehend::testing

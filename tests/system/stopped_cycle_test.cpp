// The emergency stop of a grasp cycle: its task ends where everything stands, its reason is the
// stop's, and it does not try again.

#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "msgs/convert/geometry.h"
#include "msgs/convert/objects.h"
#include "msgs/grasp.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/graph/node.h"
#include "prehend/graph/registry.h"
#include "prehend/simulation/scene.h"
#include "prehend/surface/model.h"
#include "tests/drivers/eventually.h"
#include "tests/system/launched.h"

namespace prehend::testing {
namespace {

using namespace std::chrono_literals;
using drivers::eventually;
using ::testing::HasSubstr;

class StoppedCycle : public ::testing::Test {
 protected:
  StoppedCycle() : node_(options()) {
    models_ = node_.advertise<msgs::ObjectModel>("/models", graph::QoS::latched(4));
    subscriptions_.push_back(
        node_.subscribe<msgs::JointState>("/joint_states", graph::QoS::latest(),
                                          [this](const graph::Received<msgs::JointState>& state) {
                                            const std::lock_guard lock(mutex_);
                                            joints_ = *state;
                                          }));
    subscriptions_.push_back(node_.subscribe<msgs::CycleResult>(
        "/cycle/result", graph::QoS::latched(4),
        [this](const graph::Received<msgs::CycleResult>& result) {
          const std::lock_guard lock(mutex_);
          results_.push_back(*result);
        }));
    node_.spin_in_background();
  }
  graph::NodeOptions options() const {
    graph::NodeOptions options;
    options.name = "test";
    options.registry = registry_.endpoint();
    return options;
  }
  Launched& start(const std::string& program, const std::vector<std::string>& parameters) {
    std::vector<std::string> arguments{"--registry", registry_.endpoint()};
    for (const std::string& parameter : parameters) {
      arguments.insert(arguments.end(), {"--param", parameter});
    }
    if (program != "simulation") arguments.insert(arguments.end(), {"--clock", "simulated"});
    return *programs_.emplace_back(
        std::make_unique<Launched>(program, arguments, scratch_.path() / (program + ".txt")));
  }
  // Of the demo's carton, as if it had been seen.
  void publish_model() {
    const simulation::Scene scene = simulation::read_scene("config/scenes/demo.yaml");
    const simulation::SceneObject& carton = scene.objects.front();
    auto model = convert::to_message(surface::model_of_mesh(geometry::transformed(
        simulation::object_mesh(carton),
        geometry::make_transform(
            Eigen::Quaterniond(Eigen::AngleAxisd(carton.yaw, Eigen::Vector3d::UnitZ())),
            {carton.x, carton.y, 0}))));
    model.mutable_header()->set_stamp(1);
    model.set_object_count(1);
    model.set_valid(true);
    *model.mutable_table() = convert::to_message(geometry::Plane{});
    models_.publish(model);
  }
  std::size_t results() const {
    const std::lock_guard lock(mutex_);
    return results_.size();
  }
  bool stands() const {
    const std::lock_guard lock(mutex_);
    for (const double speed : joints_.velocity()) {
      if (std::abs(speed) > 1e-9) return false;
    }
    return joints_.velocity_size() > 0;
  }
  std::vector<double> position() const {
    const std::lock_guard lock(mutex_);
    return {joints_.position().begin(), joints_.position().end()};
  }
  Outcome prehend(std::vector<std::string> words) const {
    words.insert(words.end(), {"--registry", registry_.endpoint()});
    return run_program("prehend", words, 20s);
  }

  ScratchFolder scratch_;
  graph::Registry registry_{{.endpoint = "tcp://127.0.0.1:*"}};
  mutable std::mutex mutex_;
  msgs::JointState joints_;
  std::vector<msgs::CycleResult> results_;
  graph::Node node_;
  graph::Publisher<msgs::ObjectModel> models_;
  std::vector<graph::Subscription> subscriptions_;
  std::vector<std::unique_ptr<Launched>> programs_;
};

TEST_F(StoppedCycle, EndsItsTaskByTheReasonAndDoesNotTryAgain) {
  start("emergency_stop", {"required:=[simulation]"});
  start("simulation", {"scene:=config/scenes/demo.yaml", "camera:=false"});
  publish_model();
  start("grasp_planning", {"motions:=1"});
  Launched& cycle = start("grasp_cycle", {});
  ASSERT_TRUE(cycle.wait_for_output("approach: arm: approach", 90s)) << cycle.output();
  const Outcome stopped = prehend({"stop", "--reason", "a hand in the cell"});
  ASSERT_EQ(stopped.exit_code, 0) << stopped.output;
  ASSERT_TRUE(eventually([&] { return results() > 0; }, 30s)) << cycle.output();
  {
    const std::lock_guard lock(mutex_);
    EXPECT_EQ(results_.front().outcome(), msgs::CycleResult::FAILED);
    EXPECT_THAT(results_.front().reason(),
                HasSubstr("emergency stop by prehend stop: a hand in the cell"));
    EXPECT_EQ(results_.front().attempts(), 1u);
  }
  ASSERT_TRUE(eventually([&] { return stands(); }, 20s));
  const std::vector<double> stood = position();
  const Outcome refused = prehend({"service", "call", "/cycle/start"});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.output, HasSubstr("emergency stop by prehend stop"));
  std::this_thread::sleep_for(1s);
  EXPECT_EQ(results(), 1u);
  ASSERT_EQ(position().size(), stood.size());
  for (std::size_t i = 0; i < stood.size(); ++i) EXPECT_NEAR(position()[i], stood[i], 1e-4) << i;
  // A reset moves nothing; the cycle is told to go on.
  EXPECT_EQ(prehend({"stop", "--reset"}).exit_code, 0);
  std::this_thread::sleep_for(500ms);
  for (std::size_t i = 0; i < stood.size(); ++i) EXPECT_NEAR(position()[i], stood[i], 1e-4) << i;
  const Outcome again = prehend({"service", "call", "/cycle/start"});
  EXPECT_EQ(again.exit_code, 0) << again.output;
}

}  // namespace
}  // namespace prehend::testing

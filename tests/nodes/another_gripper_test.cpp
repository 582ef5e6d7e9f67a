// The steps of config/README.md for another gripper, word for word: planner and cycle use it. Once
// both planned for and opened the shipped one, without a word.

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
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
#include "prehend/surface/model.h"
#include "tests/system/launched.h"

namespace prehend::testing {
namespace {

namespace fs = std::filesystem;
using std::chrono::seconds;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kShippedOpening = 0.069;  // m

class AnotherGripper : public ::testing::Test {
 protected:
  AnotherGripper() : node_(options()) {
    models_ = node_.advertise<msgs::ObjectModel>("/models", graph::QoS::latched(32));
    keep("/plans", plan_);
    keep("/cycle/result", result_);
    subscriptions_.push_back(node_.subscribe<msgs::GripperState>(
        "/gripper/state", graph::QoS::queue(100),
        [this](const graph::Received<msgs::GripperState>& state) {
          const std::lock_guard lock(mutex_);
          widest_ = std::max(widest_, state->opening());
        }));
    node_.spin_in_background();
    follow_readme();
  }

  template <class Message>
  void keep(const std::string& topic, std::optional<Message>& place) {
    subscriptions_.push_back(node_.subscribe<Message>(
        topic, graph::QoS::latched(4), [this, &place](const graph::Received<Message>& message) {
          const std::lock_guard lock(mutex_);
          place = *message;
        }));
  }
  template <class Message>
  std::optional<Message> wait_for(const std::optional<Message>& place) {
    const auto end = std::chrono::steady_clock::now() + seconds(60);
    while (std::chrono::steady_clock::now() < end) {
      {
        const std::lock_guard lock(mutex_);
        if (place) return place;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return std::nullopt;
  }

  static std::string text_of(const fs::path& file) {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  static std::string replaced(std::string text, const std::string& old, const std::string& now) {
    const auto at = text.find(old);
    EXPECT_NE(at, std::string::npos) << "no '" << old << "' in\n" << text;
    return at == std::string::npos ? text : text.replace(at, old.size(), now);
  }

  // Copy robots/pg70_dsa.yaml, change what differs; copy a scene, name the gripper there.
  void follow_readme() {
    fs::copy("config", config_, fs::copy_options::recursive);
    std::ofstream(config_ / "robots" / "wide.yaml") << replaced(
        replaced(text_of("config/robots/pg70_dsa.yaml"), "name: pg70_dsa", "name: wide"),
        "max_opening: 0.069", "max_opening: 0.12");
    std::ofstream(config_ / "scenes" / "wide.yaml")
        << replaced(text_of("config/scenes/demo.yaml"), "gripper: ../robots/pg70_dsa.yaml",
                    "gripper: ../robots/wide.yaml");
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
  void start_simulation() {
    start("simulation", {"scene:=" + (config_ / "scenes" / "wide.yaml").string(), "camera:=false"});
  }
  // The demo's can of 96 mm, as it stands there.
  void publish_can() { publish(0.048); }
  void publish(double radius) {
    auto model = convert::to_message(surface::model_of_mesh(geometry::transformed(
        geometry::make_revolution({{radius, 0}, {radius, 0.09}}, 48),
        geometry::make_transform(Eigen::Quaterniond::Identity(), {-0.06, 0.2, 0}))));
    model.mutable_header()->set_stamp(1);
    model.set_object_count(1);
    model.set_valid(true);
    *model.mutable_table() = convert::to_message(geometry::Plane{});
    models_.publish(model);
  }
  std::string wide_file() const { return (config_ / "robots" / "wide.yaml").string(); }

 private:
  graph::NodeOptions options() {
    graph::NodeOptions options;
    options.name = "test";
    options.registry = registry_.endpoint();
    return options;
  }

 protected:
  ScratchFolder scratch_;
  const fs::path config_ = scratch_.path() / "config";
  graph::Registry registry_{{.endpoint = "tcp://127.0.0.1:*"}};
  std::mutex mutex_;
  std::optional<msgs::GraspPlan> plan_;
  std::optional<msgs::CycleResult> result_;
  double widest_ = 0;  // m
  graph::Node node_;
  graph::Publisher<msgs::ObjectModel> models_;
  std::vector<graph::Subscription> subscriptions_;
  std::vector<std::unique_ptr<Launched>> programs_;
};

TEST_F(AnotherGripper, IsPlannedForAndOpenedAsItsSceneSays) {
  start_simulation();
  start("grasp_planning", {});
  publish_can();
  const auto plan = wait_for(plan_);
  ASSERT_TRUE(plan);
  EXPECT_THAT(plan->problem(), IsEmpty());
  ASSERT_GT(plan->grasps_size(), 0);
  EXPECT_GT(plan->grasps(0).pregrasp_opening(), 0.096);
  Launched& cycle = start("grasp_cycle", {"exit_when_done:=true"});
  const auto result = wait_for(result_);
  ASSERT_TRUE(result) << cycle.output();
  EXPECT_EQ(result->outcome(), msgs::CycleResult::SUCCEEDED) << result->reason();
  const std::lock_guard lock(mutex_);
  EXPECT_GT(widest_, 0.096) << "the cycle did not open it";
  EXPECT_GT(widest_, kShippedOpening);
}

TEST_F(AnotherGripper, AnotherOneInThePlannersParameterIsAnErrorWithBothValuesAndPlaces) {
  start_simulation();
  Launched& planning = start("grasp_planning", {"gripper:=config/robots/pg70_dsa.yaml"});
  ASSERT_TRUE(planning.wait_for_output("Two grippers", seconds(30))) << planning.output();
  publish_can();
  const auto plan = wait_for(plan_);
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->grasps_size(), 0);
  EXPECT_EQ(plan->outcome(), msgs::GraspPlan::FAILED);
  EXPECT_THAT(plan->problem(),
              AllOf(HasSubstr("max_opening: 0.069 and 0.12"), HasSubstr(wide_file()),
                    HasSubstr("config/robots/pg70_dsa.yaml (parameter gripper)")));
}

TEST_F(AnotherGripper, AnotherOneInTheCyclesParameterEndsItBeforeAnythingMoves) {
  start_simulation();
  start("grasp_planning", {});
  publish_can();
  ASSERT_TRUE(wait_for(plan_));
  Launched& cycle =
      start("grasp_cycle", {"exit_when_done:=true", "gripper:=config/robots/pg70_dsa.yaml"});
  const auto result = wait_for(result_);
  ASSERT_TRUE(result) << cycle.output();
  EXPECT_EQ(result->outcome(), msgs::CycleResult::FAILED);
  EXPECT_EQ(result->attempts(), 0u);
  EXPECT_THAT(result->reason(),
              AllOf(HasSubstr("max_opening: 0.069 and 0.12"), HasSubstr(wide_file())));
  EXPECT_EQ(cycle.wait(seconds(20)), 2);
}

// The planner had planned before there was a robot to tell.
TEST_F(AnotherGripper, APlanForAnotherOneIsNotExecuted) {
  start("grasp_planning", {"gripper:=config/robots/pg70_dsa.yaml"});
  publish(0.03);
  const auto plan = wait_for(plan_);
  ASSERT_TRUE(plan);
  EXPECT_GT(plan->grasps_size(), 0) << plan->problem();
  start_simulation();
  Launched& cycle = start("grasp_cycle", {"exit_when_done:=true"});
  const auto result = wait_for(result_);
  ASSERT_TRUE(result) << cycle.output();
  EXPECT_EQ(result->outcome(), msgs::CycleResult::FAILED);
  EXPECT_EQ(result->attempts(), 0u);
  EXPECT_THAT(result->reason(),
              AllOf(HasSubstr("planned for the gripper of config/robots/pg70_dsa.yaml"),
                    HasSubstr("max_opening: 0.069 and 0.12"), HasSubstr(wide_file())));
}

// The planner waits for the robot's word and says so.
TEST_F(AnotherGripper, IsWaitedFor) {
  start("grasp_planning", {});
  publish_can();
  ASSERT_TRUE(programs_[0]->wait_for_output("no robot says which gripper it has", seconds(30)))
      << programs_[0]->output();
  EXPECT_FALSE(plan_);
  start_simulation();
  const auto plan = wait_for(plan_);
  ASSERT_TRUE(plan);
  EXPECT_THAT(plan->problem(), IsEmpty());
}

}  // namespace
}  // namespace prehend::testing

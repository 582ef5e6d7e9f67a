// The simulation node as a process of its own: its topics, services and actions.
#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "msgs/actions.pb.h"
#include "msgs/convert/geometry.h"
#include "msgs/sensors.pb.h"
#include "msgs/truth.pb.h"
#include "prehend/graph/node.h"
#include "prehend/graph/registry.h"
#include "tests/simulation/simulation_process.h"

namespace prehend {
namespace {

using namespace std::chrono_literals;
using graph::QoS;

class SimulationNode : public ::testing::Test {
 protected:
  SimulationNode()
      : output_(std::filesystem::temp_directory_path() /
                ("prehend_simulation_" + std::to_string(getpid()) + ".log")),
        registry_({.endpoint = "tcp://127.0.0.1:*"}) {}

  void SetUp() override { start({}); }

  void start(const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"--registry", registry_.endpoint(),
                                       "--param",    "speed:=0",
                                       "--param",    "scene:=config/scenes/demo.yaml"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    simulation_ = start_simulation(arguments, output_);
    graph::NodeOptions options;
    options.name = "tester";
    options.registry = registry_.endpoint();
    node_ = std::make_unique<graph::Node>(options);
    commands_ = node_->advertise<msgs::GripperCommand>("/gripper/command", QoS::queue(10));
    gripper_subscription_ = node_->subscribe<msgs::GripperState>(
        "/gripper/state", QoS::queue(100), [this](const graph::Received<msgs::GripperState>& m) {
          const std::lock_guard lock(mutex_);
          gripper_ = *m;
          ++gripper_count_;
        });
    truth_subscription_ = node_->subscribe<msgs::GroundTruth>(
        "/ground_truth", QoS::queue(100), [this](const graph::Received<msgs::GroundTruth>& m) {
          const std::lock_guard lock(mutex_);
          truth_ = *m;
        });
    node_->spin_in_background();
  }

  void TearDown() override {
    node_.reset();
    kill(simulation_, SIGTERM);
    EXPECT_EQ(exit_code(simulation_), 0);
    if (says_cost_) {
      std::ifstream output(output_);
      const std::string text{std::istreambuf_iterator<char>(output), {}};
      EXPECT_NE(text.find("ms of processor to step"), std::string::npos) << text;
    }
    std::filesystem::remove(output_);
  }

  bool wait_until(const std::function<bool()>& condition) {
    const auto end = std::chrono::steady_clock::now() + 20s;
    while (std::chrono::steady_clock::now() < end) {
      {
        const std::lock_guard lock(mutex_);
        if (condition()) return true;
      }
      std::this_thread::sleep_for(5ms);
    }
    return false;
  }

  std::string output_;
  graph::Registry registry_;
  pid_t simulation_ = -1;
  std::unique_ptr<graph::Node> node_;
  graph::Publisher<msgs::GripperCommand> commands_;
  graph::Subscription gripper_subscription_, truth_subscription_;
  bool says_cost_ = false;
  std::mutex mutex_;
  msgs::GripperState gripper_;
  msgs::GroundTruth truth_;
  int gripper_count_ = 0;
};

// Looked at when it has ended.
TEST_F(SimulationNode, SaysInTheEndWhatASimulatedSecondTook) {
  EXPECT_TRUE(wait_until([this] { return gripper_count_ > 10; }));
  says_cost_ = true;
}

TEST_F(SimulationNode, PublishesSensorsAndOnePictureOfTheScene) {
  msgs::StereoPair pair;
  const auto subscription = node_->subscribe<msgs::StereoPair>(
      "/camera/stereo", QoS::latest(), [&](const graph::Received<msgs::StereoPair>& m) {
        const std::lock_guard lock(mutex_);
        pair = *m;
      });
  EXPECT_TRUE(wait_until([&] { return gripper_count_ > 10 && truth_.bodies_size() == 3; }));
  EXPECT_TRUE(wait_until([&] { return !pair.data().empty(); }));
  const std::lock_guard lock(mutex_);
  EXPECT_EQ(pair.data().size(), 2u * pair.width() * pair.height() * 3);
  EXPECT_EQ(pair.scene_generation(), 1u);
  EXPECT_NEAR(gripper_.opening(), 0.069, 1e-3);
  EXPECT_TRUE(truth_.bodies(0).touches_table());
}

// Perception looks once at each scene: what is asked for must count as another one.
TEST_F(SimulationNode, APictureThatIsAskedForIsOfAnotherScene) {
  std::uint64_t generation = 0;
  const auto subscription = node_->subscribe<msgs::StereoPair>(
      "/camera/stereo", QoS::latest(), [&](const graph::Received<msgs::StereoPair>& m) {
        const std::lock_guard lock(mutex_);
        generation = m->scene_generation();
      });
  EXPECT_TRUE(wait_until([&] { return generation == 1; }));
  const auto answer = node_->client<msgs::RenderRequest, msgs::Acknowledge>("/simulation/render")
                          .call({}, std::chrono::seconds(10));
  ASSERT_TRUE(answer.ok()) << answer.error();
  EXPECT_TRUE(answer->success()) << answer->reason();
  EXPECT_TRUE(wait_until([&] { return generation == 2; }));
}

// The stage's joints, as any arm's.
TEST_F(SimulationNode, StageFollowsItsJointsAndStopsOnContact) {
  std::vector<double> q;
  const auto joints = node_->subscribe<msgs::JointState>(
      "/joint_states", QoS::latest(), [&](const graph::Received<msgs::JointState>& m) {
        const std::lock_guard lock(mutex_);
        q.assign(m->position().begin(), m->position().end());
      });
  ASSERT_TRUE(wait_until([&] { return q.size() == 4; }));
  const auto client =
      node_->action_client<msgs::FollowTrajectoryGoal, msgs::FollowTrajectoryFeedback,
                           msgs::FollowTrajectoryResult>("/arm/follow");
  const auto goal_to = [](const std::vector<double>& from, const std::vector<double>& to,
                          double seconds) {
    msgs::FollowTrajectoryGoal goal;
    for (const char* name : {"arm_x", "arm_y", "arm_z", "arm_yaw"}) {
      goal.mutable_trajectory()->add_joint_name(name);
    }
    for (const auto& [time, at] : {std::pair(0.0, from), std::pair(seconds, to)}) {
      auto& point = *goal.mutable_trajectory()->add_points();
      point.set_time(time);
      for (const double value : at) point.add_position(value), point.add_velocity(0);
    }
    return goal;
  };
  const std::vector<double> start{-0.35, 0, 0.45, 0}, above{0.25, 0, 0.2, 0.5};
  auto outcome = client.send(goal_to(start, above, 3)).wait(20s);
  ASSERT_TRUE(outcome.ok()) << outcome.error();
  EXPECT_TRUE(outcome->reached()) << outcome->reason();
  EXPECT_TRUE(wait_until([&] {
    double off = 0;
    for (std::size_t i = 0; i < 4; ++i) off = std::max(off, std::abs(q[i] - above[i]));
    return off < 1e-6;
  }));

  std::vector<double> below = above;
  below[2] = 0.021;  // tips 5 mm below the table
  msgs::FollowTrajectoryGoal down = goal_to(above, below, 3);
  down.set_stop_on_contact(true);
  down.set_contact_force(5);
  outcome = client.send(down).wait(20s);
  ASSERT_TRUE(outcome.ok()) << outcome.error();
  EXPECT_TRUE(outcome->contact());
  EXPECT_FALSE(outcome->reached());
  EXPECT_NEAR(outcome->position(2), 0.0258, 0.0016);

  outcome = client.send(goal_to(start, above, 3)).wait(20s);
  ASSERT_TRUE(outcome.ok()) << outcome.error();
  EXPECT_FALSE(outcome->reached());
  EXPECT_NE(outcome->reason().find("starts"), std::string::npos) << outcome->reason();
}

TEST_F(SimulationNode, GripperMovesByAction) {
  const auto client = node_->action_client<msgs::MoveGripperGoal, msgs::MoveGripperFeedback,
                                           msgs::MoveGripperResult>("/gripper/move");
  msgs::MoveGripperGoal goal;
  goal.set_opening(0.03);
  goal.set_speed(0.08);
  auto outcome = client.send(goal).wait(20s);
  ASSERT_TRUE(outcome.ok()) << outcome.error();
  EXPECT_TRUE(outcome->reached()) << outcome->reason();
  EXPECT_NEAR(outcome->opening(), 0.03, 5e-4);
  goal.set_opening(0.2);
  outcome = client.send(goal).wait(20s);
  ASSERT_TRUE(outcome.ok()) << outcome.error();
  EXPECT_FALSE(outcome->reached());
  EXPECT_FALSE(outcome->reason().empty());
}

TEST_F(SimulationNode, WatchdogStopsAForgottenCommand) {
  ASSERT_TRUE(wait_until([&] { return gripper_count_ > 0; }));
  ASSERT_TRUE(commands_.wait_for_subscribers(1, 10s));
  msgs::GripperCommand command;
  command.set_mode(msgs::GripperCommand::VELOCITY);
  command.set_value(-0.02);
  commands_.publish(command);
  ASSERT_TRUE(wait_until([&] { return gripper_.opening() < 0.0685; }));
  ASSERT_TRUE(wait_until([&] { return !gripper_.moving(); }));
  const std::lock_guard lock(mutex_);
  // 0.2 s of 20 mm/s and some for speeding up and braking; unwatched it would close.
  EXPECT_NEAR(gripper_.opening(), 0.069 - 0.004, 0.0015);
}

TEST_F(SimulationNode, SpawnsPredictedMeshesAndRefusesBadOnes) {
  msgs::TruthShapes shapes;
  const graph::Subscription shapes_in = node_->subscribe<msgs::TruthShapes>(
      "/ground_truth/shapes", QoS::latched(1), [&](const graph::Received<msgs::TruthShapes>& m) {
        const std::lock_guard lock(mutex_);
        shapes = *m;
      });
  EXPECT_TRUE(wait_until([&] { return shapes.shapes_size() == 3; }));
  const auto spawn = node_->client<msgs::SpawnRequest, msgs::SpawnResponse>("/simulation/spawn");
  msgs::SpawnRequest request;
  request.set_name("predicted");
  geometry::TriangleMesh mesh = geometry::make_box({0.04, 0.05, 0.06});
  for (auto& v : mesh.vertices) v += Eigen::Vector3d(0.3, 0, 0.03);
  *request.mutable_mesh() = convert::to_message(mesh);
  request.set_density(500);
  auto outcome = spawn.call(request, 10s);
  ASSERT_TRUE(outcome.ok()) << outcome.error();
  EXPECT_TRUE(outcome->success()) << outcome->reason();
  EXPECT_TRUE(wait_until([&] { return truth_.bodies_size() == 4; }));
  EXPECT_NEAR(truth_.bodies(3).mass(), 0.06, 1e-6);
  EXPECT_TRUE(wait_until([&] { return shapes.shapes_size() == 4; }));
  EXPECT_EQ(shapes.shapes(3).name(), "predicted");
  EXPECT_NEAR(geometry::mass_properties(convert::from_message(shapes.shapes(3).mesh())).volume,
              1.2e-4, 1e-9);

  request.set_density(0);
  outcome = spawn.call(request, 10s);
  ASSERT_TRUE(outcome.ok()) << outcome.error();
  EXPECT_FALSE(outcome->success());
  EXPECT_NE(outcome->reason().find("density"), std::string::npos);
  request.set_density(500);
  request.mutable_mesh()->clear_data();
  outcome = spawn.call(request, 10s);
  ASSERT_TRUE(outcome.ok()) << outcome.error();
  EXPECT_FALSE(outcome->success());
}

class RigidPads : public SimulationNode {
 protected:
  void SetUp() override {
    scene_ = output_ + ".yaml";
    std::ofstream(scene_) << "physics: {pads: rigid}\nobjects: [{name: box}]\n";
    start({"--param", "scene:=" + scene_});
  }
  void TearDown() override {
    SimulationNode::TearDown();
    std::filesystem::remove(scene_);
  }
  std::string scene_;
};

// A scene without texels runs, and offers no touch.
TEST_F(RigidPads, OfferNoTouch) {
  EXPECT_TRUE(wait_until([&] { return gripper_count_ > 20 && truth_.bodies_size() == 1; }));
  std::atomic<int> frames{0};
  const auto subscription = node_->subscribe<msgs::TactileFrame>(
      "/tactile/left", QoS::queue(10),
      [&](const graph::Received<msgs::TactileFrame>&) { ++frames; });
  std::optional<int> before;
  EXPECT_TRUE(wait_until([&] {
    if (!before) before = gripper_count_;
    return gripper_count_ > *before + 50;
  }));
  EXPECT_EQ(frames, 0);
}

// Steps of 3 ms, three of which are nearest to the 10 ms between readings.
class ChosenSteps : public SimulationNode {
 protected:
  void SetUp() override {
    front_ = std::filesystem::temp_directory_path() /
             ("prehend_front_" + std::to_string(getpid()) + ".yaml");
    std::ofstream(front_) << "subject: touch\nerror_name: e\nerror_unit: of the largest sum\n"
                             "machine: a test\nsettings:\n"
                             "  - {milliseconds: 1, error: 0.2, knobs: {step: 0.008}}\n"
                             "  - {milliseconds: 3, error: 0.02, knobs: {step: 0.003}}\n";
    start({"--param", "front:=" + front_, "--param", "tolerance:=0.05"});
  }
  void TearDown() override {
    SimulationNode::TearDown();
    std::filesystem::remove(front_);
  }
  std::string front_;
};

TEST_F(ChosenSteps, AreThoseOfTheFrontsSettingAndPadsKeepTheirSize) {
  std::vector<msgs::TactileFrame> frames;
  const auto subscription = node_->subscribe<msgs::TactileFrame>(
      "/tactile/left", QoS::queue(100), [&](const graph::Received<msgs::TactileFrame>& m) {
        const std::lock_guard lock(mutex_);
        frames.push_back(*m);
      });
  ASSERT_TRUE(wait_until([&] { return frames.size() > 3; }));
  const std::lock_guard lock(mutex_);
  for (std::size_t i = 1; i < 4; ++i) {
    const std::int64_t between = frames[i].header().stamp() - frames[i - 1].header().stamp();
    EXPECT_GT(between, 0);
    EXPECT_EQ(between % 9'000'000, 0) << between;
  }
  EXPECT_EQ(frames[0].rows(), 14u);
  EXPECT_EQ(frames[0].columns(), 6u);
}

// The node's exit code and what it said.
std::pair<int, std::string> start_of_simulation(const std::vector<std::string>& parameters) {
  const graph::Registry registry({.endpoint = "tcp://127.0.0.1:*"});
  const std::string output = std::filesystem::temp_directory_path() /
                             ("prehend_simulation_bad_" + std::to_string(getpid()) + ".log");
  std::vector<std::string> arguments{"--registry", registry.endpoint()};
  for (const std::string& parameter : parameters) {
    arguments.insert(arguments.end(), {"--param", parameter});
  }
  const int code = exit_code(start_simulation(arguments, output));
  std::ifstream file(output);
  const std::string said((std::istreambuf_iterator<char>(file)), {});
  std::filesystem::remove(output);
  return {code, said};
}

TEST(SimulationNodeStart, AToleranceThatNoSettingKeepsIsRefused) {
  const auto refused = [](const std::vector<std::string>& parameters, const std::string& part) {
    const auto [code, said] = start_of_simulation(parameters);
    EXPECT_EQ(code, 2) << said;
    EXPECT_NE(said.find(part), std::string::npos) << said;
  };
  refused({"tolerance:=1e-9"}, "Allow as much as the most accurate one");
  refused({"budget:=1e-6", "robot:=kr5_sdh"}, "No setting of 'touch_hand' takes at most");
  refused({"budget:=1", "tolerance:=0.5"}, "budget and tolerance are both given");
  refused({"front:=config/fidelity/touch.yaml"}, "given without budget or tolerance");
}

TEST(SimulationNodeStart, BadSceneIsOneClearErrorAndExitCodeTwo) {
  const auto [code, message] = start_of_simulation({"scene:=config/robots/pg70_dsa.yaml"});
  EXPECT_EQ(code, 2);
  EXPECT_NE(message.find("config/robots/pg70_dsa.yaml:3: unknown key 'name'"), std::string::npos)
      << message;
}

}  // namespace
}  // namespace prehend

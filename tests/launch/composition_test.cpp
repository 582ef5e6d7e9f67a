// Several nodes in one process: the container by itself and in launches.

#include <gmock/gmock.h>
#include <signal.h>

#include <cmath>
#include <map>
#include <mutex>

#include "msgs/grasp.pb.h"
#include "msgs/objects.pb.h"
#include "prehend/graph/introspection.h"
#include "prehend/graph/node.h"
#include "prehend/graph/registry.h"
#include "tests/launch/supervision_fixture.h"

namespace prehend::testing {
namespace {

using std::chrono::seconds;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class Composition : public SupervisionTest {
 protected:
  std::unique_ptr<ChildProgram> container(const std::vector<std::string>& arguments,
                                          const std::string& output = "output.txt") {
    return std::make_unique<ChildProgram>("container", arguments, scratch_.path(output),
                                          registry_.endpoint());
  }
  std::string refusal(const std::vector<std::string>& arguments) {
    const auto program = container(arguments);
    EXPECT_EQ(program->wait(seconds(30)), 1);
    return program->output();
  }
  bool are_ready(std::size_t count) {
    graph::Introspection introspection(registry_.endpoint());
    return eventually([&] {
      std::size_t ready = 0;
      for (const auto& node : introspection.nodes()) {
        ready += node.state() == msgs::graph::READY ? 1 : 0;
      }
      return ready == count;
    });
  }

  graph::Registry registry_{graph::RegistryOptions{.endpoint = "tcp://127.0.0.1:*"}};
};

TEST_F(Composition, NodesOfOneProcessStopOnceAndTogether) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const auto program = container({"--", "shape_completion", "--name", "a", "--param",
                                    "shifts:=40", "--", "poisson_meshing", "--name", "b", "--",
                                    "recorder", "--param", "output:=" + scratch_.path("a.mcap")});
    ASSERT_TRUE(are_ready(3)) << program->output();
    graph::Introspection introspection(registry_.endpoint());
    for (const auto& node : introspection.nodes()) EXPECT_EQ(node.pid(), program->pid());
    EXPECT_EQ(graph::to_text(introspection.parameter("a", "shifts").value()), "40");
    ::kill(program->pid(), signal);
    EXPECT_EQ(program->wait(seconds(30)), 0) << program->output();
    EXPECT_TRUE(eventually([&] { return introspection.nodes().empty(); }));
  }
}

TEST_F(Composition, TheFirstFailureNamesItsNodeAndEndsAll) {
  const auto program = container({"--", "shape_completion", "--", "cloud_source", "--name",
                                  "source", "--param", "file:=/no/such.pcd"});
  EXPECT_EQ(program->wait(seconds(30)), 2);
  EXPECT_THAT(program->output(), AllOf(HasSubstr("source: "), HasSubstr("/no/such.pcd")));
}

TEST_F(Composition, ANodeThatEndsWellLeavesTheOthersRunning) {
  const auto program =
      container({"--", "shape_completion", "--", "recorder", "--param", "duration:=0.2", "--param",
                 "output:=" + scratch_.path("a.mcap")});
  ASSERT_TRUE(are_ready(2));
  ASSERT_TRUE(are_ready(1));
  EXPECT_TRUE(is_running(program->pid()));
  ::kill(program->pid(), SIGINT);
  EXPECT_EQ(program->wait(seconds(30)), 0);
}

TEST_F(Composition, WrongCommandLinesAreNamed) {
  EXPECT_THAT(refusal({}), HasSubstr("no nodes to run"));
  EXPECT_THAT(refusal({"shape_completion"}), HasSubstr("write container -- PROGRAM"));
  EXPECT_THAT(refusal({"--", "shape_completoin"}), HasSubstr("did you mean \"shape_completion\"?"));
  EXPECT_THAT(refusal({"--", "registry"}), HasSubstr("no node program 'registry'"));
  EXPECT_THAT(refusal({"--"}), HasSubstr("a program must follow"));
  EXPECT_THAT(refusal({"--", "shape_completion", "--", "shape_completion"}),
              HasSubstr("two nodes are named 'shape_completion'"));
  EXPECT_THAT(refusal({"--", "shape_completion", "--nmae", "x"}), HasSubstr("shape_completion: "));
  EXPECT_THAT(refusal({"--", "shape_completion", "--param", "shfts:=1"}),
              AllOf(HasSubstr("shape_completion: "), HasSubstr("\"shifts\"")));
}

TEST_F(Composition, HelpListsThePrograms) {
  const auto help = container({"--help"});
  EXPECT_EQ(help->wait(seconds(30)), 0);
  EXPECT_THAT(help->output(), AllOf(HasSubstr("grasp_planning"), HasSubstr("simulation"),
                                    Not(HasSubstr("registry"))));
}

// What the prediction says of a cloud, without times and stamps.
class Collected {
 public:
  explicit Collected(const std::string& registry) : node_(options(registry)) {
    shapes_ = collect<msgs::CompletedShape>("/shapes");
    models_ = collect<msgs::ObjectModel>("/models");
    plans_ = collect<msgs::GraspPlan>("/plans");
    node_.spin_in_background();
  }

  // The last of what is predicted is complete.
  bool has_plans() const {
    const std::lock_guard lock(mutex_);
    return objects_ > 0 && plan_count_ == objects_;
  }
  std::map<std::string, std::string> messages() const {
    const std::lock_guard lock(mutex_);
    return messages_;
  }

 private:
  static graph::NodeOptions options(const std::string& registry) {
    graph::NodeOptions options;
    options.name = "collector";
    options.registry = registry;
    return options;
  }

  template <class Message>
  graph::Subscription collect(const std::string& topic) {
    return node_.subscribe<Message>(
        topic, graph::QoS::latched(32), [this, topic](const graph::Received<Message>& received) {
          Message message = *received;
          message.clear_times();
          message.mutable_header()->clear_stamp();
          const std::lock_guard lock(mutex_);
          messages_[topic + " " + std::to_string(message.id())] = message.SerializeAsString();
          objects_ = message.object_count();
          plan_count_ += topic == "/plans" ? 1 : 0;
        });
  }

  mutable std::mutex mutex_;
  std::map<std::string, std::string> messages_;
  std::size_t objects_ = 0, plan_count_ = 0;
  graph::Node node_;
  graph::Subscription shapes_, models_, plans_;
};

// A table and a can on it, seen from 1 m away: x right, y down, z forward.
std::string cloud_of_a_can() {
  std::string points;
  int count = 0;
  const double tilt = 0.7;                              // of the view below the horizon
  const auto add = [&](double x, double y, double z) {  // table frame, z up
    const double forward = y * std::cos(tilt) - (z - 0.55) * std::sin(tilt);
    const double down = -(z - 0.55) * std::cos(tilt) - y * std::sin(tilt);
    points += std::to_string(x) + " " + std::to_string(down) + " " + std::to_string(forward) + "\n";
    ++count;
  };
  for (int i = -100; i <= 100; ++i) {
    for (int k = 0; k <= 200; ++k) {
      const double x = i * 3e-3, y = 0.4 + k * 3e-3;
      if (std::hypot(x, y - 0.65) > 0.04) add(x, y, (i * 7 + k * 3) % 5 * 1e-4);
    }
  }
  for (int i = 0; i <= 90; ++i) {
    for (int k = 1; k <= 60; ++k) {
      const double angle = 3.14159 * (1 + i / 90.0);  // the side towards the viewer
      add(0.03 * std::cos(angle), 0.65 + 0.03 * std::sin(angle), k * 2e-3);
    }
  }
  for (int i = -15; i <= 15; ++i) {
    for (int k = -15; k <= 15; ++k) {
      if (std::hypot(i, k) <= 15) add(i * 2e-3, 0.65 + k * 2e-3, 0.12);
    }
  }
  return "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH " +
         std::to_string(count) + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " +
         std::to_string(count) + "\nDATA ascii\n" + points;
}

TEST_F(Composition, ComposedNodesPredictTheSameAsProcesses) {
  const std::string root = std::filesystem::current_path().string();
  const std::string file = scratch_.write(
      "launch/a.yaml",
      "arguments: {composed: {type: bool}}\ninclude:\n  - file: " + root +
          "/launch/prediction.yaml\n    arguments: {composed: $(composed), gripper: " + root +
          "/config/robots/pg70_dsa.yaml}\n"
          "nodes:\n  - {node: cloud_source, parameters: {file: " +
          scratch_.write("can.pcd", cloud_of_a_can()) + "}}\n");
  std::vector<std::map<std::string, std::string>> results;
  for (const std::string composed : {"false", "true"}) {
    ChildProgram program("prehend",
                         {"launch", file, "composed:=" + composed, "--log-dir",
                          scratch_.path("log"), "--registry", "tcp://127.0.0.1:*"},
                         scratch_.path("output.txt"));
    ASSERT_TRUE(program.wait_for_output("registry listens on ")) << program.output();
    const std::string output = program.output();
    const auto at = output.find("tcp://127.0.0.1:", output.find("listens on "));
    const Collected collected(output.substr(at, output.find('\n', at) - at));
    EXPECT_TRUE(eventually([&] { return collected.has_plans(); }, seconds(60))) << program.output();
    results.push_back(collected.messages());
    ::kill(program.pid(), SIGINT);
    EXPECT_EQ(program.wait(seconds(30)), 0) << program.output();
    EXPECT_EQ(program.output().find("5 nodes in 2 processes") != std::string::npos,
              composed == "true")
        << program.output();
  }
  ASSERT_GE(results[0].size(), 3u);
  ASSERT_EQ(results[0].size(), results[1].size());
  for (const auto& [name, message] : results[0]) {
    EXPECT_TRUE(results[1].at(name) == message) << name << " differs";
  }
}

}  // namespace
}  // namespace prehend::testing

// Refusals must not look like success: exit codes and words of service call, action send, param
// set, and of a graph with keys.

#include <gmock/gmock.h>

#include "msgs/graph.pb.h"
#include "prehend/graph/security.h"
#include "tests/tools/command_fixture.h"

namespace prehend::testing {
namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

class Refusals : public Command {
 protected:
  // Says no as the simulation and the drivers do: in its answer.
  Refusals() {
    node_.declare_parameter<std::string>({.name = "model",
                                          .default_value = "a.yaml",
                                          .description = "file that is read once",
                                          .read_only = true});
    stop_ = node_.serve<msgs::Empty, msgs::Acknowledge>("/stop", [](const msgs::Empty&) {
      msgs::Acknowledge answer;
      answer.set_reason("the brake is stuck");
      return answer;
    });
    control_ = node_.serve<msgs::graph::ClockControlRequest, msgs::graph::ClockControlResponse>(
        "/control", [](const msgs::graph::ClockControlRequest& request) {
          msgs::graph::ClockControlResponse answer;
          if (request.step() <= 0) answer.set_error("a step must be positive");
          return answer;
        });
    move_ = node_.serve_action<msgs::FollowTrajectoryGoal, msgs::FollowTrajectoryFeedback,
                               msgs::FollowTrajectoryResult>(
        "/arm/follow", [](const msgs::FollowTrajectoryGoal& goal,
                          graph::ActionContext<msgs::FollowTrajectoryFeedback>&) {
          msgs::FollowTrajectoryResult result;
          if (goal.contact_force() < 0) result.set_reason("contact_force must be positive");
          result.set_contact(goal.stop_on_contact());
          result.set_reached(goal.contact_force() >= 0 && !goal.stop_on_contact());
          return result;
        });
  }

  graph::Service stop_, control_;
  graph::ActionServer move_;
};

TEST_F(Refusals, ServiceThatSaysNoFailsWithItsReason) {
  const Result stop = run({"service", "call", "/stop"});
  EXPECT_EQ(stop.exit_code, 1);
  EXPECT_THAT(stop.output, HasSubstr("/stop was not done: the brake is stuck"));
  const Result json = run({"service", "call", "/stop", "--json"});
  EXPECT_EQ(json.exit_code, 1);
  const Result control = run({"service", "call", "/control", "step: -1"});
  EXPECT_EQ(control.exit_code, 1);
  EXPECT_THAT(control.output, HasSubstr("/control was not done: a step must be positive"));
  EXPECT_EQ(run({"service", "call", "/control", "step: 5"}).exit_code, 0);
  EXPECT_EQ(run({"service", "call", "/add_one"}).exit_code, 0) << "says nothing of success";
}

TEST_F(Refusals, GoalThatIsRefusedFailsWithItsReason) {
  const Result refused = run({"action", "send", "/arm/follow", "contact_force: -1"});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.output, AllOf(HasSubstr("not done: contact_force must be positive\n"),
                                    Not(ContainsRegex("^done"))));
  const Result json = run({"action", "send", "/arm/follow", "contact_force: -1", "--json"});
  EXPECT_EQ(json.exit_code, 1);
  EXPECT_EQ(text_of(parsed(json.output), "status"), "not done");
  EXPECT_EQ(text_of(parsed(json.output), "error"), "contact_force must be positive");
  EXPECT_EQ(run({"action", "send", "/arm/follow", "contact_force: 1"}).exit_code, 0);
  EXPECT_EQ(
      run({"action", "send", "/arm/follow", "contact_force: 1 stop_on_contact: true"}).exit_code, 0)
      << "it was asked to end there";
}

TEST_F(Refusals, ParameterThatCountsAtTheStartOnlyIsNotSet) {
  const Result set = run({"param", "set", "arm", "model", "b.yaml"});
  EXPECT_EQ(set.exit_code, 1);
  EXPECT_THAT(set.output, HasSubstr("'model' is read-only and stays a.yaml"));
  EXPECT_THAT(run({"param", "list", "arm"}).output, ContainsRegex("model .* at the start only\n"));
  EXPECT_THAT(run({"param", "describe", "arm", "model"}).output,
              HasSubstr("any, when the node starts"));
  // A file with all parameters can be loaded where those agree, else nothing of it is set.
  const std::string file = scratch_.path("arm.yaml");
  ASSERT_EQ(run({"param", "dump", "arm", "-o", file}).exit_code, 0);
  EXPECT_EQ(run({"param", "load", "arm", file}).exit_code, 0);
  const Result load =
      run({"param", "load", "arm", scratch_.write("b.yaml", "speed: 7\nmodel: b\n")});
  EXPECT_EQ(load.exit_code, 1);
  EXPECT_THAT(load.output, HasSubstr("'model' is read-only"));
  EXPECT_EQ(node_.parameter<double>("speed"), 1.5);
}

TEST_F(Refusals, ListsOfADumpAreLoadedAgain) {
  node_.declare_parameter<std::vector<double>>({.name = "weights", .default_value = {1, 2.5}});
  const std::string file = scratch_.path("arm.yaml");
  ASSERT_EQ(run({"param", "dump", "arm", "-o", file}).exit_code, 0);
  ASSERT_EQ(run({"param", "set", "arm", "weights", "[3]"}).exit_code, 0);
  const Result load = run({"param", "load", "arm", file});
  EXPECT_EQ(load.exit_code, 0) << load.output;
  EXPECT_EQ(node_.parameter<std::vector<double>>("weights"), (std::vector<double>{1, 2.5}));
}

// "No graph is running" sent people to start another one.
TEST_F(Refusals, MissingAndWrongKeysAreSaid) {
  const std::string keys = scratch_.path("graph.keys"), others = scratch_.path("other.keys");
  graph::create_graph_keys(keys);
  graph::create_graph_keys(others);
  const graph::Registry locked(
      graph::RegistryOptions{.endpoint = "tcp://127.0.0.1:*", .keys_file = keys});
  const auto words_of = [&](std::vector<std::string> more) {
    std::vector<std::string> words{"node", "list", "--registry", locked.endpoint()};
    words.insert(words.end(), more.begin(), more.end());
    const Result result = run(words);
    EXPECT_EQ(result.exit_code, 1) << result.output;
    EXPECT_THAT(result.output, Not(HasSubstr("no graph is running")));
    return result.output;
  };
  EXPECT_THAT(words_of({}), AllOf(HasSubstr("uses keys"), HasSubstr("--keys FILE")));
  EXPECT_THAT(words_of({"--keys", others}), HasSubstr("has other keys"));
  EXPECT_EQ(run({"node", "list", "--registry", locked.endpoint(), "--keys", keys}).exit_code, 0);
  const Result open = run({"node", "list", "--keys", keys});
  EXPECT_EQ(open.exit_code, 1);
  EXPECT_THAT(open.output, HasSubstr("uses no keys"));
}

TEST_F(Refusals, EchoOfALatchedTopicBeginsWithTheNewest) {
  const auto kept = node_.advertise<msgs::Clock>("/kept", graph::QoS::latched(50));
  graph::Node other(node_options("other"));
  const auto kept_too = other.advertise<msgs::Clock>("/kept", graph::QoS::latched(50));
  msgs::Clock clock;
  for (int i = 1; i <= 30; ++i) {
    clock.set_time(i);
    (i % 2 == 0 ? kept : kept_too).publish(clock);
  }
  EXPECT_THAT(run({"topic", "echo", "/kept", "-n", "1"}).output, HasSubstr("\ntime: 30\n---\n"));
  const std::string last = run({"topic", "echo", "/kept", "-n", "3"}).output;
  EXPECT_THAT(last, AllOf(ContainsRegex("time: 28\n(.|\n)*time: 29\n(.|\n)*time: 30\n"),
                          Not(HasSubstr("time: 27"))));
}

TEST_F(Refusals, MistypedWordsAreNamedWithTheNearest) {
  const auto words_of = [&](const std::vector<std::string>& words) {
    const Result result = run(words);
    EXPECT_EQ(result.exit_code, 2) << result.output;
    return result.output;
  };
  EXPECT_EQ(words_of({"topik", "list"}),
            "prehend has no command \"topik\"; did you mean \"topic\"?\n");
  EXPECT_EQ(words_of({"topic", "ehco", "/a"}),
            "prehend topic has no command \"ehco\"; did you mean \"echo\"?\n");
  EXPECT_EQ(words_of({"topic", "echo", "/a", "--ful"}),
            "prehend topic echo has no option \"--ful\"; did you mean \"--full\"?\n");
  EXPECT_THAT(words_of({"quixotic"}), AllOf(HasSubstr("there are: "), HasSubstr("doctor")));
  EXPECT_EQ(words_of({"param", "get", "arm"}).find("prehend param has no command"),
            std::string::npos);
  EXPECT_EQ(
      run({"topic", "pub", "/gripper/command", "value: -1", "--rate", "50", "-n", "2"}).exit_code,
      0);
}

TEST_F(Refusals, VersionIsSaid) {
  const Result version = run({"--version"});
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_THAT(version.output, ContainsRegex("^prehend [0-9]+\\.[0-9]+\\.[0-9]+\n$"));
}

}  // namespace
}  // namespace prehend::testing

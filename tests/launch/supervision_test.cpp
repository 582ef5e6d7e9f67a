// `prehend launch` as a real process, with small programs as its nodes.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <iterator>
#include <memory>
#include <sstream>

#include "tests/launch/child_program.h"

namespace prehend::testing {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using std::chrono::steady_clock;
using ::testing::HasSubstr;
using ::testing::Not;

class Supervision : public ::testing::Test {
 protected:
  // A launch of `nodes` with a registry of its own.
  std::unique_ptr<ChildProgram> launch(const std::string& nodes) {
    const std::string file = scratch_.write("launch/a.yaml", "nodes:\n" + nodes);
    return std::make_unique<ChildProgram>(
        "prehend",
        std::vector<std::string>{"launch", file, "--log-dir", scratch_.path("log"), "--registry",
                                 "tcp://127.0.0.1:*"},
        scratch_.path("output.txt"));
  }
  std::string node(const std::string& name, const std::string& parameters,
                   const std::string& more = "") {
    return "  - {node: launch_test_node, name: " + name + ", parameters: {touch: " + pids_file() +
           ", " + parameters + "}" + (more.empty() ? "" : ", " + more) + "}\n";
  }
  std::string pids_file() { return scratch_.path("pids"); }
  // Of every test node that was started so far.
  std::vector<pid_t> pids() {
    std::istringstream text(text_of_file(pids_file()));
    return {std::istream_iterator<pid_t>(text), {}};
  }
  bool wait_for_pids(std::size_t count) {
    return eventually([&] { return pids().size() >= count; });
  }
  void expect_none_running() {
    for (const pid_t pid : pids()) {
      EXPECT_TRUE(eventually([&] { return !is_running(pid); }, seconds(2))) << pid;
    }
  }

  ScratchDirectory scratch_;
};

TEST_F(Supervision, ARequiredNodesFailureEndsTheLaunchWithItsReason) {
  const auto program =
      launch(node("idle", "after: 50") +
             node("vital", "say: no camera, after: 0.2, exit: 3", "required: true"));
  EXPECT_EQ(program->wait(seconds(10)), 1);
  EXPECT_THAT(program->output(),
              HasSubstr("required node vital: exit code 3; it said last: no camera"));
  EXPECT_EQ(pids().size(), 2u);
  expect_none_running();
}

TEST_F(Supervision, ARequiredNodesSignalIsNamed) {
  const auto program = launch(node("vital", "after: 0.1, signal: 11", "required: true"));
  EXPECT_EQ(program->wait(seconds(10)), 1);
  EXPECT_THAT(program->output(), HasSubstr("required node vital: signal SIGSEGV"));
}

TEST_F(Supervision, ARequiredNodeThatFinishesEndsTheLaunchWell) {
  const auto program =
      launch(node("idle", "after: 50") + node("vital", "after: 0.1", "required: true"));
  EXPECT_EQ(program->wait(seconds(10)), 0);
  EXPECT_THAT(program->output(), HasSubstr("vital finished"));
  expect_none_running();
}

TEST_F(Supervision, TheLaunchEndsWithItsLastNode) {
  EXPECT_EQ(launch(node("a", "after: 0.1"))->wait(seconds(10)), 0);
  const auto failing = launch(node("a", "after: 0.1, exit: 4"));
  EXPECT_EQ(failing->wait(seconds(10)), 1);
  EXPECT_THAT(failing->output(), HasSubstr("a: exit code 4 before it was ready"));
}

TEST_F(Supervision, ANodeIsStartedAgainLaterEachTime) {
  const auto start = steady_clock::now();
  const auto program = launch(node("weak", "after: 0.05, exit: 2", "respawn: true"));
  ASSERT_TRUE(wait_for_pids(3));  // at 0, 0.5 and 1.5 s
  EXPECT_GE(steady_clock::now() - start, milliseconds(1500));
  ::kill(program->pid(), SIGINT);
  EXPECT_EQ(program->wait(seconds(10)), 0);
  EXPECT_THAT(program->output(), HasSubstr("weak: exit code 2; starting it again in 0.5 s"));
  EXPECT_THAT(program->output(), HasSubstr("starting it again in 1.0 s"));
  expect_none_running();
}

TEST_F(Supervision, AKilledNodeIsStartedAgain) {
  const auto program = launch(node("weak", "after: 50", "respawn: true"));
  ASSERT_TRUE(wait_for_pids(1));
  ::kill(pids()[0], SIGKILL);
  ASSERT_TRUE(wait_for_pids(2));
  EXPECT_TRUE(is_running(pids()[1]));
  EXPECT_THAT(program->output(), HasSubstr("weak: signal SIGKILL"));
}

TEST_F(Supervision, InterruptAndTerminateStopAll) {
  for (const int signal : {SIGINT, SIGTERM}) {
    std::filesystem::remove(pids_file());
    const auto program = launch(node("a", "after: 50") + node("b", "after: 50"));
    ASSERT_TRUE(wait_for_pids(2));
    ::kill(program->pid(), signal);
    const auto start = steady_clock::now();
    EXPECT_EQ(program->wait(seconds(10)), 0);
    EXPECT_LT(steady_clock::now() - start, seconds(2));
    expect_none_running();
  }
}

TEST_F(Supervision, ANodeThatIgnoresSignalsIsKilledInTheEnd) {
  const auto program = launch(node("mule", "after: 50, stubborn: true"));
  ASSERT_TRUE(wait_for_pids(1));
  ::kill(program->pid(), SIGINT);
  EXPECT_EQ(program->wait(seconds(15)), 0);
  EXPECT_THAT(program->output(), HasSubstr("mule does not stop: sending SIGTERM"));
  EXPECT_THAT(program->output(), HasSubstr("mule does not stop: sending SIGKILL"));
  expect_none_running();
}

TEST_F(Supervision, ASecondInterruptKillsAtOnce) {
  const auto program = launch(node("mule", "after: 50, stubborn: true"));
  ASSERT_TRUE(wait_for_pids(1));
  ::kill(program->pid(), SIGINT);
  ASSERT_TRUE(program->wait_for_output("stopping all nodes"));
  const auto start = steady_clock::now();
  ::kill(program->pid(), SIGINT);
  EXPECT_EQ(program->wait(seconds(10)), 0);
  EXPECT_LT(steady_clock::now() - start, seconds(2));
  expect_none_running();
}

TEST_F(Supervision, NothingSurvivesAKilledLaunch) {
  const auto program = launch(node("a", "after: 50, stubborn: true") + node("b", "after: 50"));
  ASSERT_TRUE(wait_for_pids(2));
  ::kill(program->pid(), SIGKILL);
  EXPECT_EQ(program->wait(seconds(5)), 128 + SIGKILL);
  expect_none_running();
}

TEST_F(Supervision, OutputIsPrefixedAndLoggedAndTheEnvironmentArrives) {
  const auto program = launch(
      node("talker", "say: hello there, print: COLOUR, after: 0.1", "environment: {COLOUR: blue}"));
  EXPECT_EQ(program->wait(seconds(10)), 0);
  EXPECT_THAT(program->output(), HasSubstr("talker   | hello there\n"));
  EXPECT_THAT(text_of_file(scratch_.path("log/talker.log")),
              HasSubstr("COLOUR=blue\nhello there\n"));
  EXPECT_THAT(text_of_file(scratch_.path("log/launch.log")), HasSubstr("peak memory"));
}

TEST_F(Supervision, TheRegistrysEndpointArrives) {
  const auto program = launch(node("talker", "print: PREHEND_REGISTRY, after: 0.1"));
  EXPECT_EQ(program->wait(seconds(10)), 0);
  EXPECT_THAT(program->output(), HasSubstr("PREHEND_REGISTRY=tcp://127.0.0.1:"));
}

TEST_F(Supervision, ReadinessComesFromTheRegistryAndUnusedRemapsAreNamed) {
  const auto program =
      launch("  - {node: recorder, parameters: {output: " + scratch_.path("a.mcap") +
             "}, remap: {/lgo: /x}}\n");
  ASSERT_TRUE(program->wait_for_output("1 node ready after"));
  EXPECT_TRUE(program->wait_for_output("remap of /lgo: recorder has no such topic"));
  EXPECT_THAT(program->output(), HasSubstr("did you mean \"/log\"?"));
  ::kill(program->pid(), SIGINT);
  EXPECT_EQ(program->wait(seconds(10)), 0);
}

TEST_F(Supervision, ARegistryPortInUseIsAClearError) {
  const auto first = launch(node("a", "after: 50"));
  ASSERT_TRUE(first->wait_for_output("registry listens on "));
  const std::string output = first->output();
  const auto at = output.find("tcp://127.0.0.1:", output.find("listens on "));
  const std::string endpoint = output.substr(at, output.find('\n', at) - at);
  ChildProgram second("prehend",
                      {"launch", scratch_.path("launch/a.yaml"), "--registry", endpoint,
                       "--log-dir", scratch_.path("log2")},
                      scratch_.path("second.txt"));
  EXPECT_EQ(second.wait(seconds(10)), 1);
  EXPECT_THAT(second.output(), HasSubstr("in use"));
}

}  // namespace
}  // namespace prehend::testing

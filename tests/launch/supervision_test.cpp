// `prehend launch` as a real process, with small programs as its nodes.

#include <gmock/gmock.h>
#include <signal.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>

#include "tests/launch/supervision_fixture.h"
#include "tests/system/launched.h"

namespace prehend::testing {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using std::chrono::steady_clock;
using ::testing::HasSubstr;
using ::testing::Not;

TEST_F(SupervisionTest, ARequiredNodesFailureEndsTheLaunchWithItsReason) {
  const auto program =
      launch(node("idle", "after: 50") +
             node("vital", "say: no camera, after: 0.2, exit: 4", "required: true"));
  EXPECT_EQ(program->wait(seconds(10)), 1);
  EXPECT_THAT(program->output(),
              HasSubstr("required node vital: exit code 4; it said last: no camera"));
  EXPECT_EQ(pids().size(), 2u);
  expect_none_running();
}

TEST_F(SupervisionTest, ARequiredNodesSignalIsNamed) {
  const auto program = launch(node("vital", "after: 0.1, signal: 6", "required: true"));
  EXPECT_EQ(program->wait(seconds(10)), 1);
  EXPECT_THAT(program->output(), HasSubstr("required node vital: signal SIGABRT"));
}

TEST_F(SupervisionTest, ARequiredNodeThatFinishesEndsTheLaunchWell) {
  const auto program =
      launch(node("idle", "after: 50") + node("vital", "after: 0.1", "required: true"));
  EXPECT_EQ(program->wait(seconds(10)), 0);
  EXPECT_THAT(program->output(), HasSubstr("vital finished"));
  expect_none_running();
}

// It was a failure: who ran launches could not tell what cannot be grasped from what went wrong.
TEST_F(SupervisionTest, ARequiredNodesNoIsTheLaunchsAnswer) {
  // The other has found the same, and says so when it is asked to stop.
  const auto program =
      launch(node("other", "linger: 0, after: 50, exit: 3") +
             node("vital", "say: too wide, after: 0.5, exit: 3", "required: true"));
  EXPECT_EQ(program->wait(seconds(10)), 3);
  EXPECT_THAT(program->output(),
              HasSubstr("vital finished, and its answer is no; it said last: too wide"));
  EXPECT_THAT(program->output(), Not(HasSubstr("ended badly")));
  expect_none_running();
}

TEST_F(SupervisionTest, ANoDoesNotHideAFailure) {
  const auto program = launch(node("other", "linger: 0, after: 50, exit: 4") +
                              node("vital", "after: 0.5, exit: 3", "required: true"));
  EXPECT_EQ(program->wait(seconds(10)), 1);
  EXPECT_THAT(program->output(), HasSubstr("other ended badly"));
}

TEST_F(SupervisionTest, TheLaunchEndsWithItsLastNode) {
  EXPECT_EQ(launch(node("a", "after: 0.1"))->wait(seconds(10)), 0);
  const auto failing = launch(node("a", "after: 0.1, exit: 4"));
  EXPECT_EQ(failing->wait(seconds(10)), 1);
  EXPECT_THAT(failing->output(), HasSubstr("a: exit code 4 before it was ready"));
}

TEST_F(SupervisionTest, ANodeIsStartedAgainLaterEachTime) {
  const auto start = steady_clock::now();
  const auto program = launch(node("weak", "after: 0.05, exit: 3", "respawn: true"));
  ASSERT_TRUE(wait_for_pids(3));  // at 0, 0.5 and 1.5 s
  EXPECT_GE(steady_clock::now() - start, milliseconds(1500));
  ASSERT_TRUE(program->wait_for_output("starting it again in 2.0 s"));
  ::kill(program->pid(), SIGINT);
  EXPECT_EQ(program->wait(seconds(10)), 1) << "its last run failed, too";
  EXPECT_THAT(program->output(), HasSubstr("weak: exit code 3; starting it again in 0.5 s"));
  EXPECT_THAT(program->output(), HasSubstr("starting it again in 1.0 s"));
  expect_none_running();
}

// Without an end, a wrong configuration would keep the launch starting it for ever.
TEST_F(SupervisionTest, ANodeThatNeverComesUpIsGivenUpWithItsReason) {
  const auto program = launch(node("idle", "after: 500") +
                              node("weak", "say: no such device, after: 0, exit: 3",
                                   "respawn: {first_delay: 0.05, longest_delay: 0.05}"));
  EXPECT_EQ(program->wait(seconds(60)), 1);
  EXPECT_THAT(program->output(),
              HasSubstr("node weak: exit code 3, 5 times in a row before it was ready; it said "
                        "last: no such device; it is given up"));
  EXPECT_EQ(pids().size(), 6u);  // one of idle
  expect_none_running();
}

// As with a mistyped value: the next start would end as this one did.
TEST_F(SupervisionTest, ANodeThatRefusesItsParametersIsNotStartedAgain) {
  const auto program =
      launch(node("idle", "after: 500") + node("weak", "say: place is \"abc\", after: 0, exit: 2",
                                               "respawn: {first_delay: 0.05}"));
  EXPECT_EQ(program->wait(seconds(60)), 1);
  EXPECT_THAT(
      program->output(),
      HasSubstr("node weak: exit code 2; it said last: place is \"abc\"; it refuses what it "
                "is given and is not started again"));
  EXPECT_LE(pids().size(), 2u);
  expect_none_running();
}

TEST_F(SupervisionTest, ANodeThatWasReadyOnceIsDoneWithoutWhenItDoesNotComeUpAgain) {
  scratch_.write("kept/readme", "");
  const auto program =
      launch(node("idle", "after: 500, exit: 0", "after: [recorder]") +
             "  - {node: recorder, parameters: {output: " + scratch_.path("kept/a.mcap") +
             "}, respawn: {first_delay: 0.05, longest_delay: 0.05}}\n");
  ASSERT_TRUE(wait_for_pids(1));  // which is started when the recorder is ready
  std::filesystem::remove_all(scratch_.path("kept"));
  scratch_.write("kept", "in the way of the folder");
  const auto recorders = descendants(program->pid(), "recorder");
  ASSERT_EQ(recorders.size(), 1u);
  ::kill(recorders[0], SIGKILL);
  EXPECT_TRUE(
      program->wait_for_output("it is given up, and the others go on without it", seconds(60)))
      << program->output();
  EXPECT_TRUE(is_running(pids()[0]));
  ::kill(program->pid(), SIGINT);
  EXPECT_EQ(program->wait(seconds(20)), 1);
}

TEST_F(SupervisionTest, AKilledNodeIsStartedAgain) {
  const auto program = launch(node("weak", "after: 50", "respawn: true"));
  ASSERT_TRUE(wait_for_pids(1));
  ::kill(pids()[0], SIGKILL);
  ASSERT_TRUE(wait_for_pids(2));
  EXPECT_TRUE(is_running(pids()[1]));
  EXPECT_THAT(program->output(), HasSubstr("weak: signal SIGKILL"));
}

TEST_F(SupervisionTest, NothingSurvivesAKilledLaunch) {
  const auto program = launch(node("a", "after: 50, stubborn: true") + node("b", "after: 50"));
  ASSERT_TRUE(wait_for_pids(2));
  ::kill(program->pid(), SIGKILL);
  EXPECT_EQ(program->wait(seconds(5)), 128 + SIGKILL);
  expect_none_running();
}

TEST_F(SupervisionTest, OutputIsPrefixedAndLoggedAndTheEnvironmentArrives) {
  const auto program = launch(
      node("talker", "say: hello there, print: COLOUR, after: 0.1", "environment: {COLOUR: blue}"));
  EXPECT_EQ(program->wait(seconds(10)), 0);
  EXPECT_THAT(program->output(), HasSubstr("talker   | hello there\n"));
  EXPECT_THAT(text_of_file(scratch_.path("log/talker.log")),
              HasSubstr("COLOUR=blue\nhello there\n"));
  EXPECT_THAT(text_of_file(scratch_.path("log/launch.log")), HasSubstr("peak memory"));
}

TEST_F(SupervisionTest, TheRegistrysEndpointArrives) {
  const auto program = launch(node("talker", "print: PREHEND_REGISTRY, after: 0.1"));
  EXPECT_EQ(program->wait(seconds(10)), 0);
  EXPECT_THAT(program->output(), HasSubstr("PREHEND_REGISTRY=tcp://127.0.0.1:"));
}

TEST_F(SupervisionTest, ReadinessComesFromTheRegistryAndUnusedRemapsAreNamed) {
  const auto program =
      launch("  - {node: recorder, parameters: {output: " + scratch_.path("a.mcap") +
             "}, remap: {/lgo: /x}}\n");
  ASSERT_TRUE(program->wait_for_output("1 node ready after"));
  EXPECT_TRUE(program->wait_for_output("remap of /lgo: recorder has no such topic"));
  EXPECT_THAT(program->output(), HasSubstr("did you mean \"/log\"?"));
  ::kill(program->pid(), SIGINT);
  EXPECT_EQ(program->wait(seconds(10)), 0);
}

TEST_F(SupervisionTest, ARegistryPortInUseIsAClearError) {
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

// `prehend node list` with the same environment looked at another graph.
TEST_F(SupervisionTest, ListensWhereTheEnvironmentSays) {
  const std::string endpoint = "ipc://" + scratch_.path("registry");
  const std::string file = scratch_.write(
      "launch/a.yaml", "nodes:\n" + node("talker", "print: PREHEND_REGISTRY, after: 0.1"));
  ChildProgram program("prehend", {"launch", file, "--log-dir", scratch_.path("log")},
                       scratch_.path("output.txt"), endpoint);
  EXPECT_EQ(program.wait(std::chrono::seconds(20)), 0) << program.output();
  EXPECT_THAT(program.output(), HasSubstr("PREHEND_REGISTRY=" + endpoint));
}

TEST_F(SupervisionTest, ProgramsOfOtherProjectsAreFoundInTheNodePath) {
  const auto own = std::filesystem::path(std::getenv("PREHEND_BIN")) / "launch_test_node";
  std::filesystem::create_directories(scratch_.path("other"));
  std::filesystem::create_symlink(std::filesystem::absolute(own), scratch_.path("other/wave"));
  ::setenv("PREHEND_NODE_PATH", scratch_.path("other").c_str(), 1);
  const auto program = launch(
      "  - {node: wave, parameters: {touch: " + pids_file() + ", say: hello, after: 0.1}}\n" +
      "  - {node: ../other/wave, name: again, parameters: {touch: " + pids_file() +
      ", say: hello again, after: 0.1}}\n");
  ::unsetenv("PREHEND_NODE_PATH");
  EXPECT_EQ(program->wait(std::chrono::seconds(20)), 0) << program->output();
  EXPECT_THAT(program->output(), HasSubstr("wave     | hello\n"));
  EXPECT_THAT(program->output(), HasSubstr("again    | hello again\n"));
}

}  // namespace
}  // namespace prehend::testing

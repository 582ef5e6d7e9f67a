// Start order, CPUs, delays, hosts and checks of `prehend launch`, as a real process.

#include <gmock/gmock.h>
#include <sched.h>
#include <signal.h>
#include <sys/resource.h>

#include <algorithm>

#include "tests/launch/supervision_fixture.h"

namespace prehend::testing {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using std::chrono::steady_clock;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class StartOrder : public SupervisionTest {
 protected:
  // A node that is ready soon.
  std::string recorder(const std::string& more) {
    return "  - {node: recorder, parameters: {output: " + scratch_.path("a.mcap") + "}, " + more +
           "}\n";
  }
  std::unique_ptr<ChildProgram> prehend(std::vector<std::string> arguments,
                                        const std::string& output) {
    arguments.insert(arguments.begin(), "launch");
    return std::make_unique<ChildProgram>("prehend", arguments, scratch_.path(output));
  }
};

TEST_F(StartOrder, ANodeStartsWhenTheOneBeforeItIsReady) {
  const auto program = launch(node("second", "after: 50", "after: [recorder]") + recorder(""));
  ASSERT_TRUE(wait_for_pids(1));
  // The recorder says so in the moment in which it becomes ready.
  EXPECT_TRUE(program->wait_for_output("recording to"));
  ::kill(program->pid(), SIGINT);
  EXPECT_EQ(program->wait(seconds(10)), 0);
  EXPECT_THAT(program->output(), AllOf(HasSubstr("recording to"), Not(HasSubstr("cut short"))));
}

TEST_F(StartOrder, ANodeIsNotStartedBeforeAndAfterASuccessfulEnd) {
  const auto program = launch(node("first", "after: 1, exit: 0") +
                              node("second", "say: now, after: 50", "after: [first]"));
  ASSERT_TRUE(wait_for_pids(1));
  const auto start = steady_clock::now();
  while (steady_clock::now() - start < milliseconds(500)) {
    EXPECT_EQ(pids().size(), 1u);
    std::this_thread::sleep_for(milliseconds(20));
  }
  EXPECT_TRUE(wait_for_pids(2));
  EXPECT_THAT(program->output(), HasSubstr("first finished"));
}

TEST_F(StartOrder, ADependencyThatDiesBeforeItIsReadyEndsTheLaunch) {
  const auto program =
      launch(node("first", "after: 0.3, exit: 3") + node("second", "after: 50", "after: [first]"));
  EXPECT_EQ(program->wait(seconds(10)), 1);
  EXPECT_THAT(program->output(), HasSubstr("first: exit code 3 before it was ready"));
  EXPECT_EQ(pids().size(), 1u);
}

TEST_F(StartOrder, ADependencyThatIsStartedAgainIsWaitedFor) {
  const auto program = launch(
      node("first", "after: 0.1, exit: 3", "respawn: {first_delay: 0.1, longest_delay: 0.2}") +
      node("second", "after: 50", "after: [first]"));
  ASSERT_TRUE(wait_for_pids(4));
  EXPECT_THAT(program->output(), AllOf(HasSubstr("again in 0.1 s"), HasSubstr("again in 0.2 s"),
                                       Not(HasSubstr("again in 0.4 s"))));
}

TEST_F(StartOrder, ANodeKeepsToItsCpus) {
  const auto program = launch(node("pinned", "after: 50", "cpu_affinity: [0]"));
  ASSERT_TRUE(wait_for_pids(1));
  cpu_set_t cpus;
  ASSERT_EQ(::sched_getaffinity(pids()[0], sizeof cpus, &cpus), 0);
  EXPECT_EQ(CPU_COUNT(&cpus), 1);
  EXPECT_TRUE(CPU_ISSET(0, &cpus));
  const auto refused = launch(node("pinned", "after: 50", "cpu_affinity: [1000]"));
  EXPECT_EQ(refused->wait(seconds(10)), 1);
  EXPECT_THAT(refused->output(), AllOf(HasSubstr("a.yaml:2"), HasSubstr("CPU 1000 is not")));
}

TEST_F(StartOrder, ANodeYieldsAsItSays) {
  const auto program = launch(node("yields", "after: 50", "nice: 7"));
  ASSERT_TRUE(wait_for_pids(1));
  const int own = ::getpriority(PRIO_PROCESS, 0);
  EXPECT_EQ(::getpriority(PRIO_PROCESS, static_cast<id_t>(pids()[0])), std::min(19, own + 7));
}

TEST_F(StartOrder, WrongParametersAreNamedBeforeAnythingStarts) {
  const auto program =
      launch(node("idle", "after: 50") +
             "  - node: recorder\n    parameters:\n      ouput: x.mcap\n      duration: -1\n"
             "      compression: zip\n");
  EXPECT_EQ(program->wait(seconds(20)), 1);
  EXPECT_THAT(program->output(),
              AllOf(HasSubstr("a.yaml:5: recorder has no parameter \"ouput\"; did you mean "
                              "\"output\"?"),
                    HasSubstr("a.yaml:6: parameter 'duration' [s]: '-1' must be at least 0"),
                    HasSubstr("a.yaml:7: parameter 'compression': 'zip' must be one of")));
  EXPECT_TRUE(pids().empty());
}

TEST_F(StartOrder, ParameterFilesAreCheckedAtTheirLine) {
  scratch_.write("launch/p.yaml", "output: a.mcap\ndurtion: 5\n");
  const auto program = launch("  - {node: recorder, parameter_file: p.yaml}\n");
  EXPECT_EQ(program->wait(seconds(20)), 1);
  EXPECT_THAT(program->output(), AllOf(HasSubstr("p.yaml:2: "), HasSubstr("\"duration\"")));
}

TEST_F(StartOrder, TheLogFolderStandsInTheFile) {
  const std::string file =
      scratch_.write("launch/a.yaml", "log_directory: " + scratch_.path("kept") + "\nnodes:\n" +
                                          node("talker", "say: hello, after: 0"));
  const auto program = prehend({file, "--registry", "tcp://127.0.0.1:*"}, "output.txt");
  EXPECT_EQ(program->wait(seconds(10)), 0);
  EXPECT_THAT(text_of_file(scratch_.path("kept/talker.log")), HasSubstr("hello"));
}

TEST_F(StartOrder, CheckGoesThroughAFolderAndCountsTheWrongOnes) {
  scratch_.write("launch/a.yaml", "nodes:\n" + node("a", "after: 1"));
  scratch_.write("launch/deep/b.yaml", "nodes:\n  - {node: recorder, parameters: {topcs: /a}}\n");
  const auto program = prehend({"--check", scratch_.path("launch")}, "output.txt");
  EXPECT_EQ(program->wait(seconds(20)), 1);
  EXPECT_THAT(program->output(),
              AllOf(HasSubstr("a.yaml: correct, 1 nodes"), HasSubstr("b.yaml:2: "),
                    HasSubstr("\"topics\""), HasSubstr("1 of 2 launch files are wrong")));
  const auto nothing = prehend({"--check", scratch_.path("nowhere")}, "nothing.txt");
  EXPECT_EQ(nothing->wait(seconds(10)), 1);
  EXPECT_THAT(nothing->output(), HasSubstr("nowhere"));
}

TEST_F(StartOrder, EachHostStartsItsOwnNodesAndTheOthersJoin) {
  const std::string file = scratch_.write(
      "launch/a.yaml",
      "hosts: {cell: {address: 127.0.0.1}, arm: {address: 127.0.0.2}}\nnodes:\n" +
          node("here", "say: cell speaks, after: 50") +
          node("there", "say: arm speaks, print: PREHEND_REGISTRY, after: 50", "host: arm"));
  const auto undecided = prehend({file}, "undecided.txt");
  EXPECT_EQ(undecided->wait(seconds(10)), 1);
  EXPECT_THAT(undecided->output(), HasSubstr("--host cell or arm"));
  const auto cell = prehend({file, "--host", "cell", "--registry", "tcp://127.0.0.1:*", "--log-dir",
                             scratch_.path("cell")},
                            "cell.txt");
  ASSERT_TRUE(cell->wait_for_output("cell speaks"));
  const std::string output = cell->output();
  const auto at = output.find("tcp://127.0.0.1:", output.find("listens on "));
  const std::string endpoint = output.substr(at, output.find('\n', at) - at);
  const auto arm =
      prehend({file, "--host", "arm", "--registry", endpoint, "--log-dir", scratch_.path("arm")},
              "arm.txt");
  ASSERT_TRUE(arm->wait_for_output("arm speaks"));
  EXPECT_THAT(arm->output(),
              AllOf(HasSubstr("joining the registry at " + endpoint),
                    HasSubstr("PREHEND_REGISTRY=" + endpoint), Not(HasSubstr("cell speaks"))));
  EXPECT_THAT(cell->output(), Not(HasSubstr("arm speaks")));
  for (const auto* program : {&arm, &cell}) {
    ::kill((*program)->pid(), SIGINT);
    EXPECT_EQ((*program)->wait(seconds(10)), 0);
  }
  expect_none_running();
}

TEST_F(StartOrder, HostsBeyondLoopbackNeedKeys) {
  ::unsetenv("PREHEND_KEYS");
  const std::string file = scratch_.write(
      "launch/a.yaml", "hosts: {cell: {address: 10.11.12.13}}\nnodes:\n" + node("a", "after: 50"));
  const auto program = prehend({file}, "output.txt");
  EXPECT_EQ(program->wait(seconds(10)), 1);
  EXPECT_THAT(program->output(), AllOf(HasSubstr("cell (10.11.12.13)"), HasSubstr("keys create")));
  const auto lost = prehend({file, "--keys", scratch_.path("none")}, "lost.txt");
  EXPECT_EQ(lost->wait(seconds(10)), 2);
  EXPECT_THAT(lost->output(), HasSubstr("--keys: File does not exist"));
  EXPECT_TRUE(pids().empty());
}

}  // namespace
}  // namespace prehend::testing

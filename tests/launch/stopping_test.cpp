// How `prehend launch` ends: who gets how much time, what the last lines and the exit code say.

#include <gmock/gmock.h>
#include <signal.h>

#include <chrono>

#include "prehend/recording/recording_check.h"
#include "tests/launch/supervision_fixture.h"
#include "tests/system/launched.h"

namespace prehend::testing {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using std::chrono::steady_clock;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

class StoppingTest : public SupervisionTest {
 protected:
  // Two Ctrl-C, the second when the first one is being worked on.
  static void interrupt_twice(ChildProgram& program) {
    ::kill(program.pid(), SIGINT);
    ASSERT_TRUE(program.wait_for_output("stopping all nodes"));
    ::kill(program.pid(), SIGINT);
  }
  static std::string last_lines(const ChildProgram& program) {
    const std::string output = program.output();
    return output.substr(std::min(output.size(), output.find("all stopped after")));
  }
  std::string recorder(const std::string& file, const std::string& more = "") const {
    return "  - {node: recorder, parameters: {output: " + scratch_.path(file) + "}" + more + "}\n";
  }
};

TEST_F(StoppingTest, InterruptAndTerminateStopAll) {
  for (const int signal : {SIGINT, SIGTERM}) {
    std::filesystem::remove(pids_file());
    const auto program = launch(node("a", "after: 50") + node("b", "after: 50"));
    ASSERT_TRUE(wait_for_pids(2));
    ::kill(program->pid(), signal);
    EXPECT_EQ(program->wait(seconds(10)), 0);
    expect_none_running();
  }
}

TEST_F(StoppingTest, ANodeThatIgnoresSignalsIsKilledInTheEnd) {
  const auto program = launch(node("mule", "after: 50, stubborn: true"));
  ASSERT_TRUE(wait_for_pids(1));
  ::kill(program->pid(), SIGINT);
  EXPECT_EQ(program->wait(seconds(15)), 1) << "one had to be killed";
  EXPECT_THAT(program->output(), HasSubstr("mule does not stop: sending SIGTERM"));
  EXPECT_THAT(program->output(), HasSubstr("mule does not stop: sending SIGKILL"));
  EXPECT_THAT(last_lines(*program), HasSubstr("mule ended badly once after "));
  EXPECT_THAT(last_lines(*program), HasSubstr("killed, as it did not stop when asked to"));
  expect_none_running();
}

// It killed at once, with exit code 0.
TEST_F(StoppingTest, ASecondInterruptKillsTwoSecondsAfterTheFirst) {
  const auto program = launch(node("mule", "after: 50, stubborn: true"));
  ASSERT_TRUE(wait_for_pids(1));
  const auto start = steady_clock::now();
  interrupt_twice(*program);
  EXPECT_EQ(program->wait(seconds(15)), 1);
  EXPECT_GE(steady_clock::now() - start, seconds(2));
  EXPECT_THAT(program->output(), HasSubstr("a second signal: what still runs is killed 2 s"));
  EXPECT_THAT(program->output(), Not(HasSubstr("sending SIGTERM"))) << "there is a hurry";
  expect_none_running();
}

TEST_F(StoppingTest, WhoSaysSoHasItsTimeHoweverOftenInterrupted) {
  const std::string written = scratch_.path("written");
  const auto program =
      launch(node("writer", "after: 50, linger: 4, finished: " + written, "stop_time: 60"));
  ASSERT_TRUE(wait_for_pids(1));
  interrupt_twice(*program);
  ASSERT_TRUE(program->wait_for_output("writer has 60 s"));
  ::kill(program->pid(), SIGINT);
  ::kill(program->pid(), SIGTERM);
  EXPECT_EQ(program->wait(seconds(30)), 0) << program->output();
  EXPECT_EQ(text_of_file(written), "finished");
}

// The recorder was killed in the middle of its writing, and the recording lost.
TEST_F(StoppingTest, ASecondInterruptLosesNoRecording) {
  const auto program = launch(recorder("a.mcap") + node("idle", "after: 50", "after: [recorder]"));
  ASSERT_TRUE(wait_for_pids(1));
  ::kill(program->pid(), SIGINT);
  std::this_thread::sleep_for(milliseconds(50));
  ::kill(program->pid(), SIGINT);
  EXPECT_EQ(program->wait(seconds(60)), 0) << program->output();
  EXPECT_THAT(recording::check_recording(scratch_.path("a.mcap")).problems, IsEmpty());
}

// The launch can clean up nothing then; what its recorder had written is not lost.
TEST_F(StoppingTest, AKilledLaunchLeavesARecordingThatRecoverMends) {
  const auto program =
      launch(recorder("a.mcap") + "  - {node: recorder, name: other, parameters: {output: " +
             scratch_.path("b.mcap") + "}}\n");
  const std::string partial = scratch_.path("a.mcap.partial");
  ASSERT_TRUE(eventually(
      [&] {  // it has written what the nodes say on /log and /statistics
        std::error_code error;
        const auto size = std::filesystem::file_size(partial, error);
        return !error && size > 4000;
      },
      seconds(60)))
      << program->output();
  ::kill(program->pid(), SIGKILL);
  EXPECT_EQ(program->wait(seconds(10)), 128 + SIGKILL);
  ASSERT_TRUE(eventually([&] { return descendants(program->pid(), "recorder").empty(); }));
  EXPECT_FALSE(std::filesystem::exists(scratch_.path("a.mcap")));
  ChildProgram recover("prehend",
                       {"bag", "recover", scratch_.path("a.mcap"), scratch_.path("mended.mcap")},
                       scratch_.path("recover.txt"));
  EXPECT_EQ(recover.wait(seconds(30)), 0) << recover.output();
  EXPECT_THAT(recover.output(), HasSubstr("a.mcap.partial, which its recorder left"));
  const auto check = recording::check_recording(scratch_.path("mended.mcap"));
  EXPECT_THAT(check.problems, IsEmpty());
  EXPECT_GT(check.messages, 0u);
}

// A typing error cost the recording before: the recorder began anew, then the file was missed.
TEST_F(StoppingTest, AMissingFileIsNamedBeforeAnythingIsOverwritten) {
  const std::string before = scratch_.write("a.mcap", "the recording before");
  scratch_.write("scene.mcap", "");
  const auto program = launch(
      recorder("a.mcap") + "  - node: replay\n    required: true\n    parameters:\n      file: " +
      scratch_.path("scnee.mcap") + "\n");
  EXPECT_EQ(program->wait(seconds(30)), 1);
  EXPECT_THAT(program->output(), HasSubstr("a.yaml:6: file of replay: there is no "));
  EXPECT_THAT(program->output(), HasSubstr("did you mean \"scene.mcap\"?"));
  EXPECT_THAT(program->output(), Not(HasSubstr("recording to")));
  EXPECT_EQ(text_of_file(before), "the recording before");
  EXPECT_FALSE(std::filesystem::exists(before + ".partial"));
  ChildProgram check("prehend", {"launch", "--check", scratch_.path("launch/a.yaml")},
                     scratch_.path("check.txt"));
  EXPECT_EQ(check.wait(seconds(30)), 1);
  EXPECT_THAT(check.output(), HasSubstr("there is no "));
}

// What is only found out while the nodes run costs nothing either.
TEST_F(StoppingTest, TheRecordingBeforeIsKept) {
  scratch_.write("a.mcap", "the recording before");
  const auto program = launch(recorder("a.mcap") + node("vital", "after: 0.2, exit: 4",
                                                        "required: true, after: [recorder]"));
  EXPECT_EQ(program->wait(seconds(60)), 1);
  EXPECT_EQ(text_of_file(scratch_.path("a.mcap.1")), "the recording before");
  EXPECT_THAT(recording::check_recording(scratch_.path("a.mcap")).problems, IsEmpty());
}

TEST_F(StoppingTest, AFailureWhileStoppingIsTheLaunchsExitCode) {
  const auto program = launch(node("a", "after: 50, linger: 0.1, exit: 4"));
  ASSERT_TRUE(wait_for_pids(1));
  ::kill(program->pid(), SIGINT);
  EXPECT_EQ(program->wait(seconds(10)), 1);
  EXPECT_THAT(last_lines(*program), HasSubstr("exit code 4 when asked to stop"));
}

// A dead recorder was told in one line that scrolled away; the launch ended with 0.
TEST_F(StoppingTest, WhoDiedOnTheWayIsInTheLastLinesAndTheExitCode) {
  const auto program = launch(recorder("a.mcap") + node("idle", "after: 50", "after: [recorder]"));
  ASSERT_TRUE(wait_for_pids(1));
  const auto recorders = descendants(program->pid(), "recorder");
  ASSERT_EQ(recorders.size(), 1u);
  ::kill(recorders[0], SIGKILL);
  ASSERT_TRUE(program->wait_for_output("the others go on without it"));
  EXPECT_TRUE(is_running(pids()[0]));
  ::kill(program->pid(), SIGINT);
  EXPECT_EQ(program->wait(seconds(10)), 1);
  EXPECT_THAT(last_lines(*program), HasSubstr("error: recorder ended badly once after "));
  EXPECT_THAT(last_lines(*program), HasSubstr("signal SIGKILL"));
}

TEST_F(StoppingTest, ADeathThatWasMendedIsToldAndForgiven) {
  const auto program = launch(node("weak", "after: 50", "respawn: {first_delay: 0.05}"));
  ASSERT_TRUE(wait_for_pids(1));
  ::kill(pids()[0], SIGKILL);
  ASSERT_TRUE(wait_for_pids(2));
  ::kill(program->pid(), SIGINT);
  EXPECT_EQ(program->wait(seconds(10)), 0) << program->output();
  EXPECT_THAT(last_lines(*program), HasSubstr("warning: weak ended badly once after "));
  EXPECT_THAT(last_lines(*program), HasSubstr("signal SIGKILL; it was started again"));
}

}  // namespace
}  // namespace prehend::testing

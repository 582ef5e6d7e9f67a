// The prehend command against a graph in this process.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/recording/mcap_reader.h"
#include "prehend/recording/mcap_writer.h"
#include "tests/tools/command_fixture.h"

namespace prehend::testing {
namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

TEST_F(Command, ListsNodesAndTopics) {
  EXPECT_TRUE(eventually([&] {
    return run({"node", "list"}).output.find("ready") != std::string::npos;
  }));
  EXPECT_THAT(run({"node", "list"}).output, ContainsRegex("arm +arm +[0-9]+ +ready +ok"));
  EXPECT_THAT(
      run({"node", "info", "arm"}).output,
      AllOf(HasSubstr("/camera/stereo  prehend.msgs.StereoPair"), HasSubstr("/gripper/command")));
  EXPECT_THAT(run({"topic", "list"}).output,
              ContainsRegex("/camera/stereo +prehend.msgs.StereoPair +arm +-"));
  const Result unknown = run({"node", "info", "amr"});
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_THAT(unknown.output, HasSubstr("did you mean \"arm\"?"));
}

TEST_F(Command, EchoesMessagesWithoutLongFields) {
  const Result echo = run({"topic", "echo", "/camera/stereo", "-n", "2"});
  EXPECT_EQ(echo.exit_code, 0);
  EXPECT_THAT(echo.output, AllOf(HasSubstr("frame_id: \"left_camera\""), HasSubstr("width: 640"),
                                 HasSubstr("data: <5000 bytes>"), Not(HasSubstr("xxx"))));
  EXPECT_THAT(run({"topic", "echo", "/camera/stereo", "-n", "1", "--full"}).output,
              HasSubstr(std::string(5000, 'x')));
  const Result unknown = run({"topic", "echo", "/camera/stero"});
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_THAT(unknown.output, HasSubstr("/camera/stereo"));
}

TEST_F(Command, MeasuresATopic) {
  const Result result = run({"topic", "hz", "/camera/stereo", "--duration", "1"});
  EXPECT_EQ(result.exit_code, 0);
  const double rate = std::atof(result.output.c_str());
  EXPECT_GT(rate, 10) << result.output;  // a busy machine makes it late
  EXPECT_LT(rate, 130) << result.output;
}

TEST_F(Command, PublishesAMessageFromText) {
  EXPECT_EQ(run({"topic", "pub", "/gripper/command", "mode: VELOCITY value: -0.02"}).exit_code, 0);
  EXPECT_TRUE(eventually([&] { return value_ == -0.02; }));
  const Result wrong = run({"topic", "pub", "/gripper/command", "vlaue: 1"});
  EXPECT_EQ(wrong.exit_code, 1);
  EXPECT_THAT(wrong.output, HasSubstr("is no prehend.msgs.GripperCommand"));
  EXPECT_THAT(run({"topic", "pub", "/gripper/comand", "value: 1"}).output,
              HasSubstr("did you mean \"/gripper/command\"?"));
}

TEST_F(Command, ShowsAndSetsParameters) {
  EXPECT_EQ(run({"param", "get", "arm", "speed"}).output, "1.5\n");
  EXPECT_THAT(run({"param", "list", "arm"}).output, ContainsRegex("speed +1.5 +m/s +1.5"));
  EXPECT_THAT(run({"param", "describe", "arm"}).output,
              AllOf(HasSubstr("allowed: 0 to 10"), HasSubstr("of the arm")));
  EXPECT_EQ(run({"param", "set", "arm", "speed", "3"}).exit_code, 0);
  EXPECT_EQ(node_.parameter<double>("speed"), 3);
  const Result refused = run({"param", "set", "arm", "speed", "30"});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.output, HasSubstr("speed"));
  EXPECT_EQ(node_.parameter<double>("speed"), 3);
}

TEST_F(Command, RecordsForATimeAndSaysWhatIsInside) {
  const std::string file = scratch_.path("a.mcap");
  const Result record = run({"record", "-o", file, "/camera/stereo", "--duration", "0.5"});
  EXPECT_EQ(record.exit_code, 0) << record.output;
  const Result info = run({"bag", "info", file});
  EXPECT_EQ(info.exit_code, 0);
  EXPECT_THAT(info.output,
              ContainsRegex("/camera/stereo +prehend.msgs.StereoPair +[0-9]+ +[0-9.]+ Hz +yes"));
  EXPECT_THAT(info.output, Not(HasSubstr("NOT CLOSED")));
}

TEST_F(Command, RecoversARecordingWithoutItsEnd) {
  const std::string file = scratch_.path("a.mcap");
  {
    recording::McapWriter writer(file);
    const auto channel = writer.add_channel("/a", "raw", 0, {{"key", "value"}});
    for (std::uint64_t i = 1; i <= 100; ++i) writer.write(channel, 1, i, i, "hello");
    writer.close();
  }
  const auto first = recording::McapReader(file).chunks().at(0);
  std::filesystem::resize_file(file, first.chunk_start_offset + first.chunk_length);
  EXPECT_THAT(run({"bag", "info", file}).output, HasSubstr("NOT CLOSED PROPERLY"));
  EXPECT_EQ(run({"bag", "recover", file, scratch_.path("b.mcap")}).exit_code, 0);
  const recording::McapReader mended(scratch_.path("b.mcap"));
  EXPECT_TRUE(mended.complete());
  EXPECT_EQ(mended.statistics().message_count, 100u);
  EXPECT_EQ(mended.channels().begin()->second.metadata.at("key"), "value");
  EXPECT_EQ(run({"bag", "recover", file, scratch_.path("b.mcap")}).exit_code, 1) << "it exists";
}

TEST_F(Command, HelpIsEverywhereAndHasExamples) {
  const std::vector<std::vector<std::string>> commands{{},
                                                       {"launch"},
                                                       {"node", "list"},
                                                       {"node", "info"},
                                                       {"topic", "list"},
                                                       {"topic", "echo"},
                                                       {"topic", "hz"},
                                                       {"topic", "pub"},
                                                       {"service", "list"},
                                                       {"action", "list"},
                                                       {"param", "list"},
                                                       {"param", "get"},
                                                       {"param", "set"},
                                                       {"param", "describe"},
                                                       {"param", "dump"},
                                                       {"param", "load"},
                                                       {"topic", "info"},
                                                       {"topic", "bw"},
                                                       {"topic", "delay"},
                                                       {"service", "call"},
                                                       {"action", "send"},
                                                       {"action", "cancel"},
                                                       {"log"},
                                                       {"graph"},
                                                       {"doctor"},
                                                       {"completion"},
                                                       {"record"},
                                                       {"replay"},
                                                       {"bag", "info"},
                                                       {"bag", "recover"}};
  for (std::vector<std::string> words : commands) {
    words.push_back("--help");
    const Result help = run(words);
    EXPECT_EQ(help.exit_code, 0) << help.output;
    EXPECT_THAT(help.output, HasSubstr("Example"));
  }
}

TEST_F(Command, WrongUseIsExitCodeTwoAndFailureOne) {
  EXPECT_EQ(run({"topik"}).exit_code, 2);
  EXPECT_EQ(run({"topic", "echo"}).exit_code, 2);
  EXPECT_EQ(run({"replay", "none.mcap"}).exit_code, 2);
  const Result none = run({"node", "list", "--registry", "tcp://127.0.0.1:9"});
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.output, AllOf(HasSubstr("tcp://127.0.0.1:9"), HasSubstr("prehend launch")));
}

}  // namespace
}  // namespace prehend::testing

// prehend topic hz, bw, delay, echo, pub; service call; action send and cancel; param dump and
// load.

#include <gmock/gmock.h>
#include <signal.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "tests/tools/command_fixture.h"

namespace prehend::testing {
namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

class Use : public Command {
 protected:
  std::string last_line(const std::string& text) const {
    std::istringstream lines(text);
    std::string line, last;
    while (std::getline(lines, line)) last = line;
    return last;
  }
};

TEST_F(Use, MeasuresRateBandwidthAndDelay) {
  const Result rate = run({"topic", "hz", "/camera/stereo", "-n", "30", "--json"});
  EXPECT_EQ(rate.exit_code, 0) << rate.output;
  const auto report = parsed(last_line(rate.output));
  EXPECT_EQ(member(report, "messages").number_value(), 30);
  EXPECT_GT(member(report, "rate").number_value(), 30);
  EXPECT_LT(member(report, "rate").number_value(), 200);
  const auto intervals = member(report, "interval_seconds");
  EXPECT_EQ(member(intervals, "count").number_value(), 29);
  EXPECT_LE(member(intervals, "minimum").number_value(), member(intervals, "mean").number_value());
  EXPECT_GE(member(intervals, "maximum").number_value(), member(intervals, "mean").number_value());

  const Result bandwidth = run({"topic", "bw", "/camera/stereo", "--duration", "1.2"});
  EXPECT_THAT(bandwidth.output, ContainsRegex("MB/s +message: mean 50[0-9][0-9] "));
  EXPECT_GE(std::count(bandwidth.output.begin(), bandwidth.output.end(), '\n'), 2)
      << "one line a second and one at the end";

  // Messages are stamped half a second back.
  const auto delay =
      parsed(last_line(run({"topic", "delay", "/camera/stereo", "-n", "20", "--json"}).output));
  EXPECT_GE(member(member(delay, "delay_seconds"), "minimum").number_value(), 0.5);
  EXPECT_LT(member(member(delay, "delay_seconds"), "minimum").number_value(), 5);

  EXPECT_EQ(run({"topic", "bw", "/camera/stereo", "--window", "1"}).exit_code, 2);
  EXPECT_EQ(run({"topic", "hz", "/camera/stereo", "-d", "-1"}).exit_code, 2);
  EXPECT_THAT(run({"topic", "delay", "/camera/sterio"}).output, HasSubstr("did you mean"));
}

TEST_F(Use, DelayOfASimulationIsByItsClock) {
  graph::Node world(node_options("world"));
  const auto clock = world.advertise<msgs::Clock>("/clock", graph::QoS::latched(1));
  msgs::Clock time;
  time.set_time(3'000'000'000);
  clock.publish(time);
  const auto wrench = world.advertise<msgs::Wrench>("/wrench", graph::QoS::latched(1));
  msgs::Wrench message;
  message.mutable_header()->set_stamp(2'000'000'000);
  wrench.publish(message);
  ChildProgram program("prehend", {"topic", "delay", "/wrench", "-n", "2", "--json"},
                       scratch_.path("delay.txt"), registry_.endpoint());
  // The clock comes by another way than the message, so a second one, later, counts.
  ASSERT_TRUE(wrench.wait_for_subscribers(1, std::chrono::seconds(10)));
  ASSERT_TRUE(eventually([&] { return clock.subscriber_count() == 1; }));
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  wrench.publish(message);
  EXPECT_EQ(program.wait(std::chrono::seconds(15)), 0);
  const auto delay = member(parsed(last_line(program.output())), "delay_seconds");
  EXPECT_EQ(member(delay, "maximum").number_value(), 1);
}

TEST_F(Use, EchoIsJsonToo) {
  const Result echo = run({"topic", "echo", "/camera/stereo", "-n", "2", "--json"});
  const auto last = parsed(last_line(echo.output));
  EXPECT_EQ(text_of(last, "sender"), "arm");
  EXPECT_EQ(member(member(last, "message"), "width").number_value(), 640);
  EXPECT_EQ(text_of(member(member(last, "message"), "header"), "frame_id"), "left_camera");
}

TEST_F(Use, PublishesJsonAtARateForACount) {
  const Result result = run({"topic", "pub", "/gripper/command",
                             R"({"mode": "VELOCITY", "value": 0.25})", "-r", "200", "-n", "7"});
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_TRUE(eventually([&] { return commands_ == 7; })) << commands_;
  EXPECT_EQ(value_, 0.25);
}

TEST_F(Use, PublishesLatchedForLateSubscribers) {
  ChildProgram publisher(
      "prehend", {"topic", "pub", "/late", "time: 5", "--type", "prehend.msgs.Clock", "--latched"},
      scratch_.path("pub.txt"), registry_.endpoint());
  ASSERT_TRUE(eventually([&] {
    return run({"topic", "list"}).output.find("/late") != std::string::npos;
  }));
  EXPECT_THAT(run({"topic", "echo", "/late", "-n", "1"}).output, HasSubstr("time: 5"));
  ::kill(publisher.pid(), SIGINT);
  EXPECT_EQ(publisher.wait(std::chrono::seconds(5)), 0);
}

TEST_F(Use, WrongMessagesNameThePlaceAndTheNearest) {
  const auto words = [&](const std::string& message) {
    const Result result = run({"topic", "pub", "/gripper/command", message});
    EXPECT_EQ(result.exit_code, 1) << message;
    return result.output;
  };
  EXPECT_THAT(words("mode: VELOCITY\nvlaue: 1"),
              AllOf(HasSubstr("line 2"), HasSubstr("did you mean \"value\"?")));
  EXPECT_THAT(words("mode: VELOCITI"), HasSubstr("did you mean \"VELOCITY\"?"));
  EXPECT_THAT(words("header { frame: 'a' }"), HasSubstr("\"frame_id\""));
  EXPECT_THAT(words(R"({"vlaue": 1})"), HasSubstr("did you mean \"value\"?"));
  EXPECT_THAT(words(R"({"header": {"frameid": "a"}})"), HasSubstr("\"frame_id\""));
  EXPECT_THAT(words(R"({"mode": "VELOCITI"})"), HasSubstr("did you mean \"VELOCITY\"?"));
  EXPECT_THAT(words(R"({"value": )"), HasSubstr("JSON is no prehend.msgs.GripperCommand"));
  EXPECT_THAT(words("value: 'x'"), HasSubstr("text is no prehend.msgs.GripperCommand"));
  EXPECT_THAT(words(std::string(200, '{')), HasSubstr("JSON is no"));
  EXPECT_EQ(commands_, 0);
}

TEST_F(Use, CallsAService) {
  EXPECT_EQ(run({"service", "call", "/add_one", "time: 41"}).output, "time: 42\n");
  EXPECT_EQ(run({"service", "call", "/add_one"}).output, "time: 1\n");
  const Result json = run({"service", "call", "/add_one", R"({"time": 41})", "--json"});
  EXPECT_EQ(text_of(parsed(json.output), "time"), "42");
  const Result failed = run({"service", "call", "/add_one", "time: -1"});
  EXPECT_EQ(failed.exit_code, 1);
  EXPECT_THAT(failed.output, HasSubstr("negative"));
  const Result wrong = run({"service", "call", "/add_one", "tim: 1"});
  EXPECT_EQ(wrong.exit_code, 1);
  EXPECT_THAT(wrong.output, HasSubstr("did you mean \"time\"?"));
  const Result unknown = run({"service", "call", "/ad_one"});
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_THAT(unknown.output, HasSubstr("did you mean \"/add_one\"?"));
  const auto list = parsed(run({"service", "list", "--json"}).output);
  EXPECT_EQ(text_of(element(list, "name", "/add_one"), "node"), "arm");
}

TEST_F(Use, SendsAGoalWithFeedbackAndResult) {
  const Result result = run({"action", "send", "/count", "opening: 3"});
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_THAT(result.output, AllOf(HasSubstr("feedback\nopening: 1\n"), HasSubstr("opening: 2\n"),
                                   HasSubstr("done\nopening: 3\nreached: true")));
  const Result json = run({"action", "send", "/count", R"({"opening": 2})", "--json", "-q"});
  const auto end = parsed(json.output);
  EXPECT_EQ(text_of(end, "status"), "ok");
  EXPECT_EQ(member(member(end, "result"), "opening").number_value(), 2);
  const Result unknown = run({"action", "send", "/cuont"});
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_THAT(unknown.output, HasSubstr("did you mean \"/count\"?"));
  EXPECT_THAT(run({"action", "send", "/count", "openin: 3"}).output, HasSubstr("\"opening\""));
}

TEST_F(Use, InterruptTimeoutAndCancelEndAGoal) {
  {
    ChildProgram send("prehend", {"action", "send", "/count", "opening: -1"},
                      scratch_.path("send.txt"), registry_.endpoint());
    ASSERT_TRUE(send.wait_for_output("opening: 5"));
    ::kill(send.pid(), SIGINT);
    EXPECT_EQ(send.wait(std::chrono::seconds(5)), 1);
    EXPECT_THAT(send.output(),
                AllOf(HasSubstr("cancelling"), ContainsRegex("cancelled.*\nopening")));
  }
  const Result late = run({"action", "send", "/count", "opening: -1", "-q", "--timeout", "0.2"});
  EXPECT_EQ(late.exit_code, 1);
  EXPECT_THAT(late.output, HasSubstr("the time is over"));
  ChildProgram send("prehend", {"action", "send", "/count", "opening: -1"},
                    scratch_.path("send.txt"), registry_.endpoint());
  ASSERT_TRUE(send.wait_for_output("opening: 5"));
  EXPECT_EQ(run({"action", "cancel", "/count"}).exit_code, 0);
  EXPECT_EQ(send.wait(std::chrono::seconds(5)), 1);
  EXPECT_THAT(send.output(), Not(HasSubstr("cancelling")));
  const Result none = run({"action", "cancel", "/count"});
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.output, HasSubstr("has no goal now"));
}

TEST_F(Use, DumpsAndLoadsParameters) {
  const std::string file = scratch_.path("arm.yaml");
  EXPECT_EQ(run({"param", "set", "arm", "speed", "2.5"}).exit_code, 0);
  EXPECT_EQ(run({"param", "dump", "arm", "-o", file}).exit_code, 0);
  EXPECT_THAT(text_of_file(file), HasSubstr("speed: 2.5  # [m/s] of the arm\n"));
  EXPECT_EQ(run({"param", "set", "arm", "speed", "1"}).exit_code, 0);
  EXPECT_EQ(run({"param", "set", "arm", "tool.name", "x"}).exit_code, 0);
  const Result load = run({"param", "load", "arm", file});
  EXPECT_EQ(load.exit_code, 0) << load.output;
  EXPECT_EQ(node_.parameter<double>("speed"), 2.5);
  EXPECT_EQ(node_.parameter<std::string>("tool.name"), "a \"b\": c");

  std::ofstream(file) << "speed: 3\nsped: 4\n";
  const Result unknown = run({"param", "load", "arm", file});
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_THAT(unknown.output, HasSubstr("did you mean \"speed\"?"));
  EXPECT_EQ(node_.parameter<double>("speed"), 2.5) << "nothing of a wrong file is set";
  for (const char* text : {"[1, 2]", "speed: [1]", "a: b: c", "speed: {"}) {
    std::ofstream(file) << text;
    EXPECT_EQ(run({"param", "load", "arm", file}).exit_code, 1) << text;
  }
  const auto list = parsed(run({"param", "list", "arm", "--json"}).output);
  EXPECT_EQ(text_of(element(list, "name", "speed"), "unit"), "m/s");
}

}  // namespace
}  // namespace prehend::testing

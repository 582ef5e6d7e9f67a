// The replay program under control: where it starts and ends, pause and steps, back-pressure.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <mutex>
#include <thread>

#include "msgs/graph.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/graph/clock_control.h"
#include "prehend/graph/node.h"
#include "prehend/graph/registry.h"
#include "prehend/recording/mcap_writer.h"
#include "tests/launch/child_program.h"

namespace prehend::testing {
namespace {

using graph::QoS;
using msgs::graph::ClockControlRequest;
using msgs::graph::ClockControlResponse;
using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kBegin = 1'000'000 * kMs;

// 100 tactile frames, one each 10 ms, and a latched camera model at 0 and at 500 ms.
void write_run(const std::string& path) {
  recording::McapWriter writer(path);
  const auto channel = [&](const std::string& topic, const google::protobuf::Descriptor& type,
                           const std::map<std::string, std::string>& metadata) {
    const auto schema = graph::schema_of(type);
    return writer.add_channel(topic, "protobuf",
                              writer.add_schema(schema->name, "protobuf", schema->descriptor_set),
                              metadata);
  };
  const auto touch = channel("/touch", *msgs::TactileFrame::descriptor(), {});
  const auto camera = channel("/camera", *msgs::CameraInfo::descriptor(), {{"latched", "1"}});
  for (std::uint32_t i = 0; i < 100; ++i) {
    const auto time = static_cast<std::uint64_t>(kBegin + 10 * kMs * i);
    if (i % 50 == 0) {
      msgs::CameraInfo info;
      info.mutable_header()->set_stamp(static_cast<std::int64_t>(time) - 5);
      info.set_fx(500 + i);
      writer.write(camera, i / 50 + 1, time, time, info.SerializeAsString());
    }
    msgs::TactileFrame frame;
    frame.mutable_header()->set_stamp(static_cast<std::int64_t>(time) - 7);
    frame.set_sum(i);
    writer.write(touch, i + 1, time, time, frame.SerializeAsString());
  }
  writer.close();
}

struct Heard {
  std::string topic;
  double value;        // sum, or fx
  std::int64_t stamp;  // of the envelope
};

class ReplayControl : public ::testing::Test {
 protected:
  ReplayControl() { write_run(scratch_.path("a.mcap")); }

  graph::NodeOptions options(const std::string& name) const {
    graph::NodeOptions result;
    result.name = name;
    result.registry = registry_.endpoint();
    result.log_level = graph::LogLevel::kWarning;
    return result;
  }

  template <class Message, class Value>
  graph::Subscription hear(const std::string& topic, const QoS& qos, Value value,
                           milliseconds work = milliseconds(0)) {
    return node_.subscribe<Message>(
        topic, qos, [this, topic, value, work](const graph::Received<Message>& message) {
          std::this_thread::sleep_for(work);
          const std::lock_guard lock(mutex_);
          heard_.push_back({topic, value(*message), message.info().stamp});
        });
  }

  void hear_all(const QoS& qos = QoS::queue(1000), milliseconds work = milliseconds(0)) {
    subscriptions_.push_back(hear<msgs::TactileFrame>(
        "/touch", qos, [](const auto& frame) { return frame.sum(); }, work));
    subscriptions_.push_back(hear<msgs::CameraInfo>(
        "/camera", qos, [](const auto& info) { return info.fx(); }, work));
    subscriptions_.push_back(node_.subscribe<msgs::Clock>(
        "/clock", QoS::queue(10000), [this](const graph::Received<msgs::Clock>& clock) {
          const std::lock_guard lock(mutex_);
          clock_.push_back(clock->time());
        }));
    node_.spin_in_background();
  }

  std::unique_ptr<ChildProgram> start(std::vector<std::string> parameters,
                                      std::vector<std::string> words = {}) {
    parameters.push_back("file:=" + scratch_.path("a.mcap"));
    for (const std::string& parameter : parameters) {
      words.insert(words.end(), {"--param", parameter});
    }
    return std::make_unique<ChildProgram>("replay", words, scratch_.path("replay.txt"),
                                          registry_.endpoint());
  }

  std::vector<Heard> heard() {
    const std::lock_guard lock(mutex_);
    return heard_;
  }
  std::int64_t clock() {
    const std::lock_guard lock(mutex_);
    return clock_.empty() ? 0 : clock_.back();
  }

  ClockControlResponse ask(ClockControlRequest::Command command, std::int64_t step = 0,
                           double speed = 0) {
    ClockControlRequest request;
    request.set_command(command);
    request.set_step(step);
    request.set_speed(speed);
    const auto answer = client_.call(request, seconds(5));
    EXPECT_TRUE(answer.ok()) << answer.error();
    return answer.ok() ? *answer : ClockControlResponse();
  }

  ScratchDirectory scratch_;
  const graph::Registry registry_{graph::RegistryOptions{.endpoint = "tcp://127.0.0.1:*"}};
  std::mutex mutex_;
  std::vector<Heard> heard_;
  std::vector<std::int64_t> clock_;
  graph::Node node_{options("listener")};
  graph::ServiceClient<ClockControlRequest, ClockControlResponse> client_ =
      node_.client<ClockControlRequest, ClockControlResponse>(graph::kClockControlService);
  std::vector<graph::Subscription> subscriptions_;
};

TEST_F(ReplayControl, StartsWithWhatWasLatchedBeforeAndEndsWhereItIsTold) {
  hear_all();
  const auto replay = start({"rate:=0", "start:=0.6", "end:=0.9"});
  EXPECT_EQ(replay->wait(seconds(20)), 0) << replay->output();
  ASSERT_TRUE(eventually([&] { return heard().size() >= 32; })) << replay->output();
  const auto all = heard();
  ASSERT_EQ(all.size(), 32u) << "one camera model, 31 frames";
  EXPECT_EQ(all[0].topic, "/camera");
  EXPECT_EQ(all[0].value, 550) << "the last one before the start";
  EXPECT_EQ(all[0].stamp, kBegin + 500 * kMs - 5) << "its own stamp";
  for (std::size_t i = 1; i < all.size(); ++i) {
    EXPECT_EQ(all[i].value, 59 + static_cast<double>(i));
    EXPECT_EQ(all[i].stamp, kBegin + 10 * kMs * (59 + static_cast<std::int64_t>(i)) - 7);
  }
  EXPECT_EQ(clock_.front(), kBegin + 600 * kMs);
  EXPECT_EQ(clock_.back(), kBegin + 900 * kMs);
}

// A slow reader with room for two messages: as fast as possible means as fast as it can.
TEST_F(ReplayControl, AtRateZeroASlowSubscriberLosesNothing) {
  hear_all(QoS::queue(2), milliseconds(3));
  const auto replay = start({"rate:=0"});
  EXPECT_EQ(replay->wait(seconds(60)), 0) << replay->output();
  ASSERT_TRUE(eventually([&] { return heard().size() >= 102; })) << replay->output();
  std::vector<double> sums;
  for (const Heard& message : heard()) {
    if (message.topic == "/touch") sums.push_back(message.value);
  }
  ASSERT_EQ(sums.size(), 100u);
  for (std::size_t i = 0; i < sums.size(); ++i) EXPECT_EQ(sums[i], static_cast<double>(i));
  for (const auto& subscription : subscriptions_) {
    EXPECT_EQ(subscription.statistics().dropped, 0u) << subscription.topic();
    EXPECT_EQ(subscription.statistics().missed, 0u) << subscription.topic();
  }
}

TEST_F(ReplayControl, BeginsPausedAndStepsExactly) {
  hear_all();
  const auto replay = start({"paused:=true"});
  ASSERT_TRUE(client_.wait_for_server(seconds(10)));
  ASSERT_TRUE(eventually([&] { return clock() == kBegin; })) << replay->output();
  std::this_thread::sleep_for(milliseconds(200));
  EXPECT_LE(heard().size(), 2u) << "only what is due at the beginning itself";
  EXPECT_EQ(clock(), kBegin);
  ASSERT_TRUE(eventually([&] { return ask(ClockControlRequest::STATUS).paused(); }));
  ask(ClockControlRequest::SET_SPEED, 0, 0);
  for (int step = 1; step <= 5; ++step) {
    ask(ClockControlRequest::STEP, 35 * kMs);
    const std::int64_t now = kBegin + 35 * kMs * step;
    ASSERT_TRUE(eventually([&] { return clock() == now; })) << clock() - now;
    EXPECT_TRUE(ask(ClockControlRequest::STATUS).paused());
    const auto expected = static_cast<std::size_t>(35 * step / 10 + 2);  // one is the camera's
    ASSERT_TRUE(eventually([&] { return heard().size() >= expected; }));
    std::this_thread::sleep_for(milliseconds(50));
    EXPECT_EQ(heard().size(), expected) << "step " << step;
  }
  ask(ClockControlRequest::RESUME);
  EXPECT_EQ(replay->wait(seconds(20)), 0) << replay->output();
  EXPECT_TRUE(eventually([&] { return heard().size() == 102; }));
}

TEST_F(ReplayControl, PublishesUnderOtherNamesAndByPattern) {
  std::vector<double> values;
  const auto renamed = node_.subscribe<msgs::TactileFrame>(
      "/felt", QoS::queue(1000), [&](const graph::Received<msgs::TactileFrame>& frame) {
        const std::lock_guard lock(mutex_);
        values.push_back(frame->sum());
      });
  hear_all();
  const auto replay =
      start({"rate:=0", "topics:=/to*", "wait_for_subscribers:=10"}, {"--remap", "/touch:=/felt"});
  EXPECT_EQ(replay->wait(seconds(20)), 0) << replay->output();
  EXPECT_TRUE(eventually([&] {
    const std::lock_guard lock(mutex_);
    return values.size() == 100;
  }));
  EXPECT_TRUE(heard().empty());
}

TEST_F(ReplayControl, LoopsUntilItIsStopped) {
  hear_all();
  const auto replay = start({"rate:=0", "loop:=true", "start:=0.9"});
  EXPECT_TRUE(eventually([&] { return heard().size() > 50; })) << replay->output();
  ::kill(replay->pid(), SIGINT);
  EXPECT_EQ(replay->wait(seconds(10)), 0) << replay->output();
  // Topics have no common order; each by itself begins anew with every turn.
  std::size_t cameras = 0, touches = 0;
  for (const auto& message : heard()) {
    if (message.topic == "/camera") {
      ++cameras;
    } else {
      EXPECT_EQ(message.value, 90 + static_cast<double>(touches++ % 10));
    }
  }
  EXPECT_GE(cameras, touches / 10);  // what was latched comes with each turn
  EXPECT_LE(cameras, touches / 10 + 2);
}

TEST_F(ReplayControl, SaysWhatMakesNoSense) {
  const auto error_of = [&](const std::vector<std::string>& parameters) {
    const auto replay = start(parameters);
    EXPECT_EQ(replay->wait(seconds(10)), 2);
    return replay->output();
  };
  EXPECT_THAT(error_of({"start:=5"}), HasSubstr("beyond the end"));
  EXPECT_THAT(error_of({"start:=0.5", "end:=0.2"}), HasSubstr("later than start"));
  EXPECT_THAT(error_of({"paused:=true", "clock:=false"}), HasSubstr("needs its clock"));
}

// The command that people use.
TEST_F(ReplayControl, IsControlledFromTheCommandLine) {
  hear_all();
  const auto run = [&](std::vector<std::string> words) {
    words.insert(words.begin(), "clock");
    ChildProgram program("prehend", words, scratch_.path("clock.txt"), registry_.endpoint());
    const int code = program.wait(seconds(15)).value_or(-1);
    return std::pair(code, program.output());
  };
  const auto nobody = run({"status"});
  EXPECT_EQ(nobody.first, 1);
  EXPECT_THAT(nobody.second, HasSubstr("a simulation or a replay"));
  const auto replay = start({"paused:=true"});
  ASSERT_TRUE(eventually([&] { return clock() == kBegin; }));
  EXPECT_THAT(run({"status"}).second, HasSubstr("1000.000000000 s, paused, speed 1"));
  EXPECT_THAT(run({"step", "40ms"}).second, HasSubstr("1000.040000000 s, paused"));
  EXPECT_EQ(run({"step", "1e30s"}).first, 1);
  EXPECT_THAT(run({"step", "40"}).second, HasSubstr("one of the units"));
  EXPECT_THAT(run({"speed", "0.001", "--json"}).second, HasSubstr("\"speed\": 0.001"));
  EXPECT_THAT(run({"resume"}).second, HasSubstr("running"));
  EXPECT_THAT(run({"step", "1ms"}).second, HasSubstr("pause it before"));
  EXPECT_THAT(run({"pause"}).second, HasSubstr("paused"));
}

}  // namespace
}  // namespace prehend::testing

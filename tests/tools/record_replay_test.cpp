// The recorder and replay programs against nodes of this process.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "msgs/sensors.pb.h"
#include "prehend/graph/introspection.h"
#include "prehend/graph/node.h"
#include "prehend/graph/registry.h"
#include "prehend/recording/mcap_reader.h"
#include "prehend/recording/mcap_writer.h"
#include "tests/launch/child_program.h"

namespace prehend::testing {
namespace {

using graph::QoS;
using recording::McapReader;
using std::chrono::seconds;
using ::testing::HasSubstr;

struct Sample {
  std::string bytes;
  std::int64_t stamp = 0;
};
using Samples = std::map<std::string, std::vector<Sample>>;

graph::NodeOptions options_of(const graph::Registry& registry, const std::string& name) {
  graph::NodeOptions options;
  options.name = name;
  options.registry = registry.endpoint();
  options.log_level = graph::LogLevel::kWarning;
  return options;
}

graph::RegistryOptions any_port() {
  graph::RegistryOptions options;
  options.endpoint = "tcp://127.0.0.1:*";
  return options;
}

msgs::TactileFrame frame_of(int i) {
  msgs::TactileFrame frame;
  frame.mutable_header()->set_stamp(1000000LL * i);
  frame.mutable_header()->set_frame_id("left_pad");
  frame.set_sum(0.5 * i);
  for (int texel = 0; texel < 84; ++texel)
    frame.add_intensity(static_cast<std::uint32_t>(i + texel));
  return frame;
}

// Publishes 3000 tactile frames, 20 stereo pairs of 1 MB and one latched camera model, and stops
// the recorder at once after the last.
void record_run(const std::string& path, const std::vector<std::string>& more, Samples& sent,
                std::string& words) {
  const graph::Registry registry(any_port());
  graph::Node node(options_of(registry, "source"));
  const auto touch = node.advertise<msgs::TactileFrame>("/touch", QoS::queue(5000));
  const auto stereo = node.advertise<msgs::StereoPair>("/stereo", QoS::queue(100));
  const auto camera = node.advertise<msgs::CameraInfo>("/camera", QoS::latched(1));
  node.spin_in_background();
  msgs::CameraInfo info;
  info.set_fx(500);
  info.set_baseline(0.1);
  camera.publish(info);
  sent["/camera"].push_back({info.SerializeAsString(), 0});

  std::vector<std::string> arguments{"--param", "output:=" + path};
  arguments.insert(arguments.end(), more.begin(), more.end());
  ChildProgram recorder("recorder", arguments, path + ".txt", registry.endpoint());
  ASSERT_TRUE(touch.wait_for_subscribers(1, seconds(10)));
  ASSERT_TRUE(stereo.wait_for_subscribers(1, seconds(10)));
  ASSERT_TRUE(camera.wait_for_subscribers(1, seconds(10)));
  for (int i = 1; i <= 3000; ++i) {
    const auto frame = frame_of(i);
    touch.publish(frame);
    sent["/touch"].push_back({frame.SerializeAsString(), frame.header().stamp()});
    if (i % 150 != 0) continue;
    msgs::StereoPair pair;
    pair.mutable_header()->set_stamp(1000000LL * i + 1);
    pair.set_width(static_cast<std::uint32_t>(i));
    pair.set_data(std::string(1000000, static_cast<char>(i)));
    stereo.publish(pair);
    sent["/stereo"].push_back({pair.SerializeAsString(), pair.header().stamp()});
  }
  ::kill(recorder.pid(), SIGINT);
  EXPECT_EQ(recorder.wait(seconds(20)), 0) << recorder.output();
  words = recorder.output();
}

// Sizes and checksums: what a failure prints stays readable.
std::vector<std::pair<std::size_t, std::size_t>> digests_of(const std::vector<Sample>& samples) {
  std::vector<std::pair<std::size_t, std::size_t>> all;
  for (const Sample& sample : samples) {
    all.emplace_back(sample.bytes.size(), std::hash<std::string>()(sample.bytes));
  }
  return all;
}

TEST(Recorder, LosesNothingOfWhatWasPublishedBeforeItWasStopped) {
  const ScratchDirectory scratch;
  Samples sent;
  std::string words;
  record_run(scratch.path("a.mcap"),
             {"--param", "attachment:=" + scratch.write("launch.yaml", "nodes: []\n")}, sent,
             words);
  McapReader reader(scratch.path("a.mcap"));
  EXPECT_TRUE(reader.complete());
  Samples found;
  std::map<std::string, std::uint32_t> sequences;
  auto cursor = reader.messages();
  while (const auto message = cursor.next()) {
    const std::string topic = reader.channels().at(message->channel_id).topic;
    found[topic].push_back({std::string(message->data), 0});
    EXPECT_EQ(message->sequence, ++sequences[topic]) << topic;
  }
  EXPECT_TRUE(reader.problems().empty());
  for (const auto& [topic, samples] : sent) {
    EXPECT_EQ(digests_of(found[topic]), digests_of(samples)) << topic;
  }
  for (const auto& [id, channel] : reader.channels()) {
    EXPECT_EQ(channel.metadata.count("latched") > 0,
              channel.topic == "/camera" || channel.topic == "/log" ||
                  channel.topic == "/diagnostics" || channel.topic == "/statistics")
        << channel.topic;
  }
  ASSERT_EQ(reader.attachments().size(), 1u);
  EXPECT_EQ(reader.read_attachment(reader.attachments()[0]).data, "nodes: []\n");
  EXPECT_THAT(words, HasSubstr("/touch: 3000 messages"));
  EXPECT_THAT(words, HasSubstr("/stereo: 20 messages, 20.00 MB"));
}

TEST(Recorder, SaysWhyItCannotWrite) {
  const ScratchDirectory scratch;
  const graph::Registry registry(any_port());
  ChildProgram recorder("recorder", {"--param", "output:=/dev/full"}, scratch.path("out.txt"),
                        registry.endpoint());
  EXPECT_EQ(recorder.wait(seconds(10)), 1);
  EXPECT_THAT(recorder.output(),
              HasSubstr("cannot record to /dev/full: there is something that is no file"));
}

// What a subscriber in a graph of its own gets from a replay.
struct Heard {
  Samples samples;
  std::vector<std::int64_t> clock;
  std::string words;
};

// Waits until `expected` messages and the end of the clock have come, but not for ever.
Heard hear_replay(const ScratchDirectory& scratch, const std::vector<std::string>& parameters,
                  std::size_t expected, bool with_clock = true) {
  const auto end =
      static_cast<std::int64_t>(McapReader(scratch.path("a.mcap")).statistics().message_end_time);
  const graph::Registry registry(any_port());
  graph::Node node(options_of(registry, "listener"));
  Heard heard;
  std::mutex mutex;
  std::vector<graph::Subscription> subscriptions;
  for (const char* topic : {"/touch", "/stereo", "/camera"}) {
    subscriptions.push_back(
        node.subscribe_raw(topic, QoS::queue(10000), [&, topic](const graph::RawMessage& message) {
          const std::lock_guard lock(mutex);
          heard.samples[topic].push_back({message.bytes, message.info.stamp});
        }));
  }
  subscriptions.push_back(node.subscribe<msgs::Clock>(
      "/clock", QoS::queue(100000), [&](const graph::Received<msgs::Clock>& message) {
        const std::lock_guard lock(mutex);
        heard.clock.push_back(message->time());
      }));
  node.spin_in_background();
  std::vector<std::string> arguments{"--param", "file:=" + scratch.path("a.mcap")};
  for (const std::string& parameter : parameters) {
    arguments.insert(arguments.end(), {"--param", parameter});
  }
  ChildProgram replay("replay", arguments, scratch.path("replay.txt"), registry.endpoint());
  EXPECT_EQ(replay.wait(seconds(30)), 0) << replay.output();
  // What it has sent before it ended may be on its way still.
  const auto have_all = [&] {
    const std::lock_guard lock(mutex);
    std::size_t count = 0;
    for (const auto& [topic, samples] : heard.samples) count += samples.size();
    return count >= expected &&
           (!with_clock || (!heard.clock.empty() && heard.clock.back() == end));
  };
  eventually(have_all, seconds(5));
  subscriptions.clear();
  heard.words = replay.output();
  return heard;
}

TEST(Replay, PublishesTheSameMessagesWithTheSameStampsAndTheClock) {
  const ScratchDirectory scratch;
  Samples sent;
  std::string words;
  record_run(scratch.path("a.mcap"), {"--param", "topics:=/touch /stereo /camera"}, sent, words);
  for (const char* rate : {"rate:=0", "rate:=2"}) {
    const Heard heard = hear_replay(scratch, {rate}, 3021);
    for (const auto& [topic, samples] : sent) {
      ASSERT_EQ(heard.samples.count(topic), 1u) << topic << heard.words;
      const auto& got = heard.samples.at(topic);
      ASSERT_EQ(got.size(), samples.size()) << topic << "\n" << heard.words;
      ASSERT_EQ(digests_of(got), digests_of(samples)) << topic;
      for (std::size_t i = 0; i < got.size() && samples[i].stamp != 0; ++i) {
        ASSERT_EQ(got[i].stamp, samples[i].stamp) << topic;
      }
    }
    McapReader reader(scratch.path("a.mcap"));
    ASSERT_FALSE(heard.clock.empty());
    EXPECT_TRUE(std::is_sorted(heard.clock.begin(), heard.clock.end()));
    EXPECT_GE(heard.clock.front(),
              static_cast<std::int64_t>(reader.statistics().message_start_time));
    EXPECT_EQ(heard.clock.back(), static_cast<std::int64_t>(reader.statistics().message_end_time));
  }
  const Heard filtered =
      hear_replay(scratch, {"rate:=0", "topics:=/camera", "clock:=false"}, 1, false);
  EXPECT_EQ(filtered.samples.size(), 1u);
  EXPECT_EQ(filtered.samples.count("/camera"), 1u);
  EXPECT_TRUE(filtered.clock.empty());
}

// A recording of 0.6 s with a recorded /clock of its own.
void write_timed_recording(const std::string& path) {
  const auto clock_schema = graph::schema_of(*msgs::Clock::descriptor());
  const auto touch_schema = graph::schema_of(*msgs::TactileFrame::descriptor());
  recording::McapWriter writer(path);
  const auto clock = writer.add_channel(
      "/clock", "protobuf",
      writer.add_schema(clock_schema->name, "protobuf", clock_schema->descriptor_set));
  const auto touch = writer.add_channel(
      "/touch", "protobuf",
      writer.add_schema(touch_schema->name, "protobuf", touch_schema->descriptor_set));
  for (std::uint32_t i = 1; i <= 60; ++i) {
    const std::uint64_t time = 10'000'000ull * i;
    msgs::Clock now;
    now.set_time(static_cast<std::int64_t>(time));
    writer.write(clock, i, time, time, now.SerializeAsString());
    writer.write(touch, i, time, time, frame_of(static_cast<int>(i)).SerializeAsString());
  }
  writer.close();
}

TEST(Replay, KeepsToItsRateAndStartAndMakesTheClockOnce) {
  const ScratchDirectory scratch;
  write_timed_recording(scratch.path("a.mcap"));
  const auto begin = std::chrono::steady_clock::now();
  const Heard heard = hear_replay(scratch, {"rate:=0.5", "start:=0.1", "topics:=/touch"}, 50);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  EXPECT_GE(elapsed.count(), 0.98) << "0.49 s of recording at half speed";
  EXPECT_EQ(heard.samples.at("/touch").size(), 50u);
  EXPECT_TRUE(std::is_sorted(heard.clock.begin(), heard.clock.end()));
  EXPECT_EQ(heard.clock.back(), 600'000'000);
  EXPECT_LT(heard.clock.size(), 1000u);
}

TEST(Replay, SaysWhatIsWrongWithFileTopicAndRate) {
  const ScratchDirectory scratch;
  write_timed_recording(scratch.path("a.mcap"));
  scratch.write("no.mcap", "not a recording");
  const graph::Registry registry(any_port());
  const auto error_of = [&](const std::vector<std::string>& arguments) {
    ChildProgram replay("replay", arguments, scratch.path("out.txt"), registry.endpoint());
    EXPECT_THAT(replay.wait(seconds(10)), ::testing::AnyOf(1, 2));
    return replay.output();
  };
  const std::string file = "file:=" + scratch.path("a.mcap");
  EXPECT_THAT(error_of({"--param", file, "--param", "topics:=/tuoch"}), HasSubstr("\"/touch\""));
  EXPECT_THAT(error_of({"--param", "file:=" + scratch.path("no.mcap")}),
              HasSubstr("not an MCAP recording"));
  EXPECT_THAT(error_of({"--param", "file:=" + scratch.path("none.mcap")}),
              HasSubstr("No such file"));
  EXPECT_THAT(error_of({"--param", file, "--param", "rate:=-1"}), HasSubstr("rate"));
  EXPECT_THAT(error_of({}), HasSubstr("file:=FILE.mcap"));
}

// `prehend replay FILE` of the docs failed: no registry answered.
TEST(Replay, BringsARegistryWhereNoneIsAndTakesItAway) {
  const ScratchDirectory scratch;
  write_timed_recording(scratch.path("a.mcap"));
  const std::string endpoint = "ipc://" + scratch.path("registry");
  ChildProgram replay("prehend", {"replay", scratch.path("a.mcap"), "--wait", "0", "--hold"},
                      scratch.path("replay.txt"), endpoint);
  ASSERT_TRUE(replay.wait_for_output("replayed 60 messages")) << replay.output();
  EXPECT_THAT(replay.output(), HasSubstr("starting a registry at " + endpoint));
  EXPECT_EQ(graph::Introspection(endpoint).nodes().size(), 1u);
  ::kill(replay.pid(), SIGINT);
  EXPECT_EQ(replay.wait(seconds(5)), 0);
  EXPECT_TRUE(eventually([&] {
    try {
      graph::Introspection(endpoint, std::chrono::milliseconds(100)).nodes();
      return false;
    } catch (const std::runtime_error&) {
      return true;
    }
  }));
}

TEST(Replay, HoldsTheLastMessagesForLateSubscribers) {
  const ScratchDirectory scratch;
  write_timed_recording(scratch.path("a.mcap"));
  const graph::Registry registry(any_port());
  ChildProgram replay("replay",
                      {"--param", "file:=" + scratch.path("a.mcap"), "--param", "hold:=true",
                       "--param", "rate:=0", "--param", "wait_for_subscribers:=0"},
                      scratch.path("replay.txt"), registry.endpoint());
  ASSERT_TRUE(replay.wait_for_output("replayed 60 messages"));
  graph::Node node(options_of(registry, "late"));
  std::atomic<std::int64_t> stamp{0};
  const auto subscription = node.subscribe<msgs::TactileFrame>(
      "/touch", QoS::queue(10),
      [&](const graph::Received<msgs::TactileFrame>& frame) { stamp = frame->header().stamp(); });
  node.spin_in_background();
  EXPECT_TRUE(eventually([&] { return stamp == 60'000'000; })) << stamp;
  ::kill(replay.pid(), SIGINT);
  EXPECT_EQ(replay.wait(seconds(5)), 0);
}

}  // namespace
}  // namespace prehend::testing

// The recorder program where it is hard: a publisher that does not stop, parts, full disks.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <filesystem>
#include <map>
#include <set>
#include <thread>

#include "msgs/graph.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/graph/node.h"
#include "prehend/graph/registry.h"
#include "prehend/recording/mcap_reader.h"
#include "prehend/recording/recording_check.h"
#include "tests/launch/child_program.h"

namespace prehend::testing {
namespace {

using graph::QoS;
using recording::McapReader;
using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class Recorder : public ::testing::Test {
 protected:
  graph::NodeOptions options(const std::string& name) const {
    graph::NodeOptions result;
    result.name = name;
    result.registry = registry_.endpoint();
    result.log_level = graph::LogLevel::kError;
    return result;
  }

  static std::vector<std::string> parameters(const std::vector<std::string>& all) {
    std::vector<std::string> words;
    for (const std::string& one : all) words.insert(words.end(), {"--param", one});
    return words;
  }

  // Numbers of the messages on /touch in a recording, the repeated ones of a part left out.
  static std::vector<int> numbers_in(const std::string& file) {
    McapReader reader(file);
    std::vector<int> numbers;
    auto cursor = reader.messages({{"/touch"}});
    while (const auto message = cursor.next()) {
      msgs::TactileFrame frame;
      EXPECT_TRUE(frame.ParseFromArray(message->data.data(), int(message->data.size())));
      numbers.push_back(static_cast<int>(frame.sum()));
    }
    EXPECT_THAT(reader.problems(), IsEmpty());
    return numbers;
  }

  static msgs::TactileFrame frame_of(int number, int texels = 84) {
    msgs::TactileFrame frame;
    frame.mutable_header()->set_stamp(number);
    frame.set_sum(number);
    for (int i = 0; i < texels; ++i)
      frame.add_intensity(static_cast<std::uint32_t>(number * 7919 + i));
    return frame;
  }

  ScratchDirectory scratch_;
  const graph::Registry registry_{graph::RegistryOptions{.endpoint = "tcp://127.0.0.1:*"}};
  graph::Node node_{options("source")};
  graph::Publisher<msgs::TactileFrame> touch_ =
      node_.advertise<msgs::TactileFrame>("/touch", QoS::queue(100000));
};

TEST_F(Recorder, StoppedWhileAFastPublisherGoesOnHasAllFromBeforeTheSignal) {
  node_.spin_in_background();
  ChildProgram recorder("recorder", parameters({"output:=" + scratch_.path("a.mcap")}),
                        scratch_.path("a.txt"), registry_.endpoint());
  ASSERT_TRUE(touch_.wait_for_subscribers(1, seconds(10)));
  std::atomic<int> published{0};
  std::atomic<bool> stop{false};
  std::thread publisher([&] {
    while (!stop) {
      for (int i = 0; i < 20; ++i) {
        touch_.publish(frame_of(published + 1));
        ++published;
      }
      std::this_thread::sleep_for(milliseconds(2));
    }
  });
  std::this_thread::sleep_for(milliseconds(700));
  const int before = published;
  ::kill(recorder.pid(), SIGINT);
  EXPECT_EQ(recorder.wait(seconds(60)), 0) << recorder.output();
  stop = true;
  publisher.join();
  const auto numbers = numbers_in(scratch_.path("a.mcap"));
  EXPECT_GE(numbers.size(), static_cast<std::size_t>(before)) << recorder.output();
  for (std::size_t i = 0; i < numbers.size(); ++i) ASSERT_EQ(numbers[i], static_cast<int>(i) + 1);
  EXPECT_THAT(recording::check_recording(scratch_.path("a.mcap")).problems, IsEmpty());
}

TEST_F(Recorder, PartsHoldEveryMessageOnceAndSayWhatTheyAreOf) {
  const auto camera = node_.advertise<msgs::CameraInfo>("/camera", QoS::latched(1));
  node_.spin_in_background();
  msgs::CameraInfo info;
  info.set_fx(500);
  camera.publish(info);
  const std::string calibration = scratch_.write("cali bration.yaml", "fx: 500\n");
  ::setenv("PREHEND_LAUNCH_FILE", scratch_.write("launch.yaml", "nodes: []\n").c_str(), 1);
  ChildProgram recorder(
      "recorder",
      parameters({"output:=" + scratch_.path("a.mcap"), "split_size:=64000", "compression:=none",
                  "topics:=/touch /cam*", "attachment:=\"" + calibration + "\""}),
      scratch_.path("a.txt"), registry_.endpoint());
  ::unsetenv("PREHEND_LAUNCH_FILE");
  ASSERT_TRUE(touch_.wait_for_subscribers(1, seconds(10)));
  ASSERT_TRUE(camera.wait_for_subscribers(1, seconds(10)));
  constexpr int kCount = 2000;
  for (int i = 1; i <= kCount; ++i) touch_.publish(frame_of(i));
  ::kill(recorder.pid(), SIGINT);
  EXPECT_EQ(recorder.wait(seconds(30)), 0) << recorder.output();
  std::vector<int> all;
  std::size_t parts = 0;
  const auto part = [&] { return scratch_.path(fmt::format("a_{:04}.mcap", parts)); };
  for (; std::filesystem::exists(part()) && parts < 1000; ++parts) {
    const std::string file = part();
    EXPECT_THAT(recording::check_recording(file).problems, IsEmpty()) << file;
    const auto numbers = numbers_in(file);
    all.insert(all.end(), numbers.begin(), numbers.end());
    McapReader reader(file);
    std::set<std::string> attached;
    for (const auto& index : reader.attachments()) attached.insert(index.name);
    EXPECT_EQ(attached, (std::set<std::string>{"cali bration.yaml", "launch.yaml"})) << file;
    auto cameras = reader.messages({{"/camera"}});
    EXPECT_TRUE(cameras.next()) << "the latched model is in " << file;
    std::map<std::string, std::string> facts;
    for (const auto& item : reader.metadata()) {
      if (item.name == "prehend.run") facts = item.entries;
      EXPECT_NE(item.name, "prehend.losses") << "nothing is missing";
    }
    EXPECT_THAT(facts["command_line"], HasSubstr("output:=" + scratch_.path("a.mcap")));
    EXPECT_EQ(facts["working_directory"], std::filesystem::current_path().string());
  }
  EXPECT_GE(parts, 3u) << recorder.output();
  ASSERT_EQ(all.size(), static_cast<std::size_t>(kCount)) << recorder.output();
  for (int i = 0; i < kCount; ++i) ASSERT_EQ(all[static_cast<std::size_t>(i)], i + 1);
}

TEST_F(Recorder, AMissingAttachmentIsSaidAtOnce) {
  node_.spin_in_background();
  ChildProgram recorder(
      "recorder",
      parameters({"output:=" + scratch_.path("a.mcap"), "attachment:=" + scratch_.path("no.yaml")}),
      scratch_.path("a.txt"), registry_.endpoint());
  EXPECT_EQ(recorder.wait(seconds(10)), 1);
  EXPECT_THAT(recorder.output(), AllOf(HasSubstr("no.yaml"), HasSubstr("No such file")));
}

// A stopped recorder's queues overflow in the publisher; what is missing is told for each topic.
TEST_F(Recorder, CountsWhatIsMissing) {
  const auto small = node_.advertise<msgs::TactileFrame>("/small", QoS::queue(10, 20'000));
  node_.spin_in_background();
  ChildProgram recorder("recorder", parameters({"output:=" + scratch_.path("a.mcap")}),
                        scratch_.path("a.txt"), registry_.endpoint());
  ASSERT_TRUE(small.wait_for_subscribers(1, seconds(10)));
  small.publish(frame_of(1));  // from here on the recorder counts
  ASSERT_TRUE(node_.wait_until_delivered(seconds(10)));
  ::kill(recorder.pid(), SIGSTOP);
  for (int i = 2; i <= 30'000; ++i) {
    small.publish(frame_of(i));
    if (i % 200 == 0) std::this_thread::sleep_for(milliseconds(1));
  }
  ::kill(recorder.pid(), SIGCONT);
  std::this_thread::sleep_for(milliseconds(300));
  small.publish(frame_of(30'001));  // shows that some are missing before it
  ::kill(recorder.pid(), SIGINT);
  EXPECT_EQ(recorder.wait(seconds(30)), 0) << recorder.output();
  McapReader reader(scratch_.path("a.mcap"));
  std::uint64_t recorded = 0;
  std::uint32_t last = 0;
  auto cursor = reader.messages({{"/small"}});
  while (const auto message = cursor.next()) {
    ++recorded;
    EXPECT_GT(message->sequence, last);
    last = message->sequence;
  }
  EXPECT_EQ(last, 30'001u) << "sequence numbers count what is missing, too";
  ASSERT_LT(recorded, 30'001u) << "the test has to lose something";
  const std::string lost = std::to_string(30'001 - recorded) + " lost (";
  EXPECT_THAT(recorder.output(), HasSubstr(lost));
  std::string told;
  for (const auto& item : reader.metadata()) {
    if (item.name == "prehend.losses") told = item.entries.at("/small");
  }
  EXPECT_THAT(told,
              AllOf(HasSubstr(lost), HasSubstr(std::to_string(30'001 - recorded) + " of source")));
}

// What a recorder says and leaves whose disk fills up after some of many messages.
class FullDisk : public Recorder {
 protected:
  void fill(ChildProgram& recorder, const std::string& file, const std::string& reason) {
    std::atomic<bool> reported{false};
    const auto diagnostics = node_.subscribe<msgs::graph::Diagnostic>(
        "/diagnostics", QoS::queue(100),
        [&](const graph::Received<msgs::graph::Diagnostic>& diagnostic) {
          if (diagnostic->node() == "recorder" &&
              diagnostic->level() == msgs::graph::HEALTH_ERROR &&
              diagnostic->text().find(reason) != std::string::npos) {
            reported = true;
          }
        });
    node_.spin_in_background();
    ASSERT_TRUE(touch_.wait_for_subscribers(1, seconds(10)));
    for (int i = 1; i <= 1000 && is_running(recorder.pid()); ++i) {
      touch_.publish(frame_of(i, 2000));
      std::this_thread::sleep_for(milliseconds(1));
    }
    EXPECT_EQ(recorder.wait(seconds(20)), 1) << recorder.output();
    EXPECT_THAT(recorder.output(),
                AllOf(HasSubstr(reason), HasSubstr(file), HasSubstr("were not recorded")));
    EXPECT_TRUE(eventually([&] { return reported.load(); })) << "on /diagnostics";
    EXPECT_FALSE(std::filesystem::exists(file)) << "it is not whole";
    McapReader reader(file + ".partial");
    EXPECT_FALSE(reader.complete());
    auto cursor = reader.messages({{"/touch"}});
    int count = 0;
    while (const auto message = cursor.next()) ++count;
    EXPECT_GT(count, 10) << "what was written before can be read";
    EXPECT_LT(count, 1000);
    ChildProgram recover("prehend", {"bag", "recover", file, scratch_.path("mended.mcap")},
                         scratch_.path("recover.txt"));
    EXPECT_EQ(recover.wait(seconds(20)), 0) << recover.output();
    EXPECT_EQ(numbers_in(scratch_.path("mended.mcap")).size(), static_cast<std::size_t>(count));
    EXPECT_THAT(recording::check_recording(scratch_.path("mended.mcap")).problems, IsEmpty());
  }
};

TEST_F(FullDisk, StopsTheRecordingWithAClearErrorAndLeavesItReadable) {
  const std::string disk = scratch_.path("disk");
  std::filesystem::create_directory(disk);
  if (::mount("tmpfs", disk.c_str(), "tmpfs", 0, "size=2m") != 0) {
    ASSERT_EQ(errno, EPERM);
    GTEST_SKIP() << "mounting a small file system needs root (EPERM); AFileAtTheSizeLimitIsTheSame "
                    "shows the same for everybody";
  }
  const std::string file = disk + "/a.mcap";
  {
    ChildProgram recorder("recorder", parameters({"output:=" + file, "compression:=none"}),
                          scratch_.path("a.txt"), registry_.endpoint());
    fill(recorder, file, "No space left on device");
  }
  EXPECT_EQ(::umount(disk.c_str()), 0);
}

TEST_F(FullDisk, AFileAtTheSizeLimitIsTheSame) {
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit limit{2'000'000, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
  const std::string file = scratch_.path("a.mcap");
  ChildProgram recorder("recorder", parameters({"output:=" + file, "compression:=none"}),
                        scratch_.path("a.txt"), registry_.endpoint());
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  fill(recorder, file, "File too large");
}

}  // namespace
}  // namespace prehend::testing

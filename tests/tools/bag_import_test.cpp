// prehend bag import.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "msgs/camera.pb.h"
#include "msgs/joints.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/recording/latched_messages.h"
#include "prehend/recording/mcap_reader.h"
#include "tests/launch/child_program.h"
#include "tests/recording/ros_test_files.h"

namespace prehend::testing {
namespace {

using recording::BagBytes;
using recording::RosBytes;
using ::testing::HasSubstr;

const std::string kDepth = "/camera/depth/image_rect", kColor = "/camera/color/image";
const std::string kInfo = "/camera/depth/camera_info";
const std::string kLeft = "/left/image", kRight = "/right/image";

std::string image(std::uint32_t seconds, const std::string& encoding,
                  const std::vector<std::uint8_t>& row, std::uint32_t nanoseconds = 0) {
  RosBytes bytes(false);
  bytes.header(seconds, nanoseconds, "cam").number(std::uint32_t{1}).number(std::uint32_t{1});
  bytes.text(encoding);
  bytes.number(std::uint8_t{0}).number(static_cast<std::uint32_t>(row.size())).list(row);
  return bytes.bytes();
}

std::string info(double baseline) {
  RosBytes bytes(false);
  bytes.header(0, 0, "cam").number(std::uint32_t{1}).number(std::uint32_t{1}).text("plumb_bob");
  bytes.list<double>({}).array<double>({50, 0, 0, 0, 50, 0, 0, 0, 1});
  bytes.array(std::vector<double>(9));
  bytes.array<double>({50, 0, 0, -50 * baseline, 0, 50, 0, 0, 0, 0, 1, 0});
  return bytes.number(std::uint32_t{0}).number(std::uint32_t{0}).bytes();
}

class BagImport : public ::testing::Test {
 protected:
  BagImport() {
    const std::string image_text =
        "Header header\n" + recording::kImageFields + recording::kStampedHeader;
    const std::string info_text =
        "Header header\n" + recording::kCameraFields + recording::kStampedHeader;
    std::uint32_t id = 0;
    for (const std::string& topic : {kDepth, kColor, kLeft, kRight})
      bag_.connection(id++, topic, "sensor_msgs/Image", image_text);
    for (const std::string& topic :
         {kInfo, std::string("/left/camera_info"), std::string("/right/camera_info")})
      bag_.connection(id++, topic, "sensor_msgs/CameraInfo", info_text);
    bag_.connection(id++, "/joint_states", "sensor_msgs/JointState", recording::kJointState);
    bag_.connection(id++, "/chatter", "std_msgs/String", "string data\n");
    for (std::uint32_t n = 0; n < 3; ++n) {
      bag_.message(0, n, image(n, "16UC1", {0xE8, 3}));
      if (n != 1) bag_.message(1, n, image(n, "rgb8", {1, 2, 3}));
      bag_.message(2, n, image(n, "mono8", {1}));
      if (n != 1) bag_.message(3, n, image(n, "mono8", {2}));
      bag_.message(4, n, info(0));
      bag_.message(5, n, info(0));
      bag_.message(6, n, info(0.1));
      bag_.message(7, n, recording::joint_state(false, n));
      bag_.message(8, n, RosBytes(false).text("hello").bytes());
    }
    bag_.chunk("lz4");
    scratch_.write("a.bag", bag_.file());
  }

  /// What `prehend bag import` says; `code_` is its exit code.
  std::string import(std::vector<std::string> words, const std::string& from = "a.bag") {
    words.insert(words.begin(), {"bag", "import", scratch_.path(from), to_});
    ChildProgram program("prehend", words, scratch_.path("out.txt"));
    code_ = program.wait(std::chrono::seconds(30)).value_or(-1);
    return program.output();
  }

  template <class Message>
  std::vector<Message> messages(const std::string& topic) {
    recording::McapReader reader(to_);
    auto cursor = reader.messages({{topic}});
    std::vector<Message> found;
    while (const auto raw = cursor.next()) {
      found.emplace_back();
      EXPECT_TRUE(
          found.back().ParseFromArray(raw->data.data(), static_cast<int>(raw->data.size())));
    }
    return found;
  }

  ScratchDirectory scratch_;
  BagBytes bag_;
  const std::string to_ = scratch_.path("a.mcap");
  int code_ = -1;
};

TEST_F(BagImport, AllThatPrehendHasToo) {
  const std::string output = import({});
  EXPECT_EQ(code_, 0) << output;
  EXPECT_THAT(output, HasSubstr("/chatter: left out, as prehend has nothing like std_msgs/String"));
  EXPECT_EQ(messages<msgs::DepthImage>(kDepth).size(), 3u);
  EXPECT_EQ(messages<msgs::Image>(kLeft).size(), 3u);
  const auto joints = messages<msgs::JointState>("/joint_states");
  ASSERT_EQ(joints.size(), 3u);
  EXPECT_EQ(joints[2].position(0), 2);
  import({});
  EXPECT_EQ(code_, 1) << "it exists";
}

TEST_F(BagImport, DepthWithTheColoursOfItsInstant) {
  const std::string output = import({"--depth", kDepth, "--color", kColor});
  EXPECT_EQ(code_, 0) << output;
  EXPECT_THAT(output, HasSubstr("2 of 3 depth images have colours"));
  const auto depth = messages<msgs::DepthImage>("/camera/depth");
  ASSERT_EQ(depth.size(), 3u);
  EXPECT_EQ(depth[0].data(), std::string("\xE8\3\1\2\3"));
  EXPECT_FALSE(depth[1].has_color());
  EXPECT_EQ(messages<msgs::CameraInfo>("/camera/info").size(), 1u);
  EXPECT_TRUE(messages<msgs::JointState>("/joint_states").empty());
  recording::McapReader reader(to_);
  for (const auto& [id, channel] : reader.channels()) {
    EXPECT_EQ(recording::latched_depth(channel), channel.topic == "/camera/info" ? 1u : 0u);
  }
}

// At 30 frames a second the colours of the frame before are within 50 ms, too.
TEST_F(BagImport, TheNearestColoursAreTaken) {
  constexpr std::uint32_t kFrame = 33'000'000;  // ns
  bag_.message(1, 9, image(9, "rgb8", {1, 1, 1}, 0));
  bag_.message(0, 9, image(9, "16UC1", {0xE8, 3}, kFrame));
  bag_.message(1, 9, image(9, "rgb8", {2, 2, 2}, kFrame + 1'000'000));
  bag_.message(1, 9, image(9, "rgb8", {3, 3, 3}, 2 * kFrame));
  bag_.message(0, 9, image(9, "16UC1", {0xE8, 3}, 2 * kFrame));
  bag_.chunk("none");
  scratch_.write("b.bag", bag_.file());
  import({"--depth", kDepth, "--color", kColor}, "b.bag");
  EXPECT_EQ(code_, 0);
  const auto depth = messages<msgs::DepthImage>("/camera/depth");
  ASSERT_EQ(depth.size(), 5u);
  EXPECT_EQ(depth[3].data(), std::string("\xE8\3\2\2\2"));
  EXPECT_EQ(depth[4].data(), std::string("\xE8\3\3\3\3"));
}

TEST_F(BagImport, StereoPairsWithTheRightCamerasBaseline) {
  const std::string output = import({"--stereo", kLeft, kRight, "--topics", "/joint*"});
  EXPECT_EQ(code_, 0) << output;
  EXPECT_THAT(output, HasSubstr("1 images without a partner"));
  EXPECT_EQ(messages<msgs::StereoPair>("/camera/stereo").size(), 2u);
  const auto camera = messages<msgs::CameraInfo>("/camera/info");
  ASSERT_EQ(camera.size(), 1u);
  EXPECT_DOUBLE_EQ(camera[0].baseline(), 0.1);
  EXPECT_EQ(messages<msgs::JointState>("/joint_states").size(), 3u);
}

TEST_F(BagImport, WhatDoesNotFitIsNamedAndLeavesNothing) {
  EXPECT_THAT(import({"--depth", "/camera/depth/image_rec"}), HasSubstr("did you mean"));
  EXPECT_EQ(code_, 1);
  EXPECT_THAT(import({"--depth", kLeft}), HasSubstr("has no depth"));
  EXPECT_THAT(import({"--stereo", kRight, kLeft}), HasSubstr("no baseline"));
  EXPECT_THAT(import({"--topics", "/chatter"}), HasSubstr("no message that prehend has"));
  EXPECT_THAT(import({"--color", kColor}), HasSubstr("--depth"));
  EXPECT_THAT(import({}, "out.txt"), HasSubstr("nor is it a bag of ROS 1"));
  for (const auto& entry : std::filesystem::directory_iterator(scratch_.path(""))) {
    EXPECT_EQ(entry.path().string().find("mcap"), std::string::npos) << entry.path();
  }
}

TEST_F(BagImport, HarmedMessagesAreToldAndTheOthersTaken) {
  bag_.message(7, 9, "harmed");
  bag_.chunk("none");
  scratch_.write("b.bag", bag_.file());
  EXPECT_THAT(import({}, "b.bag"), HasSubstr("/joint_states: the message ends too early"));
  EXPECT_EQ(code_, 1);
  EXPECT_EQ(messages<msgs::JointState>("/joint_states").size(), 3u);
}

}  // namespace
}  // namespace prehend::testing

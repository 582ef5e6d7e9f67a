// prehend bag convert, and prehend record --foxglove.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "foxglove/CompressedImage.pb.h"
#include "foxglove/FrameTransforms.pb.h"
#include "foxglove/RawImage.pb.h"
#include "foxglove/SceneUpdate.pb.h"
#include "msgs/convert/geometry.h"
#include "msgs/graph.pb.h"
#include "msgs/joints.pb.h"
#include "msgs/objects.pb.h"
#include "msgs/sensors.pb.h"
#include "msgs/views/compressed_images.h"
#include "prehend/geometry/errors.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/graph/node.h"
#include "prehend/graph/registry.h"
#include "prehend/recording/latched_messages.h"
#include "prehend/recording/mcap_reader.h"
#include "prehend/recording/mcap_writer.h"
#include "prehend/recording/protobuf_schema.h"
#include "tests/launch/child_program.h"

namespace prehend::testing {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr std::uint64_t kSecond = 1'000'000'000;

msgs::ObjectModel box_model(std::uint32_t id) {
  msgs::ObjectModel model;
  model.mutable_header()->set_stamp(kSecond);
  model.set_id(id);
  model.set_object_count(1);
  *model.mutable_mesh() = convert::to_message(geometry::make_box({0.1, 0.1, 0.1}));
  return model;
}

msgs::StereoPair small_pair() {
  msgs::StereoPair pair;
  pair.set_width(8);
  pair.set_height(4);
  pair.set_channels(3);
  pair.set_data(std::string(2 * 8 * 4 * 3, '\x40'));
  return pair;
}

/// A recording of `kTopics`, message by message.
class Written {
 public:
  explicit Written(const std::string& path) : writer_(path) {}
  void write(const std::string& topic, std::uint64_t time,
             const google::protobuf::Message& message) {
    write(topic, time, *message.GetDescriptor(), message.SerializeAsString());
  }
  void write(const std::string& topic, std::uint64_t time, const google::protobuf::Descriptor& type,
             const std::string& bytes) {
    const auto [found, is_new] = channels_.try_emplace(topic);
    if (is_new) {
      const auto schema =
          writer_.add_schema(type.full_name(), "protobuf", recording::file_descriptor_set(type));
      found->second = writer_.add_channel(topic, "protobuf", schema);
    }
    writer_.write(found->second, 1, time, time, bytes);
  }
  void close() { writer_.close(); }

 private:
  recording::McapWriter writer_;
  std::map<std::string, std::uint16_t> channels_;
};

class BagConvert : public ::testing::Test {
 protected:
  void SetUp() override {
    Written file(scratch_.path("a.mcap"));
    msgs::JointState joints;
    joints.add_name("axis_1");
    joints.add_position(0.3);
    for (std::uint64_t i = 0; i < 100; ++i) {  // 100 Hz
      file.write("/joint_states", kSecond + i * kSecond / 100, joints);
    }
    file.write("/models", 2 * kSecond, box_model(0));
    file.write("/camera/stereo", 2 * kSecond, small_pair());
    msgs::TactileFrame frame;
    frame.set_rows(1);
    frame.set_columns(2);
    frame.add_intensity(7);
    frame.add_intensity(8);
    file.write("/tactile/left", 2 * kSecond, frame);
    // What an earlier conversion has made, and what is of a type that it says it is not.
    file.write("/viewer/objects", 2 * kSecond, ::foxglove::SceneUpdate());
    file.write("/plans", 2 * kSecond, msgs::TactileFrame());
    file.close();
  }

  /// What `prehend bag convert` says; `code_` is its exit code.
  std::string convert(const std::string& from, const std::string& to,
                      const std::vector<std::string>& options = {}) {
    std::vector<std::string> words{"bag", "convert", scratch_.path(from), scratch_.path(to)};
    words.insert(words.end(), options.begin(), options.end());
    ChildProgram program("prehend", words, scratch_.path("out.txt"));
    code_ = program.wait(std::chrono::seconds(30)).value_or(-1);
    return program.output();
  }

  template <class Message>
  std::vector<Message> messages(const std::string& file, const std::string& topic) {
    recording::McapReader reader(scratch_.path(file));
    auto cursor = reader.messages({{topic}});
    std::vector<Message> found;
    while (const auto raw = cursor.next()) {
      times_.push_back(raw->publish_time);
      const auto* schema = reader.schema_of(reader.channels().at(raw->channel_id));
      EXPECT_EQ(schema->name, Message::descriptor()->full_name());
      found.emplace_back();
      EXPECT_TRUE(found.back().ParseFromArray(raw->data.data(), int(raw->data.size())));
    }
    return found;
  }

  std::vector<std::string> topics(const std::string& file) {
    recording::McapReader reader(scratch_.path(file));
    std::vector<std::string> found;
    for (const auto& [id, channel] : reader.channels()) found.push_back(channel.topic);
    return found;
  }

  ScratchDirectory scratch_;
  int code_ = -1;
  std::vector<std::uint64_t> times_;
};

TEST_F(BagConvert, ShowsWhatItKnowsAndKeepsTheRest) {
  const std::string said = convert("a.mcap", "b.mcap", {"--platform", "kr5_sdh"});
  EXPECT_EQ(code_, 1) << "a message was no plan: " << said;
  EXPECT_THAT(said, HasSubstr("problem: A message on /plans"));
  EXPECT_EQ(messages<msgs::JointState>("b.mcap", "/joint_states").size(), 100);
  const auto objects = messages<::foxglove::SceneUpdate>("b.mcap", "/viewer/objects");
  ASSERT_EQ(objects.size(), 1) << "that of before is made anew";
  ASSERT_EQ(objects.front().entities_size(), 1);
  EXPECT_EQ(objects.front().entities(0).id(), "object/0");
  EXPECT_EQ(messages<::foxglove::RawImage>("b.mcap", "/viewer/pad/left").size(), 1);
  times_.clear();
  const auto robot = messages<::foxglove::SceneUpdate>("b.mcap", "/viewer/robot");
  ASSERT_EQ(robot.size(), 1);
  EXPECT_GT(robot.front().entities_size(), 6);
  EXPECT_EQ(times_.front(), kSecond) << "it is there from the first message on";
}

// A second of joints at 100 Hz: frames by the time of the recording, however fast it is read.
TEST_F(BagConvert, FramesComeByTheRecordingsTime) {
  convert("a.mcap", "b.mcap", {"--platform", "kr5_sdh"});
  const auto frames = messages<::foxglove::FrameTransforms>("b.mcap", "/viewer/frames");
  EXPECT_GE(frames.size(), 30);
  EXPECT_LE(frames.size(), 40);
  EXPECT_GT(frames.front().transforms_size(), 6);
  for (std::size_t i = 1; i < times_.size(); ++i) EXPECT_GT(times_[i], times_[i - 1]);
}

TEST_F(BagConvert, PicturesAsTheyAreWanted) {
  for (const std::string format : {"jpeg", "png"}) {
    convert("a.mcap", format, {"--images", format});
    const auto pictures = messages<::foxglove::CompressedImage>(format, "/viewer/image/left");
    ASSERT_EQ(pictures.size(), 1);
    EXPECT_EQ(pictures.front().format(), format);
    EXPECT_EQ(pictures.front().data().substr(0, 2), format == "png" ? "\x89P" : "\xFF\xD8");
  }
  convert("a.mcap", "raw", {"--images", "raw"});
  EXPECT_EQ(messages<::foxglove::RawImage>("raw", "/viewer/image/left").front().data().size(), 96);
  convert("a.mcap", "none", {"--images", "none"});
  EXPECT_THAT(topics("none"), AllOf(Contains("/viewer/objects"), Contains("/camera/stereo"),
                                    Not(Contains("/viewer/image/left"))));
}

// The public reader and the public schemas: what a viewer of others makes of it.
TEST_F(BagConvert, IsWhatThePublicPackagesKnow) {
  const std::string folder = "tests/recording/npm";
  for (const char* package : {"@mcap/core", "@foxglove/schemas", "protobufjs"}) {
    if (!std::filesystem::exists(folder + "/node_modules/" + package)) {
      GTEST_SKIP() << "the npm packages are missing: run npm ci in " << folder;
    }
  }
  for (const std::string images : {"jpeg", "raw"}) {
    convert("a.mcap", images, {"--platform", "kr5_sdh", "--images", images});
    const std::string command =
        "timeout 30 node " + folder + "/check.cjs views " + scratch_.path(images) + " 2>&1";
    FILE* pipe = ::popen(command.c_str(), "r");
    std::array<char, 4096> buffer{};
    std::string said;
    while (const std::size_t got = std::fread(buffer.data(), 1, buffer.size(), pipe)) {
      said.append(buffer.data(), got);
    }
    EXPECT_EQ(::pclose(pipe), 0) << said;
    for (const char* topic : {"/viewer/objects", "/viewer/image/left", "/viewer/robot"}) {
      EXPECT_THAT(said, HasSubstr(std::string("\"") + topic + "\":1"));
    }
  }
}

TEST_F(BagConvert, OnlyViewsLeavesTheRestOut) {
  const std::string said = convert("a.mcap", "b.mcap", {"--only-views"});
  EXPECT_THAT(said, HasSubstr("the robot is not drawn: give it by --platform"));
  for (const std::string& topic : topics("b.mcap")) EXPECT_THAT(topic, HasSubstr("/viewer/"));
}

TEST_F(BagConvert, WhatItCannotDoIsSaidAndLeavesNoFile) {
  EXPECT_THAT(convert("a.mcap", "b.mcap", {"--platform", "kr5_sdj"}),
              HasSubstr("The nearest is 'kr5_sdh'"));
  EXPECT_EQ(code_, 1);
  EXPECT_THAT(convert("none.mcap", "b.mcap"), HasSubstr("none.mcap: No such file"));
  EXPECT_THAT(convert("a.mcap", "b.mcap", {"--robots", "."}), HasSubstr("--platform"));
  EXPECT_THAT(convert("a.mcap", "b.mcap", {"--images", "gif"}), HasSubstr("gif"));
  EXPECT_EQ(code_, 2);
  EXPECT_THAT(convert("a.mcap", "a.mcap"), HasSubstr("a.mcap exists; give a new file"));
  Written empty(scratch_.path("empty.mcap"));
  empty.write("/wrench", kSecond, msgs::Wrench());
  empty.close();
  EXPECT_THAT(convert("empty.mcap", "b.mcap"), HasSubstr("has nothing that viewers draw"));
  for (const auto& entry : std::filesystem::directory_iterator(scratch_.path(""))) {
    EXPECT_THAT(entry.path().filename().string(), Not(HasSubstr("b.mcap")));
  }
}

TEST_F(BagConvert, ARecorderShowsWhatItRecords) {
  const graph::Registry registry{graph::RegistryOptions{.endpoint = "tcp://127.0.0.1:*"}};
  graph::NodeOptions options;
  options.name = "source";
  options.registry = registry.endpoint();
  graph::Node node(options);
  auto models = node.advertise<msgs::ObjectModel>("/models", graph::QoS::latched(1));
  node.spin_in_background();
  const std::string file = scratch_.path("live.mcap");
  const auto record = [&](std::vector<std::string> words) {
    words.insert(words.begin(),
                 {"record", "-o", file, "--duration", "1.5", "--registry", registry.endpoint()});
    return words;
  };
  {
    ChildProgram recorder("prehend", record({"--foxglove", "--platform", "kr5_sdh"}),
                          scratch_.path("r.txt"));
    ASSERT_TRUE(models.wait_for_subscribers(1, std::chrono::seconds(10)));
    models.publish(box_model(0));
    EXPECT_EQ(recorder.wait(std::chrono::seconds(30)), 0) << recorder.output();
  }
  EXPECT_EQ(messages<::foxglove::SceneUpdate>("live.mcap", "/viewer/objects").size(), 1);
  EXPECT_EQ(messages<::foxglove::SceneUpdate>("live.mcap", "/viewer/robot").size(), 1);
  EXPECT_EQ(messages<msgs::ObjectModel>("live.mcap", "/models").size(), 1);
  ChildProgram refused("prehend", record({"--platform", "kr5_sdh"}), scratch_.path("x.txt"));
  EXPECT_NE(refused.wait(std::chrono::seconds(30)), 0);
  EXPECT_THAT(refused.output(), HasSubstr("--foxglove"));
}

TEST(CompressedImages, RefuseWhatDoesNotFit) {
  ::foxglove::RawImage image;
  image.set_encoding("rgb8");
  image.set_width(4);
  image.set_height(2);
  image.set_step(12);
  image.set_data(std::string(24, 'a'));
  EXPECT_EQ(views::compressed_image(image, views::PictureFormat::kPng).format(), "png");
  image.set_data("short");
  EXPECT_THROW(views::compressed_image(image, views::PictureFormat::kPng), geometry::InputError);
  image.set_data(std::string(24, 'a'));
  image.set_step(0xFFFFFFFF);
  EXPECT_THROW(views::compressed_image(image, views::PictureFormat::kJpeg), geometry::InputError);
  image.set_width(0);
  EXPECT_THROW(views::compressed_image(image, views::PictureFormat::kJpeg), geometry::InputError);
  image.set_encoding("32FC1");
  EXPECT_THROW(views::compressed_image(image, views::PictureFormat::kPng), geometry::InputError);
}

}  // namespace
}  // namespace prehend::testing

// Bags of ROS 1, MCAP files of ROS 2, and the messages in them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/recording/mcap_writer.h"
#include "prehend/recording/ros_recording.h"
#include "tests/recording/recording_test_files.h"
#include "tests/recording/ros_test_files.h"

namespace prehend::recording {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

void expect_joints(const RosValue& message, double first) {
  EXPECT_EQ(message["header"]["frame_id"].text(), "base");
  EXPECT_EQ(message["header"]["stamp"]["sec"].integer(), 100);
  EXPECT_EQ(message["header"]["stamp"]["nanosec"].integer(), 5);
  ASSERT_EQ(message["name"].list().size(), 2u);
  EXPECT_EQ(message["name"].list()[1].text(), "bcd");
  EXPECT_THAT(message["position"].numbers(), ElementsAre(first, -2));
  EXPECT_THAT(message["velocity"].numbers(), IsEmpty());
  EXPECT_THAT(message["effort"].numbers(), ElementsAre(0.5, 0.25));
}

std::string bag(const std::string& compression) {
  BagBytes bag;
  bag.connection(3, "/joint_states", "sensor_msgs/JointState", kJointState);
  bag.message(3, 100, joint_state(false, 1.5));
  bag.chunk(compression);
  bag.message(3, 101, joint_state(false, 2.5));
  bag.chunk(compression);
  return bag.file();
}

class RosFile : public testing::Test {
 protected:
  std::string write(const std::string& bytes) {
    const std::string path = folder_.file("a.bag");
    write_file(path, bytes);
    return path;
  }
  static std::vector<double> first_positions(RosRecording& recording) {
    std::vector<double> found;
    while (const auto message = recording.next()) {
      found.push_back(message->read()["position"].numbers().front());
    }
    return found;
  }
  TemporaryFolder folder_;
};

TEST_F(RosFile, BagsOfEachCompressionAreRead) {
  for (const char* compression : {"none", "bz2", "lz4"}) {
    SCOPED_TRACE(compression);
    RosRecording recording(write(bag(compression)));
    const auto first = recording.next();
    ASSERT_TRUE(first);
    EXPECT_EQ(first->topic, "/joint_states");
    EXPECT_EQ(first->type, "sensor_msgs/JointState");
    EXPECT_EQ(first->time, 100'000'000'005u);
    expect_joints(first->read(), 1.5);
    const auto second = recording.next();
    ASSERT_TRUE(second);
    expect_joints(second->read(), 2.5);
    EXPECT_FALSE(recording.next());
    EXPECT_THAT(recording.problems(), IsEmpty());
  }
}

TEST_F(RosFile, McapOfRos2IsRead) {
  const std::string path = folder_.file("a.mcap");
  {
    McapWriter writer(path);
    const auto schema = writer.add_schema("sensor_msgs/msg/JointState", "ros2msg", kJointState2);
    const auto channel = writer.add_channel("/joint_states", "cdr", schema);
    writer.write(channel, 1, 7, 7, joint_state(true, 1.5));
    const auto other = writer.add_schema("a/msg/B", "ros2idl", "module a {}");
    writer.write(writer.add_channel("/idl", "cdr", other), 1, 8, 8, "");
    writer.close();
  }
  RosRecording recording(path);
  const auto message = recording.next();
  ASSERT_TRUE(message);
  EXPECT_EQ(message->type, "sensor_msgs/JointState");
  EXPECT_EQ(message->time, 7u);
  expect_joints(message->read(), 1.5);
  EXPECT_FALSE(recording.next());
  EXPECT_THAT(recording.problems(), ElementsAre(HasSubstr("/idl: schemas of encoding 'ros2idl'")));
}

TEST_F(RosFile, WhatIsCutOffOrDamagedIsSaidAndTheRestRead) {
  const std::string whole = bag("lz4");
  {
    RosRecording recording(write(whole.substr(0, whole.size() - 10)));
    EXPECT_THAT(first_positions(recording), ElementsAre(1.5));
    EXPECT_THAT(recording.problems(), ElementsAre(HasSubstr("the file ends within a record")));
  }
  std::string damaged = whole;
  damaged[damaged.find("compression=lz4") + 60] ^= 0x55;  // within the first chunk
  RosRecording recording(write(damaged));
  EXPECT_LE(first_positions(recording).size(), 1u);
  EXPECT_FALSE(recording.problems().empty());
}

TEST_F(RosFile, OtherFilesAreRefusedByName) {
  EXPECT_THAT([&] { RosRecording recording(write("no recording at all")); },
              testing::ThrowsMessage<McapError>(HasSubstr("nor is it a bag of ROS 1")));
  EXPECT_THAT([&] { RosRecording recording(write("#ROSBAG V1.2\n")); },
              testing::ThrowsMessage<McapError>(HasSubstr("rosbag fix")));
  EXPECT_THROW(RosRecording(folder_.file("none.bag")), McapError);
}

TEST(RosMessage, AlignmentOfCdrIsThatOfEachNumber) {
  const RosType type("a/msg/B",
                     "uint8 one\nfloat64 two\nuint8 three\nint16[] four\nint8[3] five\n"
                     "C[] six\nstring<=5 seven\nuint8 LIMIT=3\nfloat32 eight 1.5\n"
                     "====\nMSG: a/C\nbool x\nint64 y\n");
  RosBytes bytes(true);
  bytes.number(std::uint8_t{1}).number(2.0).number(std::uint8_t{3});
  bytes.list<std::int16_t>({-4, 4}).array<std::int8_t>({-1, 0, 1}).number(std::uint32_t{2});
  for (const std::int64_t y : {std::int64_t{-9}, std::int64_t{9}}) {
    bytes.number(std::uint8_t{1}).number(y);
  }
  bytes.text("abc").number(8.5F);
  const RosValue value = type.read(bytes.bytes(), RosEncoding::kCdr);
  EXPECT_EQ(value["one"].integer(), 1);
  EXPECT_EQ(value["two"].number(), 2);
  EXPECT_THAT(value["four"].numbers(), ElementsAre(-4, 4));
  EXPECT_THAT(value["five"].numbers(), ElementsAre(-1, 0, 1));
  EXPECT_EQ(value["six"].list()[1]["y"].integer(), 9);
  EXPECT_EQ(value["seven"].text(), "abc");
  EXPECT_EQ(value["eight"].number(), 8.5);
  EXPECT_FALSE(value.has("LIMIT"));
  EXPECT_THROW(value["nine"], RosError);
}

TEST(RosMessage, EveryCutIsRefused) {
  const RosType type("sensor_msgs/JointState", kJointState);
  const std::string whole = joint_state(false, 1.5);
  for (std::size_t length = 0; length < whole.size(); ++length) {
    EXPECT_THROW(type.read(std::string_view(whole).substr(0, length), RosEncoding::kRos1), RosError)
        << length;
  }
  std::string long_list = whole;
  long_list.replace(long_list.find("base") + 4, 4, "\xff\xff\xff\xff");
  EXPECT_THROW(type.read(long_list, RosEncoding::kRos1), RosError);
}

TEST(RosMessage, BadDefinitionsAreRefused) {
  EXPECT_THROW(RosType("a/B", "Unknown x\n"), RosError);
  EXPECT_THROW(RosType("a/B", "B x\n"), RosError) << "contains itself";
  EXPECT_THROW(RosType("a/B", "int32\n"), RosError);
  EXPECT_THROW(RosType("a/B", "int32[0] x\n"), RosError);
  EXPECT_THROW(RosType("a/B", "int32[-1] x\n"), RosError);
  EXPECT_THROW(RosType("a/B", "wstring x\n"), RosError);
}

TEST(RosMessage, BigEndianIsRefused) {
  const RosType type("a/B", "uint32 x\n");
  EXPECT_THROW(type.read(std::string("\0\0\0\0\0\0\0\1", 8), RosEncoding::kCdr), RosError);
  EXPECT_EQ(type.read(std::string("\0\1\0\0\1\0\0\0", 8), RosEncoding::kCdr)["x"].integer(), 1);
}

// Written by ROS's own rosbag: what the fuzz target begins with.
TEST(RosBag, BagsOfRosItselfAreRead) {
  for (const char* compression : {"none", "bz2", "lz4"}) {
    SCOPED_TRACE(compression);
    RosRecording recording(std::string("tests/fuzz/corpus/ros_recording/") + compression);
    const auto message = recording.next();
    ASSERT_TRUE(message);
    EXPECT_EQ(message->topic, "/j");
    EXPECT_EQ(message->type, "sensor_msgs/JointState");
    EXPECT_EQ(message->time, 1'000'000'000u);
    const RosValue joints = message->read();
    ASSERT_EQ(joints["name"].list().size(), 1u);
    EXPECT_EQ(joints["name"].list()[0].text(), "a");
    EXPECT_THAT(joints["position"].numbers(), ElementsAre(1));
    while (const auto other = recording.next()) EXPECT_NO_THROW(other->read());
    EXPECT_THAT(recording.problems(), IsEmpty());
  }
}

}  // namespace
}  // namespace prehend::recording

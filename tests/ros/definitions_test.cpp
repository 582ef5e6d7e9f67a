// Types of ROS: their definitions, names and sums; messages written by them.

#include "msgs/ros/definitions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "msgs/ros/to_ros.h"
#include "tests/recording/ros_test_files.h"

namespace prehend::ros {
namespace {

using recording::RosBytes;
using recording::RosEncoding;
using recording::RosError;
using recording::RosType;
using recording::RosValue;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;
using Fields = RosValue::Fields;

// As the packages of ROS 1 noetic have them (rosmsg md5).
TEST(RosDefinitions, SumsAreThoseOfRos) {
  EXPECT_EQ(md5_sum("std_msgs/Header"), "2176decaecbce78abc3b96ef049fabed");
  EXPECT_EQ(md5_sum("sensor_msgs/PointCloud2"), "1158d486dd51d683ce2f1be655c3c181");
  EXPECT_EQ(md5_sum("sensor_msgs/Image"), "060021388200f6f0f447d0fcd9c64743");
  EXPECT_EQ(md5_sum("sensor_msgs/CompressedImage"), "8f7a12909da2c9d3332d540a0977563f");
  EXPECT_EQ(md5_sum("sensor_msgs/CameraInfo"), "c9a58c1b0b154e0e6da7578cb991d214");
  EXPECT_EQ(md5_sum("sensor_msgs/JointState"), "3066dcd76a6cfaef579bd0f34173e9fd");
  EXPECT_EQ(md5_sum("geometry_msgs/WrenchStamped"), "d78d3cb249ce23087ade7e7d0c40cfa7");
  EXPECT_EQ(md5_sum("tf2_msgs/TFMessage"), "94810edda583a504dfda3829e70d7eec");
  EXPECT_EQ(md5_sum("rosgraph_msgs/Log"), "acffd30cd6b6de30f120938c17c593fb");
  EXPECT_EQ(md5_sum("rosgraph_msgs/Clock"), "a9c97c1d230cfc112e270351a944ee47");
  EXPECT_EQ(md5_sum("actionlib_msgs/GoalStatusArray"), "8b2b82f13216d0a8ea88bd3af735e619");
  EXPECT_EQ(md5_sum("control_msgs/FollowJointTrajectoryActionGoal"),
            "cff5c1d533bf2f82dd0138d57f4304bb");
  EXPECT_EQ(md5_sum("control_msgs/FollowJointTrajectoryActionResult"),
            "c4fb3b000dc9da4fd99699380efcc5d9");
}

TEST(RosDefinitions, EveryTypeCanBeReadAndWrittenEmpty) {
  for (const Version version : {Version::kRos1, Version::kRos2}) {
    for (const std::string& name : message_types(version)) {
      const RosType& type = type_of(name, version);
      const std::string bytes = type.write(RosValue(Fields{}), encoding_of(version));
      EXPECT_NO_THROW(type.read(bytes, encoding_of(version))) << name;
      // Nothing is missing, and nothing too much.
      EXPECT_THROW(type.read(bytes.substr(0, bytes.size() - 1), encoding_of(version)), RosError)
          << name;
    }
  }
  EXPECT_THAT([] { definition("sensor_msgs/Imu", Version::kRos2); },
              ThrowsMessage<RosError>(HasSubstr("sensor_msgs/Imu")));
}

TEST(RosDefinitions, NamesOfDds) {
  EXPECT_EQ(dds_type_name("sensor_msgs/Image"), "sensor_msgs::msg::dds_::Image_");
  EXPECT_EQ(dds_type_name("control_msgs/FollowJointTrajectory_SendGoal_Request"),
            "control_msgs::action::dds_::FollowJointTrajectory_SendGoal_Request_");
  EXPECT_EQ(dds_type_name("action_msgs/CancelGoal_Response"),
            "action_msgs::srv::dds_::CancelGoal_Response_");
  EXPECT_EQ(dds_type_name("action_msgs/GoalStatusArray"),
            "action_msgs::msg::dds_::GoalStatusArray_");
}

TEST(RosWriting, BytesAreThoseOfTheEncodings) {
  const std::vector<double> positions{1.5, -2.5};
  const std::vector<std::string> names{"a", "bcd"};
  const RosValue message(Fields{{"header", ros_header(7'000'000'009, "odd", Version::kRos2)},
                                {"name", ros_texts(names)},
                                {"position", ros_numbers(positions.data(), positions.size())}});
  RosBytes cdr(true);
  cdr.header(7, 9, "odd").number(std::uint32_t{2}).text("a").text("bcd").list(positions);
  cdr.number(std::uint32_t{0}).number(std::uint32_t{0});
  EXPECT_EQ(type_of("sensor_msgs/JointState", Version::kRos2).write(message, RosEncoding::kCdr),
            cdr.bytes());
  RosBytes packed(false);
  packed.number(std::uint32_t{0}).number(std::uint32_t{7}).number(std::uint32_t{9}).text("odd");
  packed.number(std::uint32_t{2}).text("a").text("bcd").list(positions);
  packed.number(std::uint32_t{0}).number(std::uint32_t{0});
  EXPECT_EQ(type_of("sensor_msgs/JointState", Version::kRos1).write(message, RosEncoding::kRos1),
            packed.bytes());
}

TEST(RosWriting, WhatDoesNotFitIsNamed) {
  const RosType type("p/T",
                     "uint8 small\nint16 signed\nuint8[3] three\nfloat64[] many\n"
                     "time when\nstring text\n");
  const auto error_of = [&](const char* field, RosValue value) {
    try {
      type.write(RosValue(Fields{{field, std::move(value)}}), RosEncoding::kRos1);
    } catch (const RosError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(error_of("small", ros_integer(255)), "");
  EXPECT_THAT(error_of("small", ros_integer(256)), HasSubstr("p/T.small"));
  EXPECT_THAT(error_of("small", ros_integer(-1)), HasSubstr("range"));
  EXPECT_EQ(error_of("signed", ros_integer(-32768)), "");
  EXPECT_THAT(error_of("signed", ros_integer(-32769)), HasSubstr("range"));
  EXPECT_THAT(error_of("smal", ros_integer(1)), HasSubstr("has no field 'smal'"));
  EXPECT_THAT(error_of("three", ros_bytes("ab")), HasSubstr("2 values instead of 3"));
  EXPECT_THAT(error_of("many", ros_bytes("ab")), HasSubstr("another kind"));
  EXPECT_THAT(error_of("text", ros_integer(1)), HasSubstr("no text"));
  EXPECT_THAT(error_of("when", RosValue(Fields{{"sec", ros_integer(1)}})), HasSubstr("nanosec"));
}

TEST(RosWriting, LargestWholeNumbersStay) {
  const RosType type("p/T", "uint64 u\nint64 i\n");
  const std::uint64_t most = std::numeric_limits<std::uint64_t>::max();
  const std::string bytes =
      type.write(RosValue(Fields{{"u", RosValue(most)},
                                 {"i", ros_integer(std::numeric_limits<std::int64_t>::min())}}),
                 RosEncoding::kRos1);
  const RosValue read = type.read(bytes, RosEncoding::kRos1);
  EXPECT_EQ(std::get<std::uint64_t>(read["u"].content()), most);
  EXPECT_EQ(read["i"].integer(), std::numeric_limits<std::int64_t>::min());
  EXPECT_THROW(type.write(RosValue(Fields{{"i", RosValue(most)}}), RosEncoding::kRos1), RosError);
}

}  // namespace
}  // namespace prehend::ros

// Messages of prehend as ROS has them, and back.

#include "msgs/ros/to_ros.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "foxglove/FrameTransforms.pb.h"
#include "foxglove/Log.pb.h"
#include "foxglove/PointCloud.pb.h"
#include "foxglove/RawImage.pb.h"
#include "msgs/convert/geometry.h"
#include "msgs/graph.pb.h"
#include "msgs/joints.pb.h"
#include "msgs/ros/from_ros.h"
#include "msgs/sensors.pb.h"
#include "prehend/geometry/errors.h"

namespace prehend::ros {
namespace {

using geometry::InputError;
using testing::ElementsAre;
using testing::HasSubstr;

class InBothVersions : public testing::TestWithParam<Version> {
 protected:
  template <class Message>
  std::unique_ptr<google::protobuf::Message> there_and_back(const Message& message,
                                                            const std::string& type) {
    bytes_ = to_ros(message, type, GetParam());
    return from_ros(type, type_of(type, GetParam()).read(bytes_, encoding_of(GetParam())));
  }
  recording::RosValue read(const std::string& type) {
    return type_of(type, GetParam()).read(bytes_, encoding_of(GetParam()));
  }
  std::string bytes_;
};

TEST_P(InBothVersions, JointsWrenchAndTimeComeBackAsTheyWere) {
  msgs::JointState joints;
  joints.mutable_header()->set_stamp(1'700'000'000'123'456'789);
  joints.mutable_header()->set_frame_id("base");
  joints.add_name("one");
  joints.add_name("two");
  for (const double q : {0.1, -std::acos(-1.0)}) {
    joints.add_position(q);
    joints.add_velocity(2 * q);
    joints.add_effort(3 * q);
  }
  EXPECT_EQ(there_and_back(joints, "sensor_msgs/JointState")->SerializeAsString(),
            joints.SerializeAsString());
  msgs::Wrench wrench;
  wrench.mutable_header()->set_stamp(5);
  wrench.mutable_wrench()->mutable_force()->set_x(1.25);
  wrench.mutable_wrench()->mutable_torque()->set_z(-1e-300);
  const auto felt = there_and_back(wrench, "geometry_msgs/WrenchStamped");
  EXPECT_EQ(static_cast<const msgs::Wrench&>(*felt).wrench().force().x(), 1.25);
  EXPECT_EQ(static_cast<const msgs::Wrench&>(*felt).wrench().torque().z(), -1e-300);
  msgs::Clock clock;
  clock.set_time(12'000'000'003);
  const auto told = there_and_back(clock, "rosgraph_msgs/Clock");
  EXPECT_EQ(static_cast<const msgs::Clock&>(*told).time(), clock.time());
}

TEST_P(InBothVersions, CamerasKeepTheirCalibration) {
  msgs::CameraInfo info;
  info.mutable_header()->set_frame_id("eye");
  info.set_width(640);
  info.set_height(480);
  info.set_fx(500.5);
  info.set_fy(501.5);
  info.set_cx(319.5);
  info.set_cy(239.5);
  EXPECT_EQ(there_and_back(info, "sensor_msgs/CameraInfo")->SerializeAsString(),
            info.SerializeAsString());
}

::foxglove::PointCloud two_points() {
  ::foxglove::PointCloud cloud;
  cloud.mutable_timestamp()->set_seconds(3);
  cloud.set_frame_id("world");
  cloud.set_point_stride(20);
  using Field = ::foxglove::PackedElementField;
  const auto add = [&cloud](const char* name, std::uint32_t offset, Field::NumericType type) {
    Field& field = *cloud.add_fields();
    field.set_name(name);
    field.set_offset(offset);
    field.set_type(type);
  };
  add("x", 0, Field::FLOAT32);
  add("y", 4, Field::FLOAT32);
  add("z", 8, Field::FLOAT32);
  add("red", 12, Field::UINT8);
  add("green", 13, Field::UINT8);
  add("blue", 14, Field::UINT8);
  add("alpha", 15, Field::UINT8);
  add("object", 16, Field::UINT16);
  for (const float x : {1.0F, 2.0F}) {
    const float xyz[3] = {x, -x, 0.5F};
    const unsigned char rest[8] = {10, 20, 30, 255, 7, 0, 0, 0};
    cloud.mutable_data()->append(reinterpret_cast<const char*>(xyz), sizeof xyz);
    cloud.mutable_data()->append(reinterpret_cast<const char*>(rest), sizeof rest);
  }
  return cloud;
}

TEST_P(InBothVersions, CloudsHaveTheirColoursAsPclHasThem) {
  const auto message = there_and_back(two_points(), "sensor_msgs/PointCloud2");
  const geometry::PointCloud cloud =
      convert::from_message(static_cast<const msgs::PointCloud&>(*message));
  ASSERT_EQ(cloud.points.size(), 2U);
  EXPECT_EQ(cloud.points[1], Eigen::Vector3f(2, -2, 0.5F));
  ASSERT_EQ(cloud.colors.size(), 2U);
  EXPECT_THAT(cloud.colors[0], ElementsAre(10, 20, 30));
  std::vector<std::string> fields;
  const recording::RosValue read_cloud = read("sensor_msgs/PointCloud2");
  for (const auto& field : read_cloud["fields"].list()) {
    fields.emplace_back(field["name"].text());
  }
  EXPECT_THAT(fields, ElementsAre("x", "y", "z", "object", "rgb"));
  ::foxglove::PointCloud cut = two_points();
  cut.mutable_data()->pop_back();
  EXPECT_THROW(to_ros(cut, "sensor_msgs/PointCloud2", GetParam()), InputError);
}

TEST_P(InBothVersions, PicturesFramesAndLog) {
  ::foxglove::RawImage image;
  image.set_width(2);
  image.set_height(1);
  image.set_encoding("rgb8");
  image.set_step(6);
  image.set_data("abcdef");
  const auto picture = there_and_back(image, "sensor_msgs/Image");
  EXPECT_EQ(static_cast<const msgs::Image&>(*picture).data(), "abcdef");
  ::foxglove::FrameTransforms frames;
  auto& frame = *frames.add_transforms();
  frame.set_parent_frame_id("world");
  frame.set_child_frame_id("hand");
  frame.mutable_translation()->set_y(0.25);
  frame.mutable_rotation()->set_w(1);
  bytes_ = to_ros(frames, "tf2_msgs/TFMessage", GetParam());
  const recording::RosValue read_frames = read("tf2_msgs/TFMessage");
  const auto& list = read_frames["transforms"].list();
  ASSERT_EQ(list.size(), 1U);
  EXPECT_EQ(list[0]["child_frame_id"].text(), "hand");
  EXPECT_EQ(list[0]["header"]["frame_id"].text(), "world");
  EXPECT_EQ(list[0]["transform"]["translation"]["y"].number(), 0.25);
  EXPECT_EQ(list[0]["transform"]["rotation"]["w"].number(), 1);
  ::foxglove::Log line;
  line.set_level(::foxglove::Log::WARNING);
  line.set_name("node");
  line.set_message("word");
  const std::string type =
      GetParam() == Version::kRos1 ? "rosgraph_msgs/Log" : "rcl_interfaces/Log";
  const auto back = there_and_back(line, type);
  EXPECT_EQ(static_cast<const msgs::graph::LogLine&>(*back).level(), msgs::graph::WARNING);
  EXPECT_EQ(static_cast<const msgs::graph::LogLine&>(*back).text(), "word");
}

TEST_P(InBothVersions, TimesThatRosCannotSayAreRefused) {
  msgs::JointState joints;
  joints.mutable_header()->set_stamp(-1);
  EXPECT_THROW(to_ros(joints, "sensor_msgs/JointState", GetParam()), InputError);
  joints.mutable_header()->set_stamp(3'000'000'000LL * 1'000'000'000);
  if (GetParam() == Version::kRos2) {
    EXPECT_THROW(to_ros(joints, "sensor_msgs/JointState", GetParam()), InputError);
  } else {
    EXPECT_NO_THROW(to_ros(joints, "sensor_msgs/JointState", GetParam()));
  }
}

INSTANTIATE_TEST_SUITE_P(Ros, InBothVersions, testing::Values(Version::kRos1, Version::kRos2));

TEST(ToRos, TypesThatDoNotGoTogetherAreRefused) {
  EXPECT_THAT(types_in_ros(*msgs::Wrench::descriptor(), Version::kRos2),
              ElementsAre("geometry_msgs/WrenchStamped"));
  EXPECT_THAT(types_in_ros(*::foxglove::Log::descriptor(), Version::kRos2),
              ElementsAre("rcl_interfaces/Log"));
  EXPECT_TRUE(types_in_ros(*msgs::GroundTruth::descriptor(), Version::kRos1).empty());
  EXPECT_THROW(to_ros(msgs::Wrench(), "sensor_msgs/Image", Version::kRos1), recording::RosError);
}

TEST(RosDurations, BelowZeroCountFromBelow) {
  const recording::RosValue duration = ros_duration(-1);
  EXPECT_EQ(duration["sec"].integer(), -1);
  EXPECT_EQ(duration["nanosec"].integer(), 999'999'999);
  EXPECT_EQ(ros_nanoseconds(duration), -1);
  EXPECT_THROW(ros_duration(std::int64_t{1} << 62), InputError);
}

}  // namespace
}  // namespace prehend::ros

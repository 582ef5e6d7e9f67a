// Files that say what a bridge exchanges.

#include "drivers/ros/driver/mapping.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "prehend/geometry/errors.h"

namespace prehend::drivers::ros_link {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class MappingFile : public testing::Test {
 protected:
  Mapping read(const std::string& text, ros::Version version = ros::Version::kRos2) {
    std::ofstream(path_) << text;
    return read_mapping(path_, version);
  }
  std::string error_of(const std::string& text, ros::Version version = ros::Version::kRos2) {
    try {
      read(text, version);
    } catch (const std::exception& error) {
      return error.what();
    }
    return {};
  }
  void TearDown() override { std::filesystem::remove(path_); }
  const std::filesystem::path path_ = std::filesystem::temp_directory_path() /
                                      ("prehend_mapping_" + std::to_string(::getpid()) + ".yaml");
};

TEST_F(MappingFile, HasTopicsCameraArmAndGripper) {
  const Mapping mapping = read(R"(
to_ros:
  - {prehend: /wrench, ros: /wrist, type: geometry_msgs/WrenchStamped, latched: true, depth: 3}
from_ros:
  - {ros: /tf, type: tf2_msgs/TFMessage}
  - {ros: /force, prehend: /other/wrench, type: geometry_msgs/WrenchStamped, reliability: best_effort}
camera: {depth: /d/image, color: /c/image, world_frame: base}
arm: {action: /a, joints: {arm_1: j1}, loss_time: 2}
gripper: {action: /g, joint: finger, position_per_opening: -0.5, closed_position: 0.8}
pick: /pick
)");
  ASSERT_EQ(mapping.to_ros.size(), 1U);
  EXPECT_TRUE(mapping.to_ros[0].qos.is_latched && mapping.to_ros[0].qos.is_reliable);
  EXPECT_EQ(mapping.to_ros[0].qos.depth, 3U);
  ASSERT_EQ(mapping.from_ros.size(), 2U);
  EXPECT_FALSE(mapping.from_ros[1].qos.is_reliable);
  EXPECT_EQ(mapping.camera->world_frame, "base");
  EXPECT_EQ(mapping.arm->joints.at("arm_1"), "j1");
  EXPECT_EQ(mapping.arm->joint_states, "/joint_states");
  EXPECT_EQ(mapping.arm->loss_time, 2);
  EXPECT_EQ(mapping.gripper->position_per_opening, -0.5);
  EXPECT_EQ(mapping.pick, "/pick");
}

TEST_F(MappingFile, ErrorsNameThePlaceAndTheMend) {
  EXPECT_THAT(error_of("to_rose: []\n"), AllOf(HasSubstr(":1"), HasSubstr("to_ros")));
  EXPECT_THAT(error_of("to_ros:\n  - {prehend: /a, ros: /b, type: sensor_msgs/Imag}\n"),
              AllOf(HasSubstr(":2"), HasSubstr("sensor_msgs/Image")));
  EXPECT_THAT(error_of("to_ros:\n  - {prehend: /a, ros: b, type: sensor_msgs/Image}\n"),
              HasSubstr("whole name"));
  EXPECT_THAT(error_of("to_ros:\n  - {ros: /b, type: sensor_msgs/Image}\n"), HasSubstr("prehend"));
  EXPECT_THAT(error_of("to_ros:\n  - {prehend: /a, ros: /b, type: sensor_msgs/Image, depth: 0}\n"),
              HasSubstr("depth"));
  EXPECT_THAT(error_of("to_ros:\n  - {prehend: /a, ros: /b, type: sensor_msgs/Image, "
                       "reliability: some}\n"),
              AllOf(HasSubstr("reliable"), HasSubstr("best_effort")));
  EXPECT_THAT(error_of("to_ros:\n  - {prehend: /a, ros: /b, type: sensor_msgs/Image, "
                       "reliability: best_effort}\n",
                       ros::Version::kRos1),
              HasSubstr("ROS 2's"));
  EXPECT_THAT(error_of("to_ros: /camera\n"), HasSubstr("no list"));
  EXPECT_THAT(error_of("camera: {stereo: [/l]}\n"), HasSubstr("pair"));
  EXPECT_THAT(error_of("camera: {color: /c}\n"), HasSubstr("depth"));
  EXPECT_THAT(error_of("arm: {action: /a, joints: {one: j, two: j}}\n"), HasSubstr("'j'"));
  EXPECT_THAT(error_of("arm: {joint_states: /j}\n"), HasSubstr("action"));
  EXPECT_THAT(error_of("arm: {action: /a, loss_time: -1}\n"), HasSubstr("loss_time"));
  EXPECT_THAT(error_of("gripper: {action: /a}\n"), HasSubstr("joint"));
  EXPECT_THAT(error_of("gripper: {action: /a, joint: j, position_per_opening: 0}\n"),
              HasSubstr("position_per_opening"));
  EXPECT_THAT(error_of(""), HasSubstr("map of keys"));
}

TEST_F(MappingFile, WhatWouldGoRoundIsRefused) {
  const std::string out = "to_ros:\n  - {prehend: /a, ros: /b, type: sensor_msgs/JointState}\n";
  EXPECT_THAT(error_of(out + "from_ros:\n  - {prehend: /c, ros: /b, type: sensor_msgs/JointState}"),
              HasSubstr("go round"));
  EXPECT_THAT(error_of(out + "from_ros:\n  - {prehend: /a, ros: /c, type: sensor_msgs/JointState}"),
              HasSubstr("sends back"));
  EXPECT_THAT(error_of(out + "  - {prehend: /d, ros: /b, type: sensor_msgs/JointState}"),
              HasSubstr("twice"));
}

TEST(MappingFiles, ThoseHereCanBeRead) {
  for (const auto& file : std::filesystem::directory_iterator("config/ros")) {
    if (file.path().extension() != ".yaml") continue;
    for (const ros::Version version : {ros::Version::kRos1, ros::Version::kRos2}) {
      EXPECT_NO_THROW(read_mapping(file.path(), version)) << file.path();
    }
  }
}

}  // namespace
}  // namespace prehend::drivers::ros_link

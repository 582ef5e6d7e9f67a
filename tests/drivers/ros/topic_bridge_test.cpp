// Topics between a graph and ROS: both ways, and what does not fit.

#include "drivers/ros/node/topic_bridge.h"

#include <gmock/gmock.h>

#include "msgs/camera.pb.h"
#include "msgs/convert/geometry.h"
#include "msgs/joints.pb.h"
#include "msgs/ros/to_ros.h"
#include "msgs/sensors.pb.h"
#include "prehend/robot/platform.h"
#include "tests/drivers/ros/memory_peer.h"
#include "tests/graph/test_graph.h"

namespace prehend::drivers::ros_link {
namespace {

using graph::eventually;
using recording::RosValue;
using testing::HasSubstr;
using Fields = RosValue::Fields;

class TopicsOfRos : public graph::GraphTest, public testing::WithParamInterface<ros::Version> {
 protected:
  TopicsOfRos() {
    node_.spin_in_background();
    user_.spin_in_background();
  }
  TopicBridge bridge(const Mapping& mapping, std::shared_ptr<robot::Platform> platform = nullptr) {
    return {node_, peer_, mapping, std::move(platform), [this](const std::string& problem) {
              const std::lock_guard lock(mutex_);
              problems_ += problem + "\n";
            }};
  }
  std::string problems() {
    const std::lock_guard lock(mutex_);
    return problems_;
  }
  std::string encoded(const std::string& type, Fields fields) const {
    return ros::type_of(type, GetParam())
        .write(RosValue(std::move(fields)), ros::encoding_of(GetParam()));
  }
  std::mutex mutex_;
  std::string problems_;
  MemoryPeer peer_{GetParam()};
  graph::Node node_{options("bridge")};
  graph::Node user_{options("user")};
};

TEST_P(TopicsOfRos, WhatIsPublishedGoesToRosAsTheMappingSays) {
  Mapping mapping;
  mapping.to_ros = {{"/wrench", "/wrist", "geometry_msgs/WrenchStamped", {}}};
  const TopicBridge topics = bridge(mapping);
  std::mutex mutex;
  std::vector<std::string> heard;
  const auto subscription = peer_.subscribe(
      "/wrist", "geometry_msgs/WrenchStamped", {},
      [&](std::string_view bytes) {
        const std::lock_guard lock(mutex);
        heard.emplace_back(bytes);
      },
      RosChannel::kTopic);
  const auto publisher = user_.advertise<msgs::Wrench>("/wrench", graph::QoS::queue(10));
  ASSERT_TRUE(publisher.wait_for_subscribers(1, std::chrono::seconds(5)));
  msgs::Wrench wrench;
  wrench.mutable_header()->set_stamp(7);
  wrench.mutable_wrench()->mutable_force()->set_y(2.5);
  publisher.publish(wrench);
  ASSERT_TRUE(eventually([&] {
    const std::lock_guard lock(mutex);
    return !heard.empty();
  }));
  const std::lock_guard lock(mutex);
  EXPECT_EQ(heard[0], ros::to_ros(wrench, "geometry_msgs/WrenchStamped", GetParam()));
  EXPECT_EQ(problems(), "");
}

TEST_P(TopicsOfRos, LinksGoAsFrames) {
  Mapping mapping;
  mapping.to_ros = {{"/viewer/frames", "/tf", "tf2_msgs/TFMessage", {}}};
  const auto platform =
      std::make_shared<robot::Platform>(robot::read_platform("config/robots/kr5_sdh.yaml"));
  const TopicBridge topics = bridge(mapping, platform);
  std::mutex mutex;
  std::set<std::string> frames;
  const auto subscription = peer_.subscribe(
      "/tf", "tf2_msgs/TFMessage", {},
      [&](std::string_view bytes) {
        const RosValue message = ros::type_of("tf2_msgs/TFMessage", GetParam())
                                     .read(bytes, ros::encoding_of(GetParam()));
        const std::lock_guard lock(mutex);
        for (const RosValue& one : message["transforms"].list()) {
          frames.emplace(one["child_frame_id"].text());
        }
      },
      RosChannel::kTopic);
  const auto publisher = user_.advertise<msgs::JointState>("/joint_states", graph::QoS::queue(10));
  ASSERT_TRUE(publisher.wait_for_subscribers(1, std::chrono::seconds(5)));
  msgs::JointState joints;
  joints.add_name("arm_axis_1");
  joints.add_position(0.1);
  publisher.publish(joints);
  ASSERT_TRUE(eventually([&] {
    const std::lock_guard lock(mutex);
    return frames.count(platform->flange) == 1;
  }));
}

TEST_P(TopicsOfRos, WhatRosPublishesComesHere) {
  Mapping mapping;
  mapping.from_ros = {{"/wrench", "/wrist", "geometry_msgs/WrenchStamped", {}}};
  const TopicBridge topics = bridge(mapping);
  std::mutex mutex;
  double force = 0;
  const auto subscription = user_.subscribe<msgs::Wrench>(
      "/wrench", graph::QoS::queue(10), [&](const graph::Received<msgs::Wrench>& message) {
        const std::lock_guard lock(mutex);
        force = message->wrench().force().x();
      });
  ASSERT_TRUE(eventually([&] {
    peer_.publish(
        "/wrist",
        encoded("geometry_msgs/WrenchStamped",
                {{"wrench",
                  RosValue(Fields{{"force", RosValue(Fields{{"x", ros::ros_number(4)}})}})}}));
    const std::lock_guard lock(mutex);
    return force == 4;
  }));
}

// Of ROS 2 the names of types do not tell versions apart.
TEST_P(TopicsOfRos, MessagesOfAnotherVersionAreSaidOnceAndLeftOut) {
  Mapping mapping;
  mapping.from_ros = {{"/wrench", "/wrist", "geometry_msgs/WrenchStamped", {}}};
  const TopicBridge topics = bridge(mapping);
  const std::string whole = encoded("geometry_msgs/WrenchStamped", {});
  for (int i = 0; i < 5; ++i) peer_.publish("/wrist", whole.substr(0, whole.size() - 9));
  const std::string said = problems();
  EXPECT_THAT(said, HasSubstr("/wrist of ROS: a geometry_msgs/WrenchStamped is left out"));
  EXPECT_THAT(said, HasSubstr("ends too early"));
  EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1);
}

TEST_P(TopicsOfRos, PicturesWaitForWhereTheCameraIs) {
  Mapping mapping;
  mapping.camera = Mapping::Camera{};
  mapping.camera->stereo = {"/l/image", "/r/image"};
  mapping.camera->world_frame = "base";
  mapping.from_ros = {{"", "/tf", "tf2_msgs/TFMessage", {}}};
  const TopicBridge topics = bridge(mapping);
  std::mutex mutex;
  std::optional<msgs::StereoPair> pair;
  const auto subscription =
      user_.subscribe<msgs::StereoPair>("/camera/stereo", graph::QoS::latched(),
                                        [&](const graph::Received<msgs::StereoPair>& message) {
                                          const std::lock_guard lock(mutex);
                                          pair = *message;
                                        });
  const std::string picture =
      encoded("sensor_msgs/Image", {{"header", ros::ros_header(5, "eye", GetParam())},
                                    {"height", ros::ros_integer(1)},
                                    {"width", ros::ros_integer(2)},
                                    {"step", ros::ros_integer(2)},
                                    {"encoding", ros::ros_text("mono8")},
                                    {"data", ros::ros_bytes("ab")}});
  peer_.publish("/l/image", picture);
  peer_.publish("/r/image", picture);
  EXPECT_THAT(problems(), HasSubstr("frame 'eye' wait until TF"));
  RosValue::List frames;
  frames.emplace_back(Fields{
      {"header", ros::ros_header(1, "base", GetParam())},
      {"child_frame_id", ros::ros_text("eye")},
      {"transform", RosValue(Fields{{"translation", RosValue(Fields{{"z", ros::ros_number(0.5)}})},
                                    {"rotation", RosValue(Fields{{"w", ros::ros_number(1)}})}})}});
  peer_.publish("/tf",
                encoded("tf2_msgs/TFMessage", {{"transforms", RosValue(std::move(frames))}}));
  peer_.publish("/l/image", picture);
  peer_.publish("/r/image", picture);
  ASSERT_TRUE(eventually([&] {
    const std::lock_guard lock(mutex);
    return pair.has_value();
  }));
  const std::lock_guard lock(mutex);
  EXPECT_EQ(pair->x_wc().position().z(), 0.5);
  EXPECT_EQ(pair->data(), "aaabbbaaabbb");
}

TEST_P(TopicsOfRos, TypesThatDoNotBecomeOneAnotherAreRefused) {
  Mapping mapping;
  mapping.to_ros = {{"/viewer/cloud", "/cloud", "sensor_msgs/Image", {}}};
  EXPECT_THROW(bridge(mapping), std::invalid_argument);
  mapping.to_ros = {{"/viewer/clouds", "/cloud", "sensor_msgs/PointCloud2", {}}};
  EXPECT_THROW(bridge(mapping), std::invalid_argument);
  mapping.to_ros.clear();
  mapping.from_ros = {{"/x", "/y", "geometry_msgs/Twist", {}}};
  EXPECT_THROW(bridge(mapping), std::invalid_argument);
}

INSTANTIATE_TEST_SUITE_P(Ros, TopicsOfRos,
                         testing::Values(ros::Version::kRos1, ros::Version::kRos2));

}  // namespace
}  // namespace prehend::drivers::ros_link

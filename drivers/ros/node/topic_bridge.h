#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "drivers/ros/driver/frame_tree.h"
#include "drivers/ros/driver/mapping.h"
#include "drivers/ros/transport/ros_peer.h"
#include "msgs/ros/camera_pairing.h"
#include "msgs/views/view.h"
#include "prehend/graph/node.h"
#include "prehend/robot/platform.h"

namespace prehend::drivers::ros_link {

/// Messages both ways, as a mapping says. What cannot be exchanged is told once for each topic, and
/// the rest goes on. Destroying it ends both.
class TopicBridge {
 public:
  /// `node` and `peer` live longer. @param platform whose links are in the frames; null: none are
  /// @throws std::invalid_argument for a pair of types that do not become one another
  TopicBridge(graph::Node& node, RosPeer& peer, const Mapping& mapping,
              std::shared_ptr<const robot::Platform> platform, RosProblem tell);
  ~TopicBridge();

  /// Topics that go to ROS, and that come from there.
  std::size_t to_ros() const { return publishers_.size(); }
  std::size_t from_ros() const { return subscriptions_.size(); }

 private:
  void send(const Mapping::Topic& topic, const std::vector<views::View>& views);
  void receive(const Mapping::Topic& topic);
  void receive_camera(const Mapping::Camera& camera);
  void take(const std::string& ros_topic, const std::string& type, std::string_view bytes,
            const std::function<void(const google::protobuf::Message&)>& use);
  void publish(const std::string& topic, const google::protobuf::Message& message);
  void take_frames(const recording::RosValue& message);
  void tell_once(const std::string& key, const std::string& problem);

  graph::Node& node_;
  RosPeer& peer_;
  const RosProblem tell_;
  FrameTree frames_;
  std::unique_ptr<ros::CameraPairing> pairing_;
  std::mutex pairing_mutex_;
  std::mutex mutex_;  // guards the next two
  std::set<std::string> told_;
  std::map<std::string, graph::RawPublisher> ours_;  // by topic
  std::vector<std::unique_ptr<RosPublisher>> publishers_;
  std::vector<graph::Subscription> readers_;
  std::vector<std::unique_ptr<RosSubscription>> subscriptions_;
};

}  // namespace prehend::drivers::ros_link

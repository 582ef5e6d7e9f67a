#include "drivers/ros/node/topic_bridge.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include "msgs/camera.pb.h"
#include "msgs/convert/geometry.h"
#include "msgs/graph.pb.h"
#include "msgs/joints.pb.h"
#include "msgs/ros/from_ros.h"
#include "msgs/ros/to_ros.h"
#include "msgs/sensors.pb.h"
#include "msgs/views/compressed_images.h"
#include "msgs/views/views.h"

namespace prehend::drivers::ros_link {
namespace {

using google::protobuf::Message;
using google::protobuf::MessageFactory;
using recording::RosValue;

constexpr const char* kFromRos = "[/";  // before a line of ROS's log in this node's

std::unique_ptr<Message> parsed(const google::protobuf::Descriptor& type, std::string_view bytes) {
  std::unique_ptr<Message> message(MessageFactory::generated_factory()->GetPrototype(&type)->New());
  if (!message->ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    throw std::invalid_argument("a message is damaged");
  }
  return message;
}

/// [ns] Of the messages that have a header.
std::int64_t stamp_of(const Message& message) {
  const auto* field = message.GetDescriptor()->FindFieldByName("header");
  if (!field || field->message_type() != msgs::Header::descriptor()) return 0;
  return static_cast<const msgs::Header&>(message.GetReflection()->GetMessage(message, field))
      .stamp();
}

/// As prehend's own publishers of these have it.
graph::QoS qos_of(const google::protobuf::Descriptor& type) {
  const bool is_stream =
      &type == msgs::JointState::descriptor() || &type == msgs::Wrench::descriptor();
  return is_stream ? graph::QoS::queue(100) : graph::QoS::latched();
}

bool is_compressed(const std::string& topic) {
  return topic.ends_with("/compressed") || topic.ends_with("/compressedDepth");
}

}  // namespace

TopicBridge::TopicBridge(graph::Node& node, RosPeer& peer, const Mapping& mapping,
                         std::shared_ptr<const robot::Platform> platform, RosProblem tell)
    : node_(node), peer_(peer), tell_(std::move(tell)) {
  const auto raw = views::standard_views(platform);
  const auto small = views::standard_views(
      platform, {.shown = true, .compress = [](const ::foxglove::RawImage& image) {
                   return views::compressed_image(image, views::PictureFormat::kJpeg);
                 }});
  for (const Mapping::Topic& topic : mapping.to_ros) {
    send(topic, topic.type == "sensor_msgs/CompressedImage" ? small : raw);
  }
  for (const Mapping::Topic& topic : mapping.from_ros) receive(topic);
  if (mapping.camera) receive_camera(*mapping.camera);
}

// First what calls back.
TopicBridge::~TopicBridge() {
  subscriptions_.clear();
  readers_.clear();
}

void TopicBridge::tell_once(const std::string& key, const std::string& problem) {
  {
    const std::lock_guard lock(mutex_);
    if (!told_.insert(key).second) return;
  }
  tell_(problem);
}

void TopicBridge::send(const Mapping::Topic& topic, const std::vector<views::View>& views) {
  const auto version = peer_.version();
  const std::string name = topic.prehend, type = topic.type;
  publishers_.push_back(peer_.advertise(topic.ros, type, topic.qos));
  RosPublisher& to = *publishers_.back();
  const auto convert = [this, &to, name, type, version](const google::protobuf::Descriptor& from,
                                                        std::string_view bytes) {
    try {
      to.publish(ros::to_ros(*parsed(from, bytes), type, version));
    } catch (const std::exception& error) {
      tell_once(name, name + " does not go to ROS: " + error.what());
    }
  };
  const auto view = std::find_if(views.begin(), views.end(),
                                 [&](const views::View& one) { return one.channel.topic == name; });
  if (view == views.end()) {
    if (views::is_view(name)) {
      throw std::invalid_argument("there is no view " + name +
                                  (name == "/viewer/robot" ? " without a platform" : ""));
    }
    readers_.push_back(node_.subscribe_raw(
        name, graph::QoS::queue(20), [convert](const graph::RawMessage& message) {
          const auto* from =
              google::protobuf::DescriptorPool::generated_pool()->FindMessageTypeByName(
                  message.schema->name);
          if (from) convert(*from, message.bytes);
        }));
    return;
  }
  const auto types = ros::types_in_ros(*view->channel.type, version);
  if (std::find(types.begin(), types.end(), type) == types.end()) {
    throw std::invalid_argument(
        fmt::format("{} does not become a {}; it can be: {}", name, type,
                    types.empty() ? "nothing" : fmt::format("{}", fmt::join(types, ", "))));
  }
  const auto* from = view->channel.type;
  const auto sources = view->begin([convert, from](std::int64_t, const std::string& bytes,
                                                   const std::string&) { convert(*from, bytes); });
  for (const views::View::Source& source : sources) {
    readers_.push_back(node_.subscribe_raw(
        source.topic, graph::QoS::queue(20),
        [this, source, name, own = node_.name()](const graph::RawMessage& message) {
          if (message.schema->name == msgs::graph::LogLine::descriptor()->full_name()) {
            // What came from ROS does not go back.
            msgs::graph::LogLine line;
            if (line.ParseFromString(message.bytes) && line.node() == own &&
                line.text().rfind(kFromRos, 0) == 0) {
              return;
            }
          }
          try {
            source.take({.topic = source.topic,
                         .sender = message.info.sender.str(),
                         .schema_name = message.schema->name,
                         .bytes = message.bytes,
                         .publish_time = message.info.publish_time,
                         .pace_time = message.info.publish_time});
          } catch (const std::exception& error) {
            tell_once(name, name + " does not go to ROS: " + error.what());
          }
        }));
  }
}

void TopicBridge::take(const std::string& ros_topic, const std::string& type,
                       std::string_view bytes, const std::function<void(const Message&)>& use) {
  try {
    const auto version = peer_.version();
    const RosValue value = ros::type_of(type, version).read(bytes, ros::encoding_of(version));
    if (type == "tf2_msgs/TFMessage") return take_frames(value);
    const auto message = ros::from_ros(type, value);
    if (message) use(*message);
  } catch (const std::exception& error) {
    tell_once("ros:" + ros_topic,
              fmt::format("{} of ROS: a {} is left out: {}", ros_topic, type, error.what()));
  }
}

void TopicBridge::receive(const Mapping::Topic& topic) {
  const auto& known = ros::ros_types();
  const bool is_frames = topic.type == "tf2_msgs/TFMessage";
  if (!is_frames && std::find(known.begin(), known.end(), topic.type) == known.end()) {
    throw std::invalid_argument(
        fmt::format("{} of ROS: nothing becomes of a {}; prehend takes {}, tf2_msgs/TFMessage",
                    topic.ros, topic.type, fmt::join(known, ", ")));
  }
  const bool is_log = topic.type == "rosgraph_msgs/Log" || topic.type == "rcl_interfaces/Log";
  subscriptions_.push_back(peer_.subscribe(
      topic.ros, topic.type, topic.qos, [this, topic, is_log](std::string_view bytes) {
        take(topic.ros, topic.type, bytes, [&](const Message& message) {
          if (!is_log) return publish(topic.prehend, message);
          const auto& line = static_cast<const msgs::graph::LogLine&>(message);
          const bool has_slash = line.node().rfind('/', 0) == 0;
          node_.log(static_cast<graph::LogLevel>(line.level()),
                    fmt::format("[{}{}] {}", has_slash ? "" : "/", line.node(), line.text()));
        });
      }));
}

void TopicBridge::receive_camera(const Mapping::Camera& camera) {
  pairing_ = camera.stereo.empty() ? ros::pair_depth(camera.depth, camera.color)
                                   : ros::pair_stereo(camera.stereo[0], camera.stereo[1]);
  const auto write = [this, frame = camera.world_frame](const std::string& topic, std::uint64_t,
                                                        const Message& message) {
    if (frame.empty()) return publish(topic, message);
    std::unique_ptr<Message> posed(message.New());
    posed->CopyFrom(message);
    const auto* reflection = posed->GetReflection();
    const auto* header = posed->GetDescriptor()->FindFieldByName("header");
    const auto* pose = posed->GetDescriptor()->FindFieldByName("X_WC");
    const std::string eye =
        static_cast<const msgs::Header&>(reflection->GetMessage(*posed, header)).frame_id();
    const auto X_WC = frames_.find(frame, eye);
    if (!X_WC) {
      throw std::invalid_argument(fmt::format(
          "pictures of frame '{}' wait until TF says where that is in '{}'", eye, frame));
    }
    reflection->MutableMessage(posed.get(), pose)->CopyFrom(convert::to_message(*X_WC));
    publish(topic, *posed);
  };
  const auto subscribe = [&](const std::string& topic, const std::string& type) {
    subscriptions_.push_back(peer_.subscribe(
        topic, type,
        {.is_reliable = camera.is_reliable || peer_.version() == ros::Version::kRos1, .depth = 5},
        [this, topic, type, write](std::string_view bytes) {
          take(topic, type, bytes, [&](const Message& message) {
            const std::lock_guard lock(pairing_mutex_);
            pairing_->take(topic, 0, message, write);
          });
        }));
  };
  for (const std::string& topic : pairing_->pictures()) {
    subscribe(topic, is_compressed(topic) ? "sensor_msgs/CompressedImage" : "sensor_msgs/Image");
  }
  for (const std::string& topic : pairing_->calibrations()) {
    subscribe(topic, "sensor_msgs/CameraInfo");
  }
}

void TopicBridge::take_frames(const RosValue& message) {
  for (const RosValue& one : message["transforms"].list()) {
    const RosValue &p = one["transform"]["translation"], &q = one["transform"]["rotation"];
    const Eigen::Quaterniond rotation(q["w"].number(), q["x"].number(), q["y"].number(),
                                      q["z"].number());
    const Eigen::Vector3d place(p["x"].number(), p["y"].number(), p["z"].number());
    if (!(rotation.norm() > 0.5 && rotation.norm() < 2) || !place.allFinite()) {
      throw std::invalid_argument(
          "a transform's rotation is no unit quaternion, or its translation "
          "not finite");
    }
    frames_.set(std::string(one["header"]["frame_id"].text()),
                std::string(one["child_frame_id"].text()),
                geometry::make_transform(rotation, place));
  }
}

void TopicBridge::publish(const std::string& topic, const Message& message) {
  const auto& type = *message.GetDescriptor();
  graph::RawPublisher publisher;
  {
    const std::lock_guard lock(mutex_);
    graph::RawPublisher& found = ours_[topic];
    if (!found) found = node_.advertise_raw(topic, qos_of(type), graph::schema_of(type));
    publisher = found;
  }
  publisher.publish(message.SerializeAsString(), stamp_of(message));
}

}  // namespace prehend::drivers::ros_link

#include "drivers/ros/driver/mapping.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

#include "prehend/text/nearest_match.h"
#include "prehend/text/yaml_map.h"

namespace prehend::drivers::ros_link {
namespace {

using text::YamlMap;

bool is_name(const std::string& name) {
  return name.size() > 1 && name.front() == '/' && name.back() != '/' &&
         std::all_of(name.begin(), name.end(),
                     [](unsigned char c) { return std::isalnum(c) != 0 || c == '/' || c == '_'; });
}

std::string read_name(YamlMap& map, const std::string& key, bool is_needed) {
  std::string name;
  map.read(key, name);
  if (name.empty() && !is_needed) return name;
  if (!is_name(name)) {
    map.fail(key, name.empty() ? "is missing" : "is '" + name + "'",
             "Write a whole name of letters, digits and _, as /camera/points");
  }
  return name;
}

void require_positive(YamlMap& map, const std::string& key, double value) {
  if (!(value > 0 && value < 1e6)) map.fail(key, "is not positive", "Write a number above 0");
}

void read_qos(YamlMap& map, ros::Version version, RosQos& qos) {
  map.choose<bool>("reliability", {{"reliable", true}, {"best_effort", false}}, qos.is_reliable);
  if (version == ros::Version::kRos1 && !qos.is_reliable) {
    map.fail("reliability", "is ROS 2's, and this is ROS 1", "Leave it away");
  }
  map.read("latched", qos.is_latched);
  auto depth = static_cast<std::uint32_t>(qos.depth);
  map.read("depth", depth);
  if (depth < 1 || depth > 10000) map.fail("depth", "is out of range", "Write 1 to 10000");
  qos.depth = depth;
}

Mapping::Topic read_topic(const YAML::Node& node, const std::filesystem::path& path,
                          const std::string& place, ros::Version version) {
  YamlMap map(node, path, place);
  Mapping::Topic topic;
  map.read("type", topic.type);
  const std::vector<std::string> known = ros::message_types(version);
  if (!ros::has_definition(topic.type, version)) {
    map.fail(
        "type", topic.type.empty() ? "is missing" : "is '" + topic.type + "'",
        "Write a type as sensor_msgs/PointCloud2" + text::nearest_match_hint(topic.type, known));
  }
  topic.ros = read_name(map, "ros", true);
  // Frames from ROS are for the camera's pose, and go to no topic.
  const bool is_needed = place != "from_ros" || topic.type != "tf2_msgs/TFMessage";
  topic.prehend = read_name(map, "prehend", is_needed);
  read_qos(map, version, topic.qos);
  map.finish();
  return topic;
}

void read_topics(YamlMap& top, const char* key, const std::filesystem::path& path,
                 ros::Version version, std::vector<Mapping::Topic>& topics) {
  const YAML::Node list = top.child(key);
  if (!list) return;
  if (!list.IsSequence()) top.fail(key, "is no list", "Begin each topic with '- '");
  for (const YAML::Node& node : list) topics.push_back(read_topic(node, path, key, version));
}

void refuse_circles(const YamlMap& top, const Mapping& mapping) {
  for (const Mapping::Topic& in : mapping.from_ros) {
    for (const Mapping::Topic& out : mapping.to_ros) {
      if (in.ros == out.ros) {
        top.fail("from_ros", "has " + in.ros + " of ROS, which to_ros sends there",
                 "Leave one of the two away: its messages would go round");
      }
      if (!in.prehend.empty() && in.prehend == out.prehend) {
        top.fail("from_ros", "publishes " + in.prehend + ", which to_ros sends back",
                 "Leave one of the two away");
      }
    }
  }
  std::set<std::string> names;
  for (const Mapping::Topic& out : mapping.to_ros) {
    if (!names.insert(out.ros).second) {
      top.fail("to_ros", "has " + out.ros + " twice", "Give each topic of ROS one source");
    }
  }
}

Mapping::Camera read_camera(const YAML::Node& node, const std::filesystem::path& path) {
  YamlMap map(node, path, "camera");
  Mapping::Camera camera;
  const YAML::Node pair = map.child("stereo");
  if (pair) {
    if (!pair.IsSequence() || pair.size() != 2) {
      map.fail("stereo", "is no pair", "Write [/left/image_rect, /right/image_rect]");
    }
    for (const YAML::Node& one : pair) {
      const auto name = one.as<std::string>("");
      if (!is_name(name)) map.fail("stereo", "has '" + name + "'", "Write whole names of topics");
      camera.stereo.push_back(name);
    }
  }
  camera.depth = read_name(map, "depth", false);
  camera.color = read_name(map, "color", false);
  if (camera.stereo.empty() == camera.depth.empty()) {
    map.fail(pair ? "stereo" : "depth", pair ? "is beside depth" : "is missing",
             "Give either stereo or depth");
  }
  if (!camera.color.empty() && camera.depth.empty()) {
    map.fail("color", "goes with depth alone", "Leave it away");
  }
  map.read("world_frame", camera.world_frame);
  map.choose<bool>("reliability", {{"reliable", true}, {"best_effort", false}}, camera.is_reliable);
  map.finish();
  return camera;
}

Mapping::Arm read_arm(const YAML::Node& node, const std::filesystem::path& path) {
  YamlMap map(node, path, "arm");
  Mapping::Arm arm;
  arm.action = read_name(map, "action", true);
  arm.joint_states = read_name(map, "joint_states", false);
  if (arm.joint_states.empty()) arm.joint_states = "/joint_states";
  if (const YAML::Node joints = map.child("joints")) {
    if (!joints.IsMap()) map.fail("joints", "is no map", "Write {arm_a1: joint_a1, ...}");
    std::set<std::string> used;
    for (const auto& pair : joints) {
      const auto name = pair.second.as<std::string>("");
      if (name.empty() || !used.insert(name).second) {
        map.fail("joints", "names '" + name + "' for " + pair.first.as<std::string>(""),
                 "Give each joint one name of ROS");
      }
      arm.joints[pair.first.as<std::string>("")] = name;
    }
  }
  map.read("settle_time", arm.settle_time);
  require_positive(map, "settle_time", arm.settle_time);
  map.read("loss_time", arm.loss_time);
  require_positive(map, "loss_time", arm.loss_time);
  map.finish();
  return arm;
}

Mapping::Gripper read_gripper(const YAML::Node& node, const std::filesystem::path& path) {
  YamlMap map(node, path, "gripper");
  Mapping::Gripper gripper;
  gripper.action = read_name(map, "action", true);
  gripper.joint_states = read_name(map, "joint_states", false);
  if (gripper.joint_states.empty()) gripper.joint_states = "/joint_states";
  map.read("joint", gripper.joint);
  if (gripper.joint.empty()) map.fail("joint", "is missing", "Name the joint whose position it is");
  map.read("position_per_opening", gripper.position_per_opening);
  if (!(std::abs(gripper.position_per_opening) > 1e-9)) {
    map.fail("position_per_opening", "is 0", "Write the joint's way of one metre of opening");
  }
  map.read("closed_position", gripper.closed_position);
  map.read("effort_per_current", gripper.effort_per_current);
  require_positive(map, "effort_per_current", gripper.effort_per_current);
  map.read("loss_time", gripper.loss_time);
  require_positive(map, "loss_time", gripper.loss_time);
  map.finish();
  return gripper;
}

}  // namespace

Mapping read_mapping(const std::filesystem::path& path, ros::Version version) {
  YamlMap top(text::load_yaml_map(path), path, "the mapping");
  Mapping mapping;
  read_topics(top, "to_ros", path, version, mapping.to_ros);
  read_topics(top, "from_ros", path, version, mapping.from_ros);
  if (const YAML::Node camera = top.child("camera")) mapping.camera = read_camera(camera, path);
  if (const YAML::Node arm = top.child("arm")) mapping.arm = read_arm(arm, path);
  if (const YAML::Node gripper = top.child("gripper")) {
    mapping.gripper = read_gripper(gripper, path);
  }
  mapping.pick = read_name(top, "pick", false);
  top.finish();
  refuse_circles(top, mapping);
  return mapping;
}

}  // namespace prehend::drivers::ros_link

#include "drivers/ros/node/bridge.h"

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "drivers/ros/driver/mapping.h"
#include "drivers/ros/driver/ros_arm.h"
#include "drivers/ros/driver/ros_gripper.h"
#include "drivers/ros/node/offers.h"
#include "drivers/ros/node/pick_offer.h"
#include "drivers/ros/node/topic_bridge.h"
#include "drivers/wire/health/health.h"
#include "drivers/wire/node/device_report.h"
#include "nodes/platform_source/platform_source.h"
#include "prehend/robot/gripper_model.h"
#include "prehend/robot/robot_files.h"
#include "prehend/text/tree_file.h"

namespace prehend::drivers::ros_link {
namespace {

struct Settings {
  std::string mapping, platforms, platform, gripper, other_joints, cycle;
};

std::string declare_word(graph::Node& node, const char* name, const std::string& value,
                         const char* description, bool reads_file = false) {
  return node.declare_parameter<std::string>({.name = name,
                                              .default_value = value,
                                              .description = description,
                                              .read_only = true,
                                              .reads_file = reads_file});
}

Settings declare_settings(graph::Node& node) {
  Settings s;
  s.mapping = declare_word(node, "mapping", text::tree_file("config/ros/default.yaml"),
                           "file of what is exchanged, config/ros", true);
  s.platforms = nodes::declare_platforms(node);
  s.platform = declare_word(node, "platform", "",
                            "the robot, of `platforms` without .yaml or a file: whose links go to "
                            "ROS as frames, whose arm the mapping's is; empty: none");
  s.gripper = declare_word(node, "gripper", "",
                           "model of the mapping's gripper, config/robots; empty: the platform's");
  s.other_joints = declare_word(node, "other_joints", "",
                                "topic whose joints, those of the hand, are told with the arm's on "
                                "/joint_states; empty: none");
  s.cycle = declare_word(node, "cycle", "grasp_cycle", "name of the node that picks");
  return s;
}

/// The problems of the peer, and what they make of the node's health.
class Problems {
 public:
  explicit Problems(graph::Node& node) : node_(node) {}
  RosProblem taker() {
    return [this](const std::string& problem) {
      node_.log_warning("{}", problem);
      const std::lock_guard lock(mutex_);
      last_ = problem;
      ++count_;
    };
  }
  /// "" when there was none.
  std::string words() const {
    const std::lock_guard lock(mutex_);
    if (count_ < 2) return last_;
    return fmt::format("{} (and {} more, see the log)", last_, count_ - 1);
  }

 private:
  graph::Node& node_;
  mutable std::mutex mutex_;  // guards the next two
  std::string last_;
  int count_ = 0;
};

Health health_of(const TopicBridge& topics, const RosArm* arm, const RosGripper* gripper,
                 const std::string& problem) {
  if (const std::string why = arm ? arm->obstacle() : ""; !why.empty()) {
    return {Health::Level::kError, "the arm cannot move: " + why};
  }
  if (const std::string why = gripper ? gripper->obstacle() : ""; !why.empty()) {
    return {Health::Level::kError, "the gripper cannot move: " + why};
  }
  if (!problem.empty()) return {Health::Level::kWarning, problem};
  return {Health::Level::kOk,
          fmt::format("{} topics to ROS, {} from there", topics.to_ros(), topics.from_ros())};
}

}  // namespace

void run_bridge(graph::Node& node, ros::Version version, const Connect& connect) {
  const Settings settings = declare_settings(node);
  nodes::EmergencyStopListener emergency(node);
  // --help and --describe end here, before anything is read or opened.
  const Mapping mapping = read_mapping(settings.mapping, version);
  std::shared_ptr<const robot::Platform> platform;
  if (!settings.platform.empty()) {
    platform = std::make_shared<const robot::Platform>(
        robot::read_platform(robot::platform_file(settings.platforms, settings.platform)));
  }
  if (mapping.arm && !platform) {
    throw std::invalid_argument("the mapping has an arm: parameter 'platform' says whose it is");
  }
  if (!mapping.arm && !settings.other_joints.empty()) {
    throw std::invalid_argument("parameter 'other_joints' goes with an arm in the mapping");
  }
  if (!mapping.gripper && !settings.gripper.empty()) {
    throw std::invalid_argument("parameter 'gripper' goes with a gripper in the mapping");
  }
  Problems problems(node);
  const std::unique_ptr<RosPeer> peer = connect(problems.taker());
  TopicBridge topics(node, *peer, mapping, platform, problems.taker());
  std::unique_ptr<RosArm> arm;
  std::unique_ptr<ArmOffer> arm_offer;
  if (mapping.arm) {
    arm = std::make_unique<RosArm>(*peer, *mapping.arm, platform->arm_chain(), problems.taker());
    arm_offer = std::make_unique<ArmOffer>(node, *arm, emergency, settings.other_joints);
  }
  std::unique_ptr<RosGripper> gripper;
  std::unique_ptr<GripperOffer> gripper_offer;
  if (mapping.gripper) {
    if (settings.gripper.empty()) {
      throw std::invalid_argument("the mapping has a gripper: parameter 'gripper' names its model");
    }
    gripper = std::make_unique<RosGripper>(
        *peer, *mapping.gripper, robot::read_gripper_model(settings.gripper), problems.taker());
    gripper_offer = std::make_unique<GripperOffer>(node, *gripper, emergency, settings.gripper);
  }
  std::unique_ptr<PickOffer> pick;
  if (!mapping.pick.empty()) {
    pick = std::make_unique<PickOffer>(node, *peer, mapping.pick, settings.cycle);
  }
  DeviceReport report(node);
  constexpr double kHealthPeriod = 0.5;  // s
  const WallTimer watcher(kHealthPeriod, [&] {
    report.tell(health_of(topics, arm.get(), gripper.get(), problems.words()));
  });
  node.spin();
}

}  // namespace prehend::drivers::ros_link

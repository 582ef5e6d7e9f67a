#include "drivers/ros/emulator/emulated_controller.h"

#include <utility>

#include "msgs/ros/from_ros.h"
#include "msgs/ros/to_ros.h"

namespace prehend::drivers::ros_link {

using recording::RosValue;
using Fields = RosValue::Fields;

EmulatedController::EmulatedController(graph::Node& node, RosPeer& peer, const std::string& action,
                                       const std::string& joint_states)
    : node_(node),
      client_(node.action_client<msgs::FollowTrajectoryGoal, msgs::FollowTrajectoryFeedback,
                                 msgs::FollowTrajectoryResult>("/world/arm/follow")),
      joints_(peer.advertise(joint_states, "sensor_msgs/JointState", {.depth = 100})) {
  server_ =
      serve_action(peer, action, "control_msgs/FollowJointTrajectory",
                   {[this](const RosValue& goal) { return begin(goal); }, [this] { cancel(); }});
  subscription_ = node.subscribe<msgs::JointState>(
      "/world/joint_states", graph::QoS::queue(20),
      [this, version = peer.version()](const graph::Received<msgs::JointState>& joints) {
        joints_->publish(ros::to_ros(*joints, "sensor_msgs/JointState", version));
      });
}

EmulatedController::~EmulatedController() { server_.reset(); }

std::string EmulatedController::begin(const RosValue& goal) {
  constexpr double kSecond = 1e9;  // ns
  msgs::FollowTrajectoryGoal request;
  const RosValue& trajectory = goal["trajectory"];
  for (const RosValue& name : trajectory["joint_names"].list()) {
    request.mutable_trajectory()->add_joint_name(std::string(name.text()));
  }
  for (const RosValue& point : trajectory["points"].list()) {
    msgs::JointTrajectoryPoint& to = *request.mutable_trajectory()->add_points();
    to.set_time(static_cast<double>(ros::ros_nanoseconds(point["time_from_start"])) / kSecond);
    const auto take = [&point](const char* field, auto* numbers) {
      for (const double number : point[field].numbers()) numbers->Add(number);
    };
    take("positions", to.mutable_position());
    take("velocities", to.mutable_velocity());
    take("accelerations", to.mutable_acceleration());
  }
  for (const RosValue& tolerance : goal["path_tolerance"].list()) {
    request.add_path_tolerance(tolerance["position"].number());
  }
  const std::lock_guard lock(mutex_);
  cancelled_ = false;
  goal_ = client_.send(request);
  goal_.on_result(
      [this, sent = goal_](const graph::Outcome<msgs::FollowTrajectoryResult>& outcome) {
        end(sent, outcome);
      });
  return {};
}

void EmulatedController::cancel() {
  const std::lock_guard lock(mutex_);
  cancelled_ = true;
  if (goal_) goal_.cancel();
}

void EmulatedController::end(const Goal&,
                             const graph::Outcome<msgs::FollowTrajectoryResult>& outcome) {
  bool cancelled = false;
  {
    const std::lock_guard lock(mutex_);
    cancelled = cancelled_;
  }
  const bool reached = outcome.has_value() && outcome->reached();
  const std::string why = outcome.has_value() ? outcome->reason() : outcome.error();
  constexpr std::int64_t kPathToleranceViolated = -4;
  server_->finish(
      reached, cancelled && !reached,
      RosValue(Fields{{"error_code", ros::ros_integer(reached ? 0 : kPathToleranceViolated)},
                      {"error_string", ros::ros_text(why)}}),
      why);
}

void run_emulated_controller(graph::Node& node,
                             const std::function<std::unique_ptr<RosPeer>(RosProblem)>& connect) {
  const auto declare = [&node](const char* name, const char* value, const char* description) {
    return node.declare_parameter<std::string>(
        {.name = name, .default_value = value, .description = description, .read_only = true});
  };
  const std::string action =
      declare("action", "/emulated/follow_joint_trajectory", "name of the action in ROS");
  const std::string joint_states =
      declare("joint_states", "/emulated/joint_states", "topic of ROS for the joints");
  const std::unique_ptr<RosPeer> peer =
      connect([&node](const std::string& problem) { node.log_warning("{}", problem); });
  const EmulatedController controller(node, *peer, action, joint_states);
  node.spin();
}

}  // namespace prehend::drivers::ros_link

#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "drivers/ros/driver/action_server.h"
#include "msgs/actions.pb.h"
#include "msgs/joints.pb.h"
#include "prehend/graph/node.h"

namespace prehend::drivers::ros_link {

/// A controller of ROS whose arm is the simulated one elsewhere in the graph: offers ROS the action
/// control_msgs/FollowJointTrajectory by /world/arm/follow, and tells it /world/joint_states.
class EmulatedController {
 public:
  /// `node` and `peer` live longer.
  EmulatedController(graph::Node& node, RosPeer& peer, const std::string& action,
                     const std::string& joint_states);
  ~EmulatedController();

 private:
  using Goal = graph::GoalHandle<msgs::FollowTrajectoryResult>;
  std::string begin(const recording::RosValue& goal);
  void cancel();
  void end(const Goal& goal, const graph::Outcome<msgs::FollowTrajectoryResult>& outcome);

  graph::Node& node_;
  graph::ActionClient<msgs::FollowTrajectoryGoal, msgs::FollowTrajectoryFeedback,
                      msgs::FollowTrajectoryResult>
      client_;
  std::mutex mutex_;  // guards the next two
  Goal goal_;
  bool cancelled_ = false;
  std::unique_ptr<RosPublisher> joints_;
  std::unique_ptr<RosActionServer> server_;
  graph::Subscription subscription_;
};

/// The node of an emulated controller of ROS, beside its own parameters `action` and
/// `joint_states`, until it is stopped.
void run_emulated_controller(graph::Node& node,
                             const std::function<std::unique_ptr<RosPeer>(RosProblem)>& connect);

}  // namespace prehend::drivers::ros_link

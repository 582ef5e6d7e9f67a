#pragma once

#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "msgs/grasp.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/graph/node.h"
#include "prehend/robot/gripper_model.h"

namespace prehend::nodes {

/// Which gripper a node plans for or moves: the one that the robot says it has (/gripper/model).
///
/// The robot is the source: a simulation by its scene, a driver by its file. The parameter
/// `gripper` is for graphs without a robot. Where two say something, they must say the same: a plan
/// for one gripper that another executes grips beside or collides. May be asked from any thread.
class GripperSource {
 public:
  /// Declares the parameter `gripper`. @throws geometry::InputError for a file that is no gripper.
  explicit GripperSource(graph::Node& node);

  /// Subscribes, once all parameters are declared. `on_news` is called when somebody said it.
  void listen(std::function<void()> on_news = nullptr);

  /// Unset: nobody has said it yet, or there is a problem.
  std::optional<robot::GripperModel> model() const;
  /// The same with its file, for messages; empty when unset.
  msgs::GripperDescription description() const;
  /// In what a plan's gripper differs from the robot's, with both values and both places; empty: in
  /// nothing, or the plan does not say. @throws geometry::InputError when it cannot be read.
  std::string differs_from(const msgs::GraspPlan& plan) const;
  /// Two that differ (both values, both places and the mend), or one that cannot be read. Empty:
  /// none.
  std::string problem() const;
  /// Why there is no model, in words.
  std::string missing() const;

 private:
  struct Said {
    msgs::GripperDescription description;
    robot::GripperModel model;
    std::string place;   // "config/robots/wide.yaml (node simulation)"
    std::string broken;  // why it cannot be read; empty: it can
  };
  void take(const graph::Received<msgs::GripperDescription>& message);
  void decide();  // under the lock

  graph::Node& node_;
  mutable std::mutex mutex_;          // guards the next four
  std::map<std::string, Said> said_;  // by who said it; "" is the parameter
  std::optional<robot::GripperModel> model_;
  msgs::GripperDescription description_;
  std::string problem_;
  std::function<void()> on_news_;
  graph::Subscription subscription_;
};

}  // namespace prehend::nodes

#pragma once

#include <string>
#include <vector>

#include "msgs/actions.pb.h"
#include "nodes/motion_goal/motion_goal.h"
#include "prehend/control/arm_cycle.h"
#include "prehend/graph/node.h"

namespace prehend::nodes {

/// The action /arm/follow.
class ArmActions : public control::ArmPort {
 public:
  explicit ArmActions(graph::Node& node);
  void follow(const control::JointTrajectory& path, double contact_force) override;
  control::MotionStatus motion() override;
  double answer_age() override { return goal_.answer_age(); }
  std::string problem() override { return problem_; }
  void stop() override { goal_.stop(); }

 private:
  MotionGoal<msgs::FollowTrajectoryGoal, msgs::FollowTrajectoryFeedback,
             msgs::FollowTrajectoryResult>
      goal_;
  std::string problem_;
};

/// The action /hand/move.
class HandActions : public control::HandPort {
 public:
  explicit HandActions(graph::Node& node);
  void move(const std::vector<std::string>& joints, const std::vector<double>& positions,
            double speed, bool until_contact, const std::vector<double>& effort) override;
  control::MotionStatus motion() override;
  double answer_age() override { return goal_.answer_age(); }
  std::string problem() override { return problem_; }
  std::vector<double> positions() override { return positions_; }
  void stop() override { goal_.stop(); }

 private:
  graph::Node& node_;
  MotionGoal<msgs::MoveHandGoal, msgs::MoveHandFeedback, msgs::MoveHandResult> goal_;
  std::string problem_;
  std::vector<double> positions_;
};

}  // namespace prehend::nodes

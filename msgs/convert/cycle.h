#pragma once

#include <cstdint>

#include "msgs/grasp.pb.h"
#include "msgs/joints.pb.h"
#include "prehend/control/arm_cycle.h"
#include "prehend/control/cycle.h"
#include "prehend/control/task.h"

// What cycles execute and say.
namespace prehend::convert {

control::JointTrajectory from_message(const msgs::JointTrajectory& trajectory);
msgs::JointTrajectory to_message(const control::JointTrajectory& path);

/// Whether a grasp has a motion of the arm and positions of the hand.
bool has_arm_motion(const msgs::Grasp& grasp);

/// Without rates and limits of the joints, those that the plan moves close, without limits.
/// @pre has_arm_motion(grasp)
/// @throws geometry::InputError for values that do not belong together or are not finite, and for
/// segments of an unknown kind.
control::ArmGrasp arm_grasp_from_message(const msgs::Grasp& grasp);
/// The same of GraspPlan::probe. @param X_HG of its preshape's tool in the hand's root.
/// @throws as arm_grasp_from_message(), and for a fingertip that is nowhere.
control::ArmGrasp probe_from_message(const msgs::Grasp& probe,
                                     const geometry::RigidTransform& X_HG);
/// The same of GraspPlan::push. @throws as arm_grasp_from_message().
control::ArmGrasp push_from_message(const msgs::Grasp& push);
/// The arm's segments, and how the hand closes and how hard.
void add_motion(const control::ArmGrasp& grasp, msgs::Grasp* message);

/// What a cycle goes by: the best of a plan's choices; without any it grasps.
/// @throws geometry::InputError for an act that is not known, or a grasp that the plan does not
/// have.
control::Advice advice_of(const msgs::GraspPlan& plan);

/// @param stamp ns, of the graph's clock.
msgs::Surprise to_message(const control::Surprise& surprise, std::int64_t stamp);
/// Fills everything but the object.
msgs::CycleResult to_message(const control::CycleResult& result, std::int64_t stamp);
/// The same with surprises, times and the task's path.
msgs::CycleResult to_message(const control::Cycle& cycle, std::int64_t stamp);
msgs::Task to_message(const control::Task& task, std::int64_t stamp);

}  // namespace prehend::convert

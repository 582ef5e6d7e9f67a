#pragma once

#include "prehend/geometry/plane.h"
#include "prehend/grasp/grasp.h"
#include "prehend/grasp/planner_options.h"
#include "prehend/surface/object_model.h"

namespace prehend::grasp {

/// Plans grasps of one object with a hand: makes candidates, closes the hand at each in each of its
/// preshapes on the predicted mesh by the hand's way (closing/closing.h), and keeps what reaches,
/// meets nothing on the way, holds the object by force closure and carries its weight. Whatever is
/// refused is counted with its reason and nearest miss. The best are closed again in disturbed
/// poses, with other friction, and on `object.alternatives_W`: other shapes that the object may
/// have as well.
///
/// Reentrant. Same input, same result, bit by bit, unless there is a budget.
/// @throws geometry::InputError for a mesh without triangles or volume, with NaN or bad indices, or
/// for an unknown preshape (with the nearest); std::invalid_argument for options out of range.
GraspPlan plan_grasps(const surface::ObjectModel& object, const geometry::Plane& table,
                      const Obstacles& obstacles, const HandToClose& hand,
                      const Reachability& reachability, const PlannerOptions& options);
/// The same with a parallel gripper alone, see robot::parallel_hand().
GraspPlan plan_grasps(const surface::ObjectModel& object, const geometry::Plane& table,
                      const Obstacles& obstacles, const robot::GripperModel& gripper,
                      const Reachability& reachability, const PlannerOptions& options = {});

}  // namespace prehend::grasp
